"""The capture as a state machine: readings and a few verbs in, a session and happenings out.

It knows no window, no port and no thread: its owner feeds frames, calls verbs
and `refresh`, all from one thread, and is told by callbacks.  Everything that
is taken goes into the session first and is told after.
"""

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

from georibbon.calibration import calibrate, check_fits, to_dict
from georibbon.calibration.gates import LEAST_POSES
from georibbon.calibration.model import Calibration
from georibbon.capture.checklist import Item, checklist, next_open
from georibbon.capture.judging import LEAST_SECONDS, Refusal, judge_pass, judge_pose
from georibbon.capture.ledger import NOT_YET, Happening, Kind, Ledger
from georibbon.capture.live import LiveCurve, LiveFit
from georibbon.capture.plan import CapturePlan, PlannedPass, PlannedPose
from georibbon.capture.start import check_plan, planned_layout, write_plan, write_ribbon
from georibbon.capture.surveying import SurveyDesk
from georibbon.capture.verdict import quality_words, verdict_on
from georibbon.device.frames import Frame, readings_of
from georibbon.device.stillness import MOST_SPREAD, Stillness, StillnessMonitor
from georibbon.errors import FitError, GeoribbonError, SessionError, SettingsError
from georibbon.recording import PassKind
from georibbon.session.fields import MAX_NAME
from georibbon.session.session import Session
from georibbon.session.words import counted, nearest, told
from georibbon.stillness import StillMeans, still_means
from georibbon.threads import one_thread

GLANCE = 0.1  # s of frames that are looked at together
SHOWN_FRAMES = 5  # averaged for the live curve while the ribbon moves


@dataclass(frozen=True, eq=False)
class Live:
    """The newest state: stillness (None before the first frame), and the live curve.

    curve: None without a calibration.
    """

    stillness: Stillness | None
    curve: LiveCurve | None


