"""What is shown, one scene after the other, as a person comes by it."""

from collections.abc import Callable
from pathlib import Path

import prepare
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QLineEdit
from stage import Stage

from georibbon.gui.scene_view import COLOURINGS

LEFT = Qt.MouseButton.LeftButton
SMALL = (1024, 700)
LOOKED_AT = ((0.35, 0.38), (0.58, 0.32))  # places of the 3D view that lie on the surface


def start(stage: Stage) -> None:
    """The start page, with what was opened last."""
    stage.take("start")


def connect(stage: Stage) -> None:
    """What to connect to, then the virtual ribbon and what its sensors say."""
    window = stage.window
    window.show_page("connect")
    stage.take("connect")
    window.station.connect_virtual(prepare.virtual_settings())
    stage.wait(lambda: window.station.identity is not None, "the virtual ribbon")
    stage.rest(1200)
    stage.take("connected")


def calibrate(stage: Stage) -> None:
    """From the beginning of a calibration to its end, and the daily check."""
    window = stage.window
    window.show_page("calibrate")
    page = window.pages.page("calibrate")
    stage.wait(lambda: page.start.kept.table.rowCount() == 2, "the kept calibrations")
    page.start.kept.table.selectRow(0)
    stage.take("calibrate-start")
    _poses(stage, page)
    _done(stage, page)
    _check(stage, page)


def _go_on(stage: Stage, page, name: str) -> None:
    """Go on with one of the prepared calibrations."""
    (page.shelf.folder / prepare.SESSIONS / f"calibration {name}.georibbon").touch()
    page.show_kept()
    stage.wait(page.start.go_on_button.isEnabled, "the calibration that was begun")
    page.start.go_on_button.click()
    stage.wait(lambda: _captures(stage), "the calibration")


def _captures(stage: Stage) -> bool:
    """Whether a capture goes on."""
    return stage.window.capture.active


def _poses(stage: Stage, page) -> None:
    """Some poses taken, one refused, another one lying there."""
    window, posing = stage.window, page.posing
    _go_on(stage, page, "begun")
    stage.wait(lambda: page._found is not None, "the calibration's quality")
    stage.hurry()
    window.hands.lay_wrongly()
    stage.wait(lambda: posing.progress.refused, "the refusal")
    window.capture.set_auto(False)
    stage.wait(lambda: not window.capture.auto, "the button")
    posing.choose_next()
    stage.rest()
    window.hands.lay()
    stage.rest(900)
    stage.calm_down()
    stage.take("calibrate-poses")
    posing.what.setCurrentIndex(1)
    stage.take("calibrate-field")
    page.stop()


def _done(stage: Stage, page) -> None:
    """All are taken: how good it is, and its name."""
    _go_on(stage, page, "whole")
    stage.wait(lambda: page.stack.currentWidget() is page.done, "the calibration's end")
    stage.take("calibrate-done")
    page.stop()


def _check(stage: Stage, page) -> None:
    """The daily check."""
    window = stage.window
    page.start.kept.table.selectRow(0)
    stage.hurry()
    window.hands.follow.setChecked(True)
    window.hands.pause.setValue(0.0)
    page.begin_check()
    stage.wait(lambda: _captures(stage), "the daily check")
    stage.wait(page.posing.check.table.isVisible, "the check's verdict")
    window.hands.follow.setChecked(False)
    stage.calm_down()
    stage.take("daily-check")
    page.stop()


def capture(stage: Stage) -> None:
    """The plan, a pass that lies there, the survey."""
    window = stage.window
    window.show_page("capture")
    page = window.pages.page("capture")
    page.plan.title.setText("left door")
    page.plan.ties.setValue(2)
    stage.wait(lambda: page.plan._forecast is not None, "the forecast")
    stage.take("capture-plan")
    window.capture.begin(stage.home / prepare.PART, auto=False)
    stage.wait(lambda: _captures(stage), "the capture")
    stage.wait(lambda: window.document.reconstruction is not None, "the first surface")
    stage.hurry()
    window.hands.lay()
    stage.rest(900)
    stage.calm_down()
    stage.wait(page.view.angle.text, "the live curve")
    stage.take("capture-live")
    page.view.tabs.setCurrentWidget(page.view.survey)
    stage.take("capture-survey")
    page.view.tabs.setCurrentIndex(0)
    window.finish_capture()


def review(stage: Stage) -> None:
    """The panels around a surface."""
    window = stage.window
    window.station.disconnect()
    before = window.document.reconstruction
    window.open(stage.home / prepare.BONNET)
    stage.wait(lambda: window.document.reconstruction not in (None, before), "the surface")
    stage.rest(300)
    stage.take("review")
    for name in ("surface", "view", "history", "log", "checks"):
        window.docks[name].raise_()
        stage.take(f"review-{name}")
    stage.take("panel-checks", window.docks["checks"])
    window.docks["passes"].raise_()
    window.docks["curves"].raise_()
    _choose_pass(stage)
    for mode in COLOURINGS:
        if mode not in ("deviation", "uncertainty"):  # that one is the compare window's
            window.view.set_colouring(mode)
            stage.take(f"colours-{mode}")
    window.view.set_colouring("uncertainty")
    _tools(stage)
    _curves(stage)


def _choose_pass(stage: Stage) -> None:
    """A pass chosen, with what is known of it."""
    window = stage.window
    window.passes_panel.table.selectRow(1)
    stage.take("review-pass")
    stage.take("panel-passes", window.docks["passes"])
    window.passes_panel.table.clearSelection()


