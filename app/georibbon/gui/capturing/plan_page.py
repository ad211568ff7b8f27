"""The plan of a capture: what is laid and measured, drawn, and what accuracy it will give."""

import datetime
from dataclasses import dataclass, replace
from pathlib import Path

from PySide6.QtCore import QSignalBlocker, QStandardPaths, Qt, QTimer, Signal
from PySide6.QtGui import QFont
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QFormLayout,
    QFrame,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QPushButton,
    QScrollArea,
    QSizePolicy,
    QSpinBox,
    QVBoxLayout,
    QWidget,
)

from georibbon.calibration.model import Calibration
from georibbon.calibration.plans import PLANS
from georibbon.capture.laying import LIKENESSES, Likeness
from georibbon.capture.plan import (
    MOST_PLACES,
    SPACINGS,
    CapturePlan,
    PlannedLayout,
    read_plan,
    write_plan,
)
from georibbon.errors import GeoribbonError, SettingsError
from georibbon.gui import dialogs
from georibbon.gui.capturing.board import Words
from georibbon.gui.capturing.latest import Latest, Stop
from georibbon.gui.capturing.model import is_calibration
from georibbon.gui.capturing.plan_drawing import PlanDrawing
from georibbon.gui.files import calibrations_folder
from georibbon.gui.language import N_, tr, trn
from georibbon.gui.language import sentence as spoken
from georibbon.gui.length_box import LengthBox
from georibbon.gui.parts import Parts
from georibbon.session.calibration_file import read_calibration
from georibbon.session.calibration_shelf import Shelf

PLAN_FILES = "Plans (*.toml)"
CALIBRATION_FILES = "Calibrations (*.json)"
SESSION_SUFFIX = ".georibbon"
PAUSE = 150  # ms without a change before a forecast is begun
LIKE = {
    "flat": N_("a flat panel"),
    "gentle": N_("gently curved, like a car bonnet"),
    "bent": N_("strongly bent, like a pipe"),
}
MARKS = (
    N_("none"),
    N_("the start of each pass"),
    N_("start and end of each pass"),
)
KEPT_LAYOUT = ("spacing", "mark_sigma", "distance_sigma", "crossing_sigma")
MOST_PASSES, MOST_TIES = 200, 50
LONGEST_TITLE = 200
SIGMAS = (1e-5, 0.1)  # m


@dataclass(frozen=True, eq=False)
class _Source:
    """Where the calibration comes from: so many poses first, or one that is there, of a name."""

    poses: int
    calibration: Calibration | None = None
    name: str = ""