class Engine:
    """One capture into one session.

    auto: whether what lies still as asked is taken by itself.  Raises
    SessionError where the session names no ribbon.
    """

    def __init__(self, session: Session, plan: CapturePlan, *, auto: bool = True) -> None:
        ribbon = session.state.ribbon
        if ribbon is None:
            raise SessionError(f"{session.path}: the session names no ribbon; begin a new one")
        self.session, self.ribbon, self.plan, self.auto = session, ribbon, plan, auto
        self.calibration: Calibration | None = None
        self._ledger = Ledger(session)
        self.survey = SurveyDesk(self._ledger, ribbon, self._names)
        self._recent: deque[Frame] = deque(maxlen=SHOWN_FRAMES)
        self._stillness: Stillness | None = None
        self._extra: dict[str, PlannedPass] = {}
        self._lifted = True
        self._armed = False
        self._told: Refusal | None = None
        self._current: str | None = None
        self._renew(self._known_calibration())
        wanted = self.calibration is None
        self._current = self._next(None, wanted) or self._next(None, not wanted)

    # -- what is there ------------------------------------------------------------------

    @property
    def items(self) -> tuple[Item, ...]:
        """All poses, passes and ties, and how they stand."""
        return checklist(self.plan, self.session.state, tuple(self._extra.values()))

    @property
    def current(self) -> Item | None:
        """What is asked for now; None where nothing is left to do."""
        return next((item for item in self.items if item.key == self._current), None)

    def observe(self, callback: Callable[[Happening], None]) -> None:
        """Have every happening told to a callback, on the owner's thread."""
        self._ledger.observe(callback)

    def refresh(self) -> Live:
        """Stillness and the live curve of the newest frames: for every displayed frame."""
        means = self._monitor.means()
        if means is None and self._recent:
            means = still_means(readings_of(list(self._recent)))
        return Live(self._stillness, self._curve(means))

    def _curve(self, means: StillMeans | None) -> LiveCurve | None:
        """The curve by these means; None without a calibration, or where too little is heard."""
        if self._fit is None or means is None:
            return None
        with suppress(FitError):
            return self._fit.update(means.mean, means.sigma)
        return None

    def _fresh_curve(self) -> LiveCurve | None:
        """The curve by the readings that are taken alone, not by what was shown before."""
        means = self._monitor.means()
        if self.calibration is None or means is None:
            return None
        with suppress(FitError):
            return LiveFit(self.ribbon, self.calibration).update(means.mean, means.sigma)
        return None

    # -- readings -----------------------------------------------------------------------

    def feed(self, frames: Sequence[Frame]) -> None:
        """The next frames; may take what is asked for by itself.

        Many at once, after the program was held up, mean what they would have
        meant one by one: a motion among them is seen.
        """
        block = max(1, round(GLANCE * self.ribbon.rate))
        for start in range(0, len(frames), block):
            self._feed(frames[start : start + block])

    def _feed(self, frames: Sequence[Frame]) -> None:
        self._ledger.look()
        self._recent.extend(frames)
        self._stillness = self._monitor.feed(frames)
        # Only a motion that was seen: after a gap nobody knows, and the pass may be the last one.
        if self._stillness.state == "moving" and self._stillness.spread > MOST_SPREAD:
            self._lifted, self._armed, self._told = True, True, None
        elif self._stillness.seconds >= LEAST_SECONDS:
            self._take_by_itself()

    def interrupted(self) -> None:
        """The readings broke off (stalled, unplugged): no still window may span it."""
        self._monitor.reset()
        self._recent.clear()
        self._stillness = None

    def link_news(self, entry: Mapping[str, object]) -> None:
        """Keep what happened to the link in the session, and tell it.

        entry: of a `LinkDiary`: state, reason and the link's figures.
        """
        if entry["state"] != "streaming":
            self.interrupted()
        self._ledger.write(lambda: self.session.do("link", **entry))
        self._ledger.tell("link", None, f"{entry['state']}: {entry['reason']}")

    # -- verbs --------------------------------------------------------------------------

    def choose(self, key: str) -> None:
        """Ask for a pose or pass next, in any order; one that was taken is repeated.

        Raises SettingsError for one that is neither planned nor there.
        """
        item = self._item(key)
        if item is None:
            known = [one.key for one in self.items]
            raise SettingsError(
                f"there is no pose or pass {told(key)}{nearest(key, known)}; add it first if it "
                "is a further pass"
            )
        self._current, self._told = key, None
        self._tell_current("again: " if item.status == "taken" else "")

    def add(self, name: str, kind: PassKind) -> None:
        """Ask for a further pass or tie, beyond the plan; SettingsError for a name in use."""
        if self._item(name) is not None:
            raise SettingsError(f"{told(name)} is there already; choose it to repeat it")
        if not name.strip() or not name.isprintable() or len(name) > MAX_NAME:
            raise SettingsError(f"{told(name)} cannot be a pass's name; give a short printable one")
        self._extra[name] = PlannedPass(name, kind)
        self.choose(name)

    def take(self, force: bool = False) -> Refusal | None:
        """Take what is asked for from the still ribbon; the refusal where it cannot be taken.

        force: take it although a refusal that may be forced speaks against it.
        """
        item = self.current
        refusal = self._refusal(item)
        if refusal is not None and not (force and refusal.forcible):
            self._refuse(refusal)
            return refusal
        if item is not None:
            self._keep(item)
        return None

    def skip(self) -> None:
        """Leave out what is asked for now; choosing it later brings it back."""
        item = self.current
        if item is None:
            raise SettingsError("nothing is asked for; there is nothing to skip")
        words = f"{item.key} stays as it was taken"
        if item.status != "taken":
            what = {"pose": item.key} if item.is_pose else {"pass": item.key}
            self._ledger.write(lambda: self.session.do("skip", **what))
            words = f"{item.key} is left out"
        self._ledger.tell("skipped", item.key, words)
        self._advance(item)

    def remove(self, key: str) -> None:
        """Take a pose or pass out of the session again; undo brings it back."""
        item = self._item(key)
        if item is None or item.status != "taken":
            raise SettingsError(f"{key} was not taken; there is nothing to remove")
        what = {"pose": key} if item.is_pose else {"pass": key}
        self._ledger.write(lambda: self.session.do("remove", **what))
        self._ledger.tell("removed", key, f"{key} is removed; undo brings it back")
        self._current = self._current or key

    def undo(self) -> None:
        """Take back the last change."""
        state = self.session.state
        # What the capture began with was nobody's doing here.
        begun = next((one.id for one in state.history if one.action == "plan"), 0)
        what = state.undoable if state.done and state.done[-1] > begun else None
        self._back("undone", what, self.session.undo)

    def redo(self) -> None:
        """Do again what was taken back last."""
        self._back("redone", self.session.state.redoable, self.session.redo)

    def reorder(self, names: Sequence[str]) -> None:
        """Put the passes and ties that were taken into another order; all of them are named."""
        there = [one.name for one in self.session.state.passes]
        if sorted(names) != sorted(there):
            raise SettingsError(
                f"the order names {', '.join(names)}; it must name {', '.join(there)}, each once"
            )
        if list(names) != there:
            self._ledger.write(lambda: self.session.do("order", passes=list(names)))
            self._ledger.tell("ordered", None, f"the order is {', '.join(names)}")

    def replan(self, plan: CapturePlan) -> None:
        """Go on by another plan; what was taken stays."""
        check_plan(plan, self.ribbon)
        self._ledger.write(lambda: write_plan(self.session, plan))
        self.plan = plan
        self._ledger.tell("planned", None, plan_words(plan))
        item = self.current
        if item is None or item.status != "open":
            self._current = self._next(None, self.calibration is None) or self._next(None, False)
            self._tell_current()

    def note(self, text: str) -> None:
        """A note of the operator's; the session keeps its time."""
        self._ledger.write(lambda: self.session.do("note", text=text))
        self._ledger.tell("noted", None, f"noted: {text}")

    def use_calibration(self, calibration: Calibration) -> None:
        """Use a calibration that was made before, in place of the poses."""
        check_fits(calibration, self.ribbon)
        self._adopt(calibration, "the calibration that was given is used")
        item = self.current
        if item is None or item.is_pose:
            self._current = self._next(None, False)

    def calibrate(self) -> None:
        """Calibrate from the poses taken so far; CalibrationError says what is missing."""
        calibration = self._calibrated()
        self._adopt(calibration, quality_words(calibration))

    def save_to(self, path: Path) -> None:
        """Continue the session in another place, with everything that is held in memory."""
        self.session.move_to(path)
        self._ledger.look()

    def save_again(self) -> None:
        """Try once more to write what is held in memory; StorageError where it still cannot be."""
        self.session.retry()
        self._ledger.look()

    # -- inside -------------------------------------------------------------------------

    def _tell_current(self, again: str = "") -> None:
        item = self.current
        if item is None:
            self._ledger.tell("complete", None, "everything that was planned is taken")
        else:
            self._ledger.tell("chosen", item.key, f"{again}{item.key}: {item.words}")

    def _names(self) -> list[str]:
        return [item.key for item in self.items if not item.is_pose]

    def _item(self, key: str) -> Item | None:
        return next((item for item in self.items if item.key == key), None)

    def _next(self, after: str | None, poses: bool) -> str | None:
        return next_open(self.items, after, poses)

    def _take_by_itself(self) -> None:
        """Take what lies still; a refusal is told once for each time that it is laid down."""
        if not self.auto or self._current is None or not self._lifted:
            return
        refusal, before = self._refusal(self.current) or self._unmoved(), self._told
        if refusal is None:
            self.take()
        elif before is None or before.code != refusal.code:
            self._refuse(refusal)

    def _unmoved(self) -> Refusal | None:
        """What lies still from the start on may be meant or not: that is for the person to say."""
        if self._armed:
            return None
        words = "lies still, but was not moved since the start; move it, or take it by hand"
        return Refusal("not-moved", f"the ribbon {words}")

    def _refuse(self, refusal: Refusal) -> None:
        self._told = refusal
        self._ledger.tell("refused", self._current, refusal.message)

    def _refusal(self, item: Item | None) -> Refusal | None:
        if item is None:
            return Refusal("nothing", "nothing is asked for; choose a pose or a pass first")
        window, means = self._monitor.window(), self._monitor.means()
        if self._stillness is None or window is None or means is None:
            return Refusal("moving", f"{item.key} is not taken: {_restless(self._stillness)}")
        if self._stillness.seconds < LEAST_SECONDS:
            return Refusal(
                "short",
                f"{item.key} is not taken: still for {self._stillness.seconds:.1f} s, "
                f"{LEAST_SECONDS:g} s is needed; hold the ribbon still a little longer",
            )
        return self._refusal_of(item, means)

    def _refusal_of(self, item: Item, means: StillMeans) -> Refusal | None:
        """What speaks against taking a ribbon that lies still long enough."""
        if isinstance(item.what, PlannedPose):
            refusal = judge_pose(self.ribbon, item.what, means.mean)
        else:
            refusal = judge_pass(self.ribbon, item.key, means.mean)
        if refusal is not None:
            return refusal
        if self._stillness is not None and self._stillness.state == "disturbed":
            return Refusal(
                "disturbed",
                f"{item.key} is not taken: {self._stillness.reason}; take away what is magnetic",
                forcible=True,
            )
        if not self._lifted:
            return Refusal(
                "not-lifted",
                f"{item.key} is not taken: the ribbon was not moved since the last one was taken; "
                "lay it anew",
                forcible=True,
            )
        return None

    def _keep(self, item: Item) -> None:
        """Write what lies still into the session, then tell it and go on."""
        readings, what = self._monitor.window(), item.what
        if readings is None:
            return
        if isinstance(what, PlannedPose):
            kept = self._ledger.write(
                lambda: self.session.add_pose(
                    what.key, what.name, what.roll, what.heading, what.pitch, what.table, readings
                )
            )
        else:
            kept = self._ledger.write(lambda: self.session.add_pass(what.name, what.kind, readings))
        self._lifted = self._armed = False
        if kept is None:
            self._ledger.tell("held", item.key, f"{item.key} is in memory only, not on disk yet")
        else:
            self._ledger.tell("taken", item.key, self._taken_words(item, readings.t.size))
        if item.is_pose:
            self._look_at_poses()
        self._advance(item)

    def _taken_words(self, item: Item, frames: int) -> str:
        words = f"{item.key} is taken ({frames} frames)"
        curve = None if item.is_pose else self._fresh_curve()
        if curve is None:
            return words
        verdict = verdict_on(self.ribbon, curve)
        return f"{words}: {verdict.verdict}, {verdict.reason}"

    def _look_at_poses(self) -> None:
        """How good the calibration is by now; kept when all planned poses are done."""
        left = [item for item in self.items if item.is_pose and item.status == "open"]
        if len(self.session.state.poses) < LEAST_POSES:
            return
        try:
            calibration = self._calibrated()
        except GeoribbonError as error:
            self._ledger.tell("quality", None, f"{NOT_YET}: {error}")
            return
        if left:
            self._ledger.tell("quality", None, f"so far {quality_words(calibration)}")
        else:
            self._adopt(calibration, quality_words(calibration))

    def _calibrated(self) -> Calibration:
        poses = self.session.recording(complete=False).poses
        with one_thread():
            return calibrate(self.ribbon, poses)

    def _adopt(self, calibration: Calibration, words: str) -> None:
        document = to_dict(calibration)
        self._ledger.write(lambda: self.session.do("calibration", document=document))
        # Once more, pages away from the first: without any copy no frame could be salvaged.
        firmware = self.session.state.firmware
        self._ledger.write(lambda: write_ribbon(self.session, self.ribbon, firmware))
        self._renew(calibration)
        self._ledger.tell("calibrated", None, words)

    def _renew(self, calibration: Calibration | None) -> None:
        """Everything that depends on the calibration, anew."""
        self.calibration = calibration
        self._monitor = StillnessMonitor(self.ribbon, calibration)
        self._fit = None if calibration is None else LiveFit(self.ribbon, calibration)
        self._stillness = None

    def _known_calibration(self) -> Calibration | None:
        """The session's calibration, where it has one that fits its ribbon."""
        calibration = self.session.state.calibration
        if calibration is not None:
            check_fits(calibration, self.ribbon)
        return calibration

    def _advance(self, item: Item) -> None:
        """Ask for the next open item of the kind, then of the other."""
        poses = item.is_pose and self.calibration is None
        following = self._next(item.key, poses)
        if following is None and item.is_pose and self._next(None, False) is not None:
            following = self._next(None, False)
        self._current = following
        self._tell_current()

    def _back(self, kind: Kind, what: str | None, step: Callable[[], object]) -> None:
        if what is None:
            raise SettingsError(f"nothing can be {kind}")
        before = {item.key for item in self.items if item.status == "open"}
        self._ledger.write(step)
        kept = self.session.state.plan
        if kept is not None:
            counts = {"poses": kept.poses, "passes": kept.passes, "ties": kept.ties}
            layout = planned_layout(kept)
            self.plan = replace(self.plan.with_counts(counts), layout=layout)
        calibration = self._known_calibration()
        if calibration is not self.calibration:
            self._renew(calibration)
        self._ledger.tell(kind, None, f"{kind}: {what}")
        opened = [i.key for i in self.items if i.status == "open" and i.key not in before]
        item = self.current
        if opened:
            self.choose(opened[0])
        elif item is None or item.status != "open":
            self._current = self._next(None, calibration is None) or self._next(None, False)
            self._tell_current()


def plan_words(plan: CapturePlan) -> str:
    """What is planned, in a line."""
    parts = [counted(plan.passes, "pass", "passes"), counted(plan.ties, "tie")]
    return f"planned: {counted(plan.poses, 'pose')}, {', '.join(parts)}"


def _restless(stillness: Stillness | None) -> str:
    """Why the ribbon is not still, with what to do."""
    if stillness is None:
        return "no frame has come; see to the link"
    if stillness.spread > 0.0:
        return f"{stillness.reason}; hold the ribbon still"
    return stillness.reason