def _tools(stage: Stage) -> None:
    """Points, distances and sections that were picked."""
    window, view = stage.window, stage.window.view
    window.docks["view"].raise_()
    for tool in ("point", "distance", "section"):
        view.set_tool(tool)
        before = window.view_panel.results.count()
        for x, y in LOOKED_AT[: 1 if tool == "point" else 2]:
            QTest.mouseClick(view, LEFT, pos=QPoint(int(x * view.width()), int(y * view.height())))
            stage.rest(50)
        stage.wait(lambda n=before: window.view_panel.results.count() > n, f"the tool {tool}")
        stage.take(f"tool-{tool}")
    view.set_tool("none")
    window.view_panel.clear()
    window.docks["passes"].raise_()


def _curves(stage: Stage) -> None:
    """The curve panel with several quantities."""
    window = stage.window
    panel = window.results.curves
    for name, chosen in (
        ("curves-torsion", ("torsion", "uncertainty")),
        ("curves-residuals", ("residuals", "raw")),
    ):
        panel.show_quantities(chosen)
        stage.take(name)
    panel.show_quantities(("curvature",))
    stage.take("panel-curves", window.docks["curves"])


def dialogs(stage: Stage) -> None:
    """Every dialog over the review."""
    from georibbon.gui.dialogs import PictureDialog, ask_discard
    from georibbon.gui.review.export_dialog import KINDS, ExportDialog

    window = stage.window
    for kind in KINDS:
        window.export(kind)
        dialog = window.findChild(ExportDialog)
        stage.wait(lambda one=dialog: not one._painter.is_busy, "the preview")
        stage.rest(150)
        dialog.place.setText(f"~/captures/{Path(dialog.place.text()).name}")
        stage.take(f"export-{kind}", dialog)
        dialog.reject()
        stage.rest(50)
    window.show_settings()
    stage.take("settings", _dialog(stage))
    _dialog(stage).reject()
    window.show_palette()
    QTest.keyClicks(_dialog(stage).findChild(QLineEdit), "colour")
    stage.take("palette", _dialog(stage))
    _dialog(stage).reject()
    picture = PictureDialog(window)
    picture.open()
    stage.take("picture", picture)
    picture.reject()
    picture.deleteLater()
    stage.take_dialog("about", window.about)
    stage.take_dialog("discard", lambda: ask_discard(window, "The disk is full."))


def _dialog(stage: Stage):
    from PySide6.QtWidgets import QApplication

    stage.wait(lambda: QApplication.activeModalWidget() is not None, "the dialog")
    return QApplication.activeModalWidget()


def compare(stage: Stage) -> None:
    """Another session beside it."""
    window = stage.window
    found = window.compare()
    found.compare_with(stage.home / prepare.NEXT)
    stage.wait(lambda: found._comparison is not None, "the comparison")
    stage.rest(200)
    stage.take("compare", found)
    found.close()
    stage.rest(200)
    stage.take("colours-deviation")
    window.view.set_colouring("uncertainty")


def manual(stage: Stage) -> None:
    """The manual: a page with a picture, the keys, and a search."""
    window = stage.window
    window.show_help()
    book = window._manual()
    for topic in ("start", "capture", "keyboard"):
        book.open_at(topic)
        stage.take(f"manual-{topic}", book)
    book.words.setText("smoothing")
    stage.take("manual-search", book)
    book.words.clear()
    book.close()


def trouble(stage: Stage) -> None:
    """What is seen when something goes wrong."""
    window = stage.window
    window.open(stage.home / "not there.georibbon")
    stage.wait(window.banner.isVisible, "the message")
    stage.take("error")
    window.docks["log"].raise_()
    stage.take("error-log")
    window.banner.hide()
    window.docks["curves"].raise_()
    try:
        raise ValueError("an example of a fault, made for this picture")
    except ValueError as error:
        window.notifier.exception(error)
    stage.wait(lambda: window.crashes.window is not None, "the crash report")
    stage.take("crash", window.crashes.window)
    window.crashes.window.close()
    window.banner.hide()


def small(stage: Stage) -> None:
    """Every page in a small window."""
    window = stage.window
    for name in ("review", "start", "connect", "calibrate", "capture"):
        window.show_page(name)
        stage.rest(100)
        stage.resize(*SMALL)
        stage.take(f"small-{name}")


SCENES: tuple[Callable[[Stage], None], ...] = (
    start, connect, calibrate, capture, review, dialogs, compare, manual, trouble, small,
)  # fmt: skip
NAMES = (
    "start", "connect", "connected",
    "calibrate-start", "calibrate-poses", "calibrate-field", "calibrate-done", "daily-check",
    "capture-plan", "capture-live", "capture-survey",
    "review", "review-surface", "review-view", "review-history", "review-log", "review-checks",
    "review-pass",
    "panel-passes", "panel-curves", "panel-checks", "curves-torsion", "curves-residuals",
    "colours-gaussian", "colours-mean", "colours-normal", "colours-deviation", "colours-zebra",
    "colours-plain", "tool-point", "tool-distance", "tool-section",
    "export-surface", "export-curves", "export-report", "export-recording",
    "settings", "palette", "picture", "about", "discard", "compare",
    "manual-start", "manual-capture", "manual-keyboard", "manual-search",
    "error", "error-log", "crash",
    "small-review", "small-start", "small-connect", "small-calibrate", "small-capture",
)  # fmt: skip