class PlanPage(QWidget):
    """The first step of a capture.

    wanted(page): a person is led to another page.  left_for_capture(): back to
    the capture that goes on.
    """

    wanted = Signal(str)
    left_for_capture = Signal()

    def __init__(
        self, parts: Parts, parent: QWidget | None = None, folder: Path | None = None
    ) -> None:
        super().__init__(parent)
        self._parts = parts
        self._shelf = Shelf(calibrations_folder() if folder is None else folder)
        self._base = CapturePlan()  # what a plan file says besides: workpiece and survey
        self._chose = False  # whether a person chose a calibration
        self._path: Path | None = None  # where a person chose it to be
        self._latest = Latest("forecast", self)
        self._timer = QTimer(self)
        self._timer.setSingleShot(True)
        self._timer.setInterval(PAUSE)
        self._timer.timeout.connect(self._begin_forecast)
        self._forecast = None
        self._make()
        self._lay_out()
        self._connect()
        self._take_remembered()
        self._show_ribbon()
        self._follow_capture()

    # --- what is planned ---

    @property
    def plan(self) -> CapturePlan:
        """The plan as it is shown; SettingsError where it cannot be captured."""
        title = "".join(sign for sign in self.title.text() if sign.isprintable()).strip()
        return replace(
            self._base,
            poses=self._source().poses,
            passes=self.passes.value(),
            ties=self.ties.value(),
            title=title or None,
            layout=PlannedLayout(
                spacing=self.spacing.metres,
                marks=self.marks.currentIndex(),
                mark_sigma=self.mark_sigma.metres,
                distances=self.distances.value(),
                distance_sigma=self.distance_sigma.metres,
                crossing_sigma=self.crossing_sigma.metres,
            ),
        )

    @property
    def path(self) -> Path:
        """The session's file: as it was chosen, or a proposal that nobody has yet."""
        return self._path or self._proposal()

    @property
    def likeness(self) -> Likeness:
        """What the object is like."""
        return self.like.currentData()

    def follow(self, plan: CapturePlan) -> None:
        """Show what is planned of a capture that goes on."""
        self.show_plan(plan)

    def show_plan(self, plan: CapturePlan) -> None:
        """Show a plan."""
        self._base = plan
        boxes = (self.passes, self.ties, self.marks, self.distances)
        blockers = [QSignalBlocker(box) for box in boxes]
        self.passes.setValue(plan.passes)
        self.ties.setValue(plan.ties)
        self.marks.setCurrentIndex(plan.layout.marks)
        self.distances.setValue(plan.layout.distances)
        del blockers
        for name in KEPT_LAYOUT:
            getattr(self, name).set_metres(getattr(plan.layout, name))
        if plan.title:
            self.title.setText(plan.title)
        self._changed()

    # --- making ---

    def _make(self) -> None:
        units = self._parts.units
        self.title = QLineEdit()
        self.title.setMaxLength(LONGEST_TITLE)
        self.title.setPlaceholderText(tr("what is captured, as “bonnet”"))
        self.file = QLabel()
        self.file.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.file.setWordWrap(True)
        self.file.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Minimum)
        self.choose_file = QPushButton(tr("Choose fi&le…"))
        self.ribbon = QLabel()
        self.ribbon.setWordWrap(True)
        self.connect = QPushButton(tr("C&onnect…"))
        self.calibration = QComboBox()
        self.calibration.setSizeAdjustPolicy(
            QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon
        )
        self.calibration.setMinimumContentsLength(14)
        self.choose_calibration = QPushButton(tr("F&rom a file…"))
        self.like = QComboBox()
        for name in LIKENESSES:
            self.like.addItem(tr(LIKE[name]), name)
        self.like.setCurrentIndex(LIKENESSES.index("gentle"))
        self.passes = _spin(1, MOST_PASSES, 5)
        self.ties = _spin(0, MOST_TIES, 0)
        self.distances = _spin(0, MOST_PLACES, 0)
        self.distances.setSpecialValueText(tr("none"))
        self.ties.setSpecialValueText(tr("none"))
        self.marks = QComboBox()
        for words in MARKS:
            self.marks.addItem(tr(words))
        for n in range(len(MARKS), MOST_PLACES + 1):
            self.marks.addItem(tr("{n} points of each pass", n=n))
        self.spacing = LengthBox(units, *SPACINGS, 0.01)
        self.mark_sigma = LengthBox(units, *SIGMAS, 1e-4)
        self.distance_sigma = LengthBox(units, *SIGMAS, 1e-4)
        self.crossing_sigma = LengthBox(units, *SIGMAS, 1e-4)
        self.auto = QCheckBox(tr("Take b&y stillness, without a key"))
        self.auto.setChecked(self._parts.settings.get("capture/auto", True))
        self.load = QPushButton(tr("Load pla&n…"))
        self.save = QPushButton(tr("Save plan…"))
        self.start = QPushButton(tr("&Start capture"))
        self.start.setDefault(True)
        self.start.setMinimumHeight(40)
        font = QFont(self.start.font())
        font.setBold(True)
        self.start.setFont(font)
        self.go_on = QPushButton(tr("&Go on with the session that is open"))
        self.problem = Words()
        self.problem.setAccessibleName(tr("What is wrong with the plan"))
        self.drawing = PlanDrawing(units)
        self.figure = Words(2.1, bold=True)
        self.figure.setAccessibleName(tr("Expected accuracy"))
        self.told = Words()
        self.told.setAccessibleName(tr("What the accuracy depends on"))
        self.told.setTextFormat(Qt.TextFormat.PlainText)

    def _lay_out(self) -> None:
        form = QFormLayout()
        form.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.ExpandingFieldsGrow)
        form.setVerticalSpacing(7)
        _row(form, tr("&Title"), self.title)
        form.addRow(tr("Session file"), _beside(self.file, self.choose_file))
        form.addRow(tr("Ribbon"), _beside(self.ribbon, self.connect))
        _row(form, tr("C&alibration"), self.calibration, self.choose_calibration)
        form.addRow(_line())
        _row(form, tr("&Passes"), self.passes)
        _row(form, tr("Spa&cing"), self.spacing)
        _row(form, tr("T&ies across them"), self.ties)
        _row(form, tr("   crossings read to"), self.crossing_sigma)
        _row(form, tr("&Marks"), self.marks)
        _row(form, tr("   measured to"), self.mark_sigma)
        _row(form, tr("&Distances to the next"), self.distances)
        _row(form, tr("   measured to"), self.distance_sigma)
        form.addRow(_line())
        _row(form, tr("The object is li&ke"), self.like)
        form.addRow("", self.auto)
        files = QHBoxLayout()
        files.addWidget(self.load)
        files.addWidget(self.save)
        files.addStretch(1)
        inner = QWidget()
        left = QVBoxLayout(inner)
        left.addLayout(form)
        left.addLayout(files)
        left.addStretch(1)
        scroll = QScrollArea()
        scroll.setWidgetResizable(True)
        scroll.setFrameShape(QFrame.Shape.NoFrame)
        scroll.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        scroll.setWidget(inner)
        scroll.setMinimumWidth(inner.minimumSizeHint().width() + 20)
        side = QVBoxLayout()
        side.addWidget(scroll, 1)
        side.addWidget(self.problem)
        side.addWidget(self.go_on)
        side.addWidget(self.start)
        right = QVBoxLayout()
        right.addWidget(self.drawing, 3)
        right.addWidget(self.figure)
        right.addWidget(self.told)
        grid = QGridLayout(self)
        grid.setContentsMargins(16, 12, 16, 12)
        grid.setHorizontalSpacing(18)
        grid.addLayout(side, 0, 0)
        grid.addLayout(right, 0, 1)
        grid.setColumnStretch(0, 2)
        grid.setColumnStretch(1, 3)

    def _connect(self) -> None:
        parts = self._parts
        for box in (self.passes, self.ties, self.distances):
            box.valueChanged.connect(self._changed)
        for box in (self.marks, self.like, self.calibration):
            box.currentIndexChanged.connect(self._changed)
        for name in KEPT_LAYOUT:
            getattr(self, name).edited.connect(self._changed)
        self.calibration.activated.connect(self._choose_calibration)
        self.title.textChanged.connect(self._show_file)
        self.auto.toggled.connect(lambda on: parts.settings.put("capture/auto", on))
        self.load.clicked.connect(self.ask_load)
        self.save.clicked.connect(self.ask_save)
        self.choose_file.clicked.connect(self.ask_file)
        self.choose_calibration.clicked.connect(self.ask_calibration)
        self.connect.clicked.connect(lambda: self.wanted.emit("connect"))
        self.start.clicked.connect(self.begin)
        self.go_on.clicked.connect(self.begin_again)
        self._latest.done.connect(self._show_forecast)
        self._latest.failed.connect(self._show_failure)
        parts.station.identified.connect(self._show_ribbon)
        parts.station.disconnected.connect(self._show_ribbon)
        parts.document.changed.connect(self._follow_capture)
        parts.capture.began.connect(self._follow_capture)
        parts.capture.ended.connect(self._follow_capture)
        parts.capture.failed.connect(self._refuse)
        parts.units.changed.connect(self._changed)

    # --- what a person does ---

    def begin(self) -> None:
        """Begin a new capture by this plan, or take it up in the capture that goes on."""
        if self._parts.capture.beginning:  # a second click on the way
            return
        try:
            plan = self.plan
        except SettingsError as error:
            self._refuse(str(error))
            return
        self._remember(plan)
        capture = self._parts.capture
        if capture.active:
            capture.set_plan(replace(plan, poses=capture.plan.poses))
            self.left_for_capture.emit()
            return
        path = self.path
        if path.exists():  # somebody else's by now: nothing is ever overwritten
            self._refuse(
                tr("{path} is there already; choose another name, or open it and go on", path=path)
            )
            return
        self._refuse("")
        capture.begin(path, plan, self._source().calibration, self.auto.isChecked())

    def begin_again(self) -> None:
        """Go on with the session that is open, by what it says is planned."""
        path, capture = self._parts.document.path, self._parts.capture
        if path is not None and not capture.active and not capture.beginning:
            self._refuse("")
            capture.begin(path, None, None, self.auto.isChecked())

    def ask_load(self) -> None:
        """Load a plan from a file."""
        path = ask_plan(self, self._folder())
        if path is None:
            return
        try:
            self.show_plan(read_plan(path))
        except GeoribbonError as error:
            self._refuse(str(error))

    def ask_save(self) -> None:
        """Save the plan to a file."""
        name = self.title.text().strip() or "plan"
        proposal = self._folder() / f"{_file_name(name)}.toml"
        path = dialogs.ask_target(self, proposal, tr("Save plan"), PLAN_FILES)
        if path is None:
            return
        try:
            write_plan(self.plan, path)
        except GeoribbonError as error:
            self._refuse(str(error))

    def ask_file(self) -> None:
        """Choose where the session is kept."""
        filters = dialogs.SESSIONS
        path = dialogs.ask_target(self, self.path, tr("Keep the capture in"), filters)
        if path is not None:
            self._path = path
            self._show_file()

    def ask_calibration(self) -> None:
        """Take a calibration out of a file."""
        path = ask_calibration_file(self, self._folder())
        if path is None:
            return
        try:
            calibration = read_calibration(path)
        except GeoribbonError as error:
            self._refuse(str(error))
            return
        self.use_calibration(calibration, path.stem)
        self._refuse("")

    def use_calibration(self, calibration: Calibration, name: str) -> None:
        """Choose a calibration that is not among those that are kept."""
        self._chose = True
        self.calibration.insertItem(0, name, _Source(0, calibration, name))
        self.calibration.setCurrentIndex(0)

    def entered(self) -> None:
        """Comes into sight: what was kept meanwhile can be chosen."""
        self._show_ribbon()
        self._follow_capture()

    def end(self) -> None:
        """Nothing of it goes on."""
        self._timer.stop()
        self._latest.drop()

    # --- showing ---

    def _source(self) -> _Source:
        found = self.calibration.currentData()
        return found if found is not None else _Source(20)

    def _show_ribbon(self, *_: object) -> None:
        identity = self._parts.station.identity
        self.connect.setVisible(identity is None)
        if identity is None:
            self.ribbon.setText(tr("none is connected"))
        else:
            of = identity.ribbon
            self.ribbon.setText(
                tr(
                    "{id}: {sensors} sensors, {length} long",
                    id=of.id,
                    sensors=len(of.sensors),
                    length=self._parts.units.text(of.length),
                )
            )
        self._fill_calibrations()
        self._follow_capture()
        self._changed()

    def _fill_calibrations(self) -> None:
        """Those of the ribbon that are kept, the newest first, then poses; the choice stays."""
        identity, before = self._parts.station.identity, self._source()
        kept = () if identity is None else self._shelf.look()[0]
        sources = [
            _Source(0, one.calibration, one.name)
            for one in kept
            if one.calibration.ribbon_id == identity.ribbon.id
        ]
        names = [one.name for one in sources]
        if before.calibration is not None and before.name not in names:
            sources.insert(0, before)
        sources += [_Source(poses) for poses in sorted(PLANS, reverse=True)]
        with QSignalBlocker(self.calibration):
            self.calibration.clear()
            for one in sources:
                words = trn("{n} pose first", "{n} poses first", one.poses)
                self.calibration.addItem(one.name or words, one)
            same = [(one.poses, one.name) for one in sources]
            if self._chose and (before.poses, before.name) in same:
                self.calibration.setCurrentIndex(same.index((before.poses, before.name)))

    def _follow_capture(self, *_: object) -> None:
        capture, document = self._parts.capture, self._parts.document
        going_on = capture.active
        self._refuse("")
        self.start.setText(tr("&Go on by this plan") if going_on else tr("&Start capture"))
        connected = self._parts.station.identity is not None
        self.start.setEnabled(going_on or connected)
        if is_calibration(capture):
            self.start.setEnabled(False)
            self._refuse(tr("A calibration goes on; finish it on its page first."))
        open_one = not going_on and self._can_go_on()
        self.go_on.setVisible(open_one)
        self.go_on.setEnabled(connected)
        if open_one:
            self.go_on.setText(tr("&Go on with {title}", title=document.title))
        for widget in (self.title, self.choose_file, self.calibration, self.choose_calibration):
            widget.setEnabled(not going_on)
        self._show_file()

    def _can_go_on(self) -> bool:
        """Whether a session is open that is more than a calibration, which has its own page."""
        session = self._parts.document.session
        if session is None:
            return False
        state = session.state
        planned = state.plan is not None and state.plan.passes + state.plan.ties > 0
        return planned or bool(state.passes) or not state.poses

    def _choose_calibration(self, _index: int) -> None:
        self._chose = True

    def _show_file(self, *_: object) -> None:
        capture = self._parts.capture
        path = capture.session.path if capture.active else self.path
        self.file.setText(path.name)
        self.file.setToolTip(str(path))

    def _changed(self, *_: object) -> None:
        for box, there in (
            (self.crossing_sigma, self.ties.value() > 0),
            (self.mark_sigma, self.marks.currentIndex() > 0),
            (self.distance_sigma, self.distances.value() > 0),
        ):
            box.setEnabled(there)
        self.drawing.show_plan(self.plan, self._ribbon().length)
        self._latest.drop()
        self._timer.start()

    def _ribbon(self):
        """The ribbon that is connected, or an ordinary one."""
        identity = self._parts.station.identity
        if identity is not None:
            return identity.ribbon
        from georibbon.simulation.settings import RibbonSettings
        from georibbon.simulation.virtual import virtual_ribbon

        return virtual_ribbon(RibbonSettings())

    def _begin_forecast(self) -> None:
        plan, ribbon, likeness, source = self.plan, self._ribbon(), self.likeness, self._source()

        def work(stop: Stop) -> object:
            from georibbon.capture.forecast import forecast, usual_calibration

            calibration = source.calibration
            if calibration is None or calibration.ribbon_id != ribbon.id:
                calibration = usual_calibration(ribbon, source.poses)
            return forecast(ribbon, calibration, plan, likeness, stop)

        self.told.setText(tr("computing the accuracy…"))
        self._latest.ask(work)

    def _show_forecast(self, forecast) -> None:
        self._forecast = forecast
        units, figures = self._parts.units, forecast.figures
        words = tr("about {rms} expected", rms=units.text(figures.rms))
        if forecast.aligned:
            words = tr("about {rms} of shape expected", rms=units.text(figures.rms))
        self.figure.say(words, _grade(figures.rms))
        self.told.setText("\n".join(self._sentences(forecast)))

    def _sentences(self, forecast) -> list[str]:
        import math

        units, figures = self._parts.units, forecast.figures
        out = [
            tr(
                "Along the passes: {worst} at the worst place, {surface} square to the surface, "
                "normals {normal:.2f}°.",
                worst=units.text(figures.worst),
                surface=units.text(figures.surface, 1),
                normal=math.degrees(figures.normal),
            )
        ]
        if forecast.limits:
            most = tr("; then ").join(spoken(one.words) for one in forecast.limits[:2])
            out.append(tr("What limits it most: {what}.", what=most))
        out += [
            tr("→ {what}: {rms}", what=spoken(one.words), rms=units.text(one.rms))
            for one in forecast.advice
        ]
        out.append(
            tr(
                "Across the passes nothing finer than about {detail} is seen.",
                detail=units.text(2.0 * self.spacing.metres),
            )
        )
        out += map(spoken, forecast.notices[:1])
        source = self._source()
        by = tr("a calibration from {n} poses, as usual", n=source.poses)
        if source.calibration is not None:
            by = tr("the calibration {name}", name=source.name)
        out.append(
            tr(
                "Assumed: {surface}; {calibration}.",
                surface=spoken(forecast.assumed),
                calibration=by,
            )
        )
        return out

    def _show_failure(self, error: Exception) -> None:
        self._forecast = None
        if not isinstance(error, GeoribbonError):
            self._parts.notifier.tell("fault", f"the forecast: {error!r}")
            self.figure.say("")
            self.told.setText(tr("The accuracy could not be computed; see the log."))
            return
        self.figure.say(tr("no surface from this plan"), "poor")
        self.told.setText(spoken(str(error)))

    def _refuse(self, sentence: str) -> None:
        self.problem.say(spoken(sentence), "poor")
        self.problem.setVisible(bool(sentence))

    # --- files and settings ---

    def _folder(self) -> Path:
        folder = self._parts.settings.folder
        if folder is not None:
            return folder
        place = QStandardPaths.StandardLocation.DocumentsLocation
        return Path(QStandardPaths.writableLocation(place))

    def _proposal(self) -> Path:
        """A name that nobody has yet: the title and the day."""
        name = _file_name(self.title.text().strip() or tr("capture"))
        day = datetime.datetime.now().astimezone().date().isoformat()
        stem, number = f"{name} {day}", 1
        folder = self._folder()
        path = folder / f"{stem}{SESSION_SUFFIX}"
        while path.exists():
            number += 1
            path = folder / f"{stem} ({number}){SESSION_SUFFIX}"
        return path

    def _remember(self, plan: CapturePlan) -> None:
        settings = self._parts.settings
        settings.put("capture/passes", plan.passes)
        settings.put("capture/ties", plan.ties)
        settings.put("capture/marks", plan.layout.marks)
        settings.put("capture/distances", plan.layout.distances)
        for name in KEPT_LAYOUT:
            settings.put(f"capture/{name}", getattr(plan.layout, name))
        settings.put("capture/like", self.likeness)

    def _take_remembered(self) -> None:
        self.show_plan(remembered_plan(self._parts.settings))
        like = self._parts.settings.get("capture/like", "gentle")
        if like in LIKENESSES:
            self.like.setCurrentIndex(LIKENESSES.index(like))
        self._refuse("")


