"""Lengths in the unit in use: the same length in all of them, typed and shown."""

import pytest
from hypothesis import given
from hypothesis import strategies as some
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from georibbon.gui.language import tr, trn, use
from georibbon.gui.length_box import LengthBox
from georibbon.gui.units import UNITS, Units


@given(some.sampled_from(sorted(UNITS)), some.floats(1e-6, 10.0))
def test_a_length_in_a_unit_and_back_is_the_same_length(symbol, metres):
    units = Units(symbol)
    assert units.metres(units.value(metres)) == pytest.approx(metres)


@pytest.mark.parametrize(
    ("symbol", "shown"), [("mm", "25.4 mm"), ("cm", "2.54 cm"), ("in", "1.000 in")]
)
def test_an_inch_in_every_unit(symbol, shown):
    assert Units(symbol).text(0.0254) == shown


def test_an_unknown_unit_is_none():
    assert Units("furlong").symbol == "mm"
    with pytest.raises(KeyError):
        Units().use("furlong")


def test_the_box_follows_the_unit_and_keeps_the_length(qtbot):
    units = Units()
    box = LengthBox(units, 0.001, 1.0)
    qtbot.addWidget(box)
    box.set_metres(0.0254)
    assert box.text() == "25.40 mm"
    units.use("in")
    assert (box.text(), box.metres) == ("1.0000 in", 0.0254)


def test_a_typed_length_is_told_once_in_metres(qtbot):
    units = Units("cm")
    box = LengthBox(units, 0.001, 1.0)
    qtbot.addWidget(box)
    told = []
    box.edited.connect(told.append)
    box.selectAll()
    QTest.keyClicks(box, "2.5")
    assert told == []
    QTest.keyClick(box, Qt.Key.Key_Return)
    assert told == [pytest.approx(0.025)]


def test_english_is_the_text_itself():
    use("xx")
    assert tr("{n} of {all} poses", n=3, all=20) == "3 of 20 poses"
    assert [trn("{n} pass", "{n} passes", n) for n in (1, 2)] == ["1 pass", "2 passes"]
