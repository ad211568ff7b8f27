"""Names without end do not widen a window."""

import pytest
from PySide6.QtWidgets import QVBoxLayout, QWidget

from georibbon.gui.log import Banner
from georibbon.gui.notifier import Notifier
from georibbon.gui.review.told import ToldLine

ENDLESS = "/a/" + "n" * 300 + ".georibbon: it cannot be read"


def told():
    line = ToldLine()
    line.tell(ENDLESS, "poor")
    return line


def banner():
    made, notifier = Banner(), Notifier()
    notifier.listen(made.show_entry)
    notifier.tell("error", ENDLESS)
    return made


@pytest.mark.parametrize("make", [told, banner])
def test_a_window_stays_as_narrow_as_it_was(qtbot, make):
    window = QWidget()
    qtbot.addWidget(window)
    QVBoxLayout(window).addWidget(make())
    window.resize(400, 100)
    with qtbot.waitExposed(window):
        window.show()
    assert window.width() == 400
    assert window.minimumSizeHint().width() < 400