def remembered_plan(settings) -> CapturePlan:
    """The plan of the last capture, as far as it can be meant; the usual one otherwise."""
    usual = CapturePlan()
    try:
        layout = PlannedLayout(
            marks=settings.get("capture/marks", usual.layout.marks),
            distances=settings.get("capture/distances", usual.layout.distances),
            **{
                name: settings.get(f"capture/{name}", getattr(usual.layout, name))
                for name in KEPT_LAYOUT
            },
        )
        passes = settings.get("capture/passes", usual.passes)
        ties = settings.get("capture/ties", usual.ties)
        return CapturePlan(passes=passes, ties=ties, layout=layout)
    except SettingsError:
        return usual


def ask_plan(parent: QWidget, folder: Path) -> Path | None:
    """A plan's file that is there."""
    from PySide6.QtWidgets import QFileDialog

    found, _ = QFileDialog.getOpenFileName(parent, tr("Load plan"), str(folder), PLAN_FILES)
    return Path(found) if found else None


def ask_calibration_file(parent: QWidget, folder: Path) -> Path | None:
    """A calibration's file that is there."""
    from PySide6.QtWidgets import QFileDialog

    title = tr("Take a calibration")
    found, _ = QFileDialog.getOpenFileName(parent, title, str(folder), CALIBRATION_FILES)
    return Path(found) if found else None


