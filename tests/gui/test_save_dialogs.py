"""Where a person saves what: endings, files that are there, and a section's table."""

from types import SimpleNamespace

import numpy as np
import pytest
from PySide6.QtCore import Qt, QTimer
from PySide6.QtWidgets import QApplication, QFileDialog, QLineEdit, QMessageBox, QWidget

from georibbon.gui import dialogs
from georibbon.gui.notifier import Notifier
from georibbon.gui.section_file import save_section
from georibbon.gui.settings import Settings
from georibbon.gui.window import MainWindow


@pytest.fixture
def parent(qtbot):
    """A window that asks."""
    made = QWidget()
    qtbot.addWidget(made)
    made.show()
    return made


@pytest.fixture(autouse=True)
def own_dialogs():
    """Qt's own dialogs, which can be driven."""
    QApplication.setAttribute(Qt.ApplicationAttribute.AA_DontUseNativeDialogs, True)
    yield
    QApplication.setAttribute(Qt.ApplicationAttribute.AA_DontUseNativeDialogs, False)


def answering(name, over=None):
    """Types a name into the dialog that will come; over: whether a file may be written over."""
    asked = []

    def answer_question():
        question = QApplication.activeModalWidget()
        if isinstance(question, QMessageBox):
            asked.append(question.text())
            button = QMessageBox.StandardButton.Yes if over else QMessageBox.StandardButton.No
            question.button(button).click()

    def answer():
        dialog = QApplication.activeModalWidget()
        assert isinstance(dialog, QFileDialog)
        dialog.findChild(QLineEdit, "fileNameEdit").setText(name)
        soon = QTimer(dialog, singleShot=True, interval=50)  # goes with it where nothing is asked
        soon.timeout.connect(answer_question)
        soon.start()
        dialog.accept()
        if dialog.isVisible():
            dialog.reject()

    QTimer.singleShot(0, answer)
    return asked


def ask(parent, folder):
    return dialogs.ask_target(parent, folder / "view.png", "Save picture", "Pictures (*.png)")


@pytest.mark.parametrize(
    ("typed", "found"), [("a", "a.png"), ("b.PNG", "b.PNG"), ("ü λ", "ü λ.png")]
)
def test_a_name_gets_the_ending_that_is_missing(parent, tmp_path, typed, found):
    assert answering(str(tmp_path / typed)) == []
    assert ask(parent, tmp_path) == tmp_path / found


@pytest.mark.parametrize("over", [True, False])
def test_a_file_that_is_there_is_asked_for_with_its_ending(parent, tmp_path, over):
    (tmp_path / "mine.png").write_text("kept")
    asked = answering(str(tmp_path / "mine"), over)
    assert ask(parent, tmp_path) == (tmp_path / "mine.png" if over else None)
    assert len(asked) == 1
    assert "mine.png" in asked[0]


@pytest.fixture
def section():
    """Three points of a section."""
    line = np.array([0.0, 0.1, 0.2])
    points = np.stack((line, 0 * line, line**2), axis=1)
    return SimpleNamespace(s=line, across=line, height=line**2, points=points)


def test_a_section_is_written_as_a_table_in_metres(parent, tmp_path, section, monkeypatch):
    target, told = tmp_path / "cut.csv", []
    monkeypatch.setattr(dialogs, "ask_target", lambda *_: target)
    notifier = Notifier()
    notifier.listen(told.append)
    save_section(parent, notifier, tmp_path, section)
    head, *rows = target.read_text(encoding="utf-8").splitlines()
    assert head == "s,across,height,x,y,z"
    assert np.allclose([float(row.split(",")[2]) for row in rows], section.height)
    assert [entry.level for entry in told] == ["info"]


@pytest.mark.parametrize("name", ["no/such.csv", "cut.txt"])
def test_a_section_that_cannot_be_written_is_told(parent, tmp_path, section, monkeypatch, name):
    monkeypatch.setattr(dialogs, "ask_target", lambda *_: tmp_path / name)
    notifier, told = Notifier(), []
    notifier.listen(told.append)
    save_section(parent, notifier, tmp_path, section)
    assert [entry.level for entry in told] == ["error"]
    assert list(tmp_path.iterdir()) == []


def test_who_thinks_better_writes_nothing(parent, tmp_path, section, monkeypatch):
    monkeypatch.setattr(dialogs, "ask_target", lambda *_: None)
    save_section(parent, Notifier(), tmp_path, section)
    assert list(tmp_path.iterdir()) == []


def test_the_views_panel_leads_to_the_file(qtbot, tmp_path, section, monkeypatch):
    target = tmp_path / "cut.csv"
    monkeypatch.setattr(dialogs, "ask_target", lambda *_: target)
    window = MainWindow(Settings(tmp_path / "settings.ini"), Notifier())
    qtbot.addWidget(window)
    window.view_panel.section_export.emit(section)
    assert target.is_file()