def _grade(rms: float) -> str:
    """As a pass is graded by its mean standard deviation."""
    from georibbon.fitting.assessment import ACCEPTABLE_SIGMA, REDO_SIGMA

    return "good" if rms <= ACCEPTABLE_SIGMA else "fair" if rms <= REDO_SIGMA else "poor"


def _file_name(title: str) -> str:
    """A title as a file's name on any system."""
    kept = "".join(sign if sign.isalnum() or sign in " -_." else " " for sign in title)
    return " ".join(kept.split()).strip(". ")[:80] or "capture"


def _spin(low: int, high: int, value: int) -> QSpinBox:
    box = QSpinBox()
    box.setRange(low, high)
    box.setValue(value)
    return box


def _line() -> QFrame:
    line = QFrame()
    line.setFrameShape(QFrame.Shape.HLine)
    line.setFrameShadow(QFrame.Shadow.Sunken)
    return line


def _beside(one: QWidget, other: QWidget) -> QWidget:
    box = QWidget()
    layout = QHBoxLayout(box)
    layout.setContentsMargins(0, 0, 0, 0)
    layout.addWidget(one, 1)
    layout.addWidget(other)
    return box


def _row(form: QFormLayout, text: str, field: QWidget, more: QWidget | None = None) -> None:
    label = QLabel(text)
    label.setBuddy(field)
    field.setAccessibleName(text.replace("&", "").strip())
    form.addRow(label, field if more is None else _beside(field, more))
