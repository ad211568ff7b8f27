"""What the capture page shows of passes: where they lie, how good they are, how the live one lies.

Computations are of `capture`; here is only what is known by now, and by whom.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

from PySide6.QtCore import QObject, Signal

from georibbon.arrays import FloatArray
from georibbon.capture.beside import Beside, Hint, advise, compare
from georibbon.capture.live import LiveCurve
from georibbon.capture.placement import (
    Known,
    Lone,
    lone_curve,
    neighbour_of,
    object_axes,
    place_all,
    place_live,
    place_tie,
)
from georibbon.capture.plan import PlannedLayout, tie_places
from georibbon.capture.survey_rows import SurveyRow, survey_rows
from georibbon.capture.verdict import verdict_on
from georibbon.errors import GeoribbonError
from georibbon.geometry.frames import Strip
from georibbon.gui.capturing.latest import Latest, Stop
from georibbon.gui.parts import Parts

MARK_AT_START = 0.01  # m along a pass up to which a mark is one of its start


@dataclass(frozen=True)
class Quality:
    """The verdict on a pass, and why; final: by the reconstruction, else by the pass alone."""

    verdict: str
    reason: str
    final: bool


@dataclass(frozen=True, eq=False)
class LivePicture:
    """The pass that is being laid, as it lies now.

    strip: placed.  beside: how it lies beside its neighbour, None where there
    is none; hints: what to do about it.
    """

    name: str
    kind: str
    strip: Strip
    curve: LiveCurve
    beside: Beside | None
    hints: tuple[Hint, ...]


@dataclass(frozen=True)
class Row:
    """A line of the list of what is captured; status: open, taken, skipped."""

    key: str
    kind: str
    status: str
    words: str
    current: bool
    quality: Quality | None


@dataclass
class _Held:
    """The lone curves of passes that were taken, each for the frames it is of.

    fresh: those whose curve is the live one, which has followed the ribbon there.
    """

    curves: dict[str, LiveCurve] = field(default_factory=dict)
    of: dict[str, tuple[int, int]] = field(default_factory=dict)
    fresh: set[str] = field(default_factory=set)


def is_calibration(capture) -> bool:
    """Whether what goes on is a calibration alone, which is another page's business."""
    return capture.active and all(one.is_pose for one in capture.items)


class CaptureModel(QObject):
    """What is known of the passes of the capture that goes on.

    changed(): rows, places or qualities.  lived(LivePicture | None): the live
    curve.
    """

    changed = Signal()
    lived = Signal(object)

    def __init__(self, parts: Parts, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._parts = parts
        self._held = _Held()
        self._stale: set[str] = set()
        self._last: LiveCurve | None = None
        self._after: dict[str, str] = {}  # a further pass and the one it is to stand behind
        self.layout = PlannedLayout()
        self.placed: dict[str, Strip] = {}
        self._latest = Latest("curves", self)
        self._latest.done.connect(self._take_curves)
        self._latest.failed.connect(self._fault)
        capture, document = parts.capture, parts.document
        capture.began.connect(self.begin)
        capture.ended.connect(self._end)
        capture.changed.connect(self._refresh)
        capture.stood.connect(self._refresh)
        capture.refreshed.connect(self._glance)
        capture.happened.connect(self._happened)
        document.reconstructed.connect(self._reconstructed)

    # --- what is known ---

    @property
    def ribbon(self):
        """The session's ribbon; None without a capture."""
        session = self._parts.capture.session
        return None if session is None else session.state.ribbon

    @property
    def kinds(self) -> dict[str, str]:
        """pass or tie, by name."""
        return {one.key: one.what.kind for one in self._parts.capture.items if not one.is_pose}

    @property
    def order(self) -> list[str]:
        """All passes and ties: those taken in the session's order, the open ones where planned."""
        session = self._parts.capture.session
        taken = [] if session is None else [one.name for one in session.state.passes]
        return merged([one.key for one in self._parts.capture.items if not one.is_pose], taken,
                      self._after)  # fmt: skip

    @property
    def pass_order(self) -> list[str]:
        """The same without ties."""
        kinds = self.kinds
        return [name for name in self.order if kinds.get(name) == "pass"]

    @property
    def rows(self) -> tuple[Row, ...]:
        """Poses where there is no calibration yet, then passes and ties."""
        capture = self._parts.capture
        items = {one.key: one for one in capture.items}
        keys = [one.key for one in capture.items if one.is_pose and capture.calibration is None]
        current = None if capture.current is None else capture.current.key
        return tuple(
            Row(
                key,
                "pose" if items[key].is_pose else items[key].what.kind,
                items[key].status,
                items[key].words,
                key == current,
                self.quality(key),
            )
            for key in (*keys, *(name for name in self.order if name in items))
        )

    @property
    def known(self) -> Known:
        """What the newest reconstruction says of places."""
        result = self._parts.document.reconstruction
        if result is None:
            return Known()
        strips = {one.name: one.strip for one in result.passes if one.name not in self._stale}
        return Known(strips, result.heading, self._marked_starts())

    def quality(self, name: str) -> Quality | None:
        """How good a pass is that was taken; None where nothing can be said yet."""
        result = self._parts.document.reconstruction
        if result is not None and name not in self._stale:
            for one in result.passes:
                if one.name == name:
                    return Quality(one.quality.verdict, one.quality.reason, True)
        curve, ribbon = self._held.curves.get(name), self.ribbon
        if curve is None or ribbon is None:
            return None
        found = verdict_on(ribbon, curve)
        return Quality(found.verdict, found.reason, False)

    def survey(self) -> tuple[SurveyRow, ...]:
        """The survey with its residuals, as far as there is a fit."""
        result = self._parts.document.reconstruction
        return survey_rows(self._parts.capture.survey, () if result is None else result.survey)

    def axes(self) -> FloatArray:
        """(3, 3) columns: along the first pass, to its left, out of the surface."""
        passes = [self.placed[name] for name in self.pass_order if name in self.placed]
        return object_axes(passes)

    # --- what a person does that the engine need not know ---

    def stand_behind(self, name: str, before: str) -> None:
        """A further pass is to stand behind another as soon as it is taken."""
        self._after[name] = before

    def take_layout(self, layout: PlannedLayout) -> None:
        """Passes are meant to be laid like this."""
        self.layout = layout
        self._refresh()

    # --- what comes ---

    def begin(self) -> None:
        """A capture goes on; nothing is known of it yet."""
        self._held, self._stale, self._last, self._after = _Held(), set(), None, {}
        self._refresh()

    def _end(self) -> None:
        self._latest.drop()
        self._last = None
        self.lived.emit(None)
        self.changed.emit()

    def _refresh(self) -> None:
        capture = self._parts.capture
        if not capture.active or is_calibration(capture):
            return
        there = {one.name: (one.part, id(capture.calibration)) for one in
                 capture.session.state.passes}  # fmt: skip
        held = self._held
        for name in [name for name in held.of if held.of[name] != there.get(name)]:
            del held.of[name]
        for name in [name for name in held.curves if name not in there]:
            del held.curves[name]
        for name in held.fresh & there.keys():
            held.of[name] = there[name]
        held.fresh -= there.keys()
        missing = {name: of for name, of in there.items() if name not in held.of}
        if missing and capture.calibration is not None:
            self._compute(missing)
        self._place()

    def _compute(self, missing: Mapping[str, tuple[int, int]]) -> None:
        """The curves of passes of which none is known, in a worker."""
        session, calibration = self._parts.capture.session, self._parts.capture.calibration
        ribbon = session.state.ribbon

        def work(stop: Stop) -> object:
            out = {}
            for name, of in missing.items():
                if stop():
                    return {}
                try:
                    out[name] = of, lone_curve(ribbon, calibration, session.readings(of[0]))
                except GeoribbonError:
                    out[name] = of, None  # what cannot be read is told by whoever needs it
            return out

        self._latest.ask(work)

    def _take_curves(self, found) -> None:
        for name, (of, curve) in found.items():
            self._held.of[name] = of
            if curve is not None:
                self._held.curves[name] = curve
        self._place()

    def _fault(self, error: Exception) -> None:
        self._parts.notifier.tell("fault", f"the curves of the passes: {error!r}")

    def _happened(self, happening) -> None:
        if happening.kind in ("taken", "held") and happening.subject in self.kinds:
            name = happening.subject
            self._stale.add(name)
            if self._last is not None:
                self._held.curves[name] = self._last
                self._held.of.pop(name, None)
                if self._last.settled:
                    self._held.fresh.add(name)
            self._put_in_place(name)
        elif happening.kind in ("removed", "undone", "redone", "calibrated"):
            self._stale.update(self.kinds)

    def _put_in_place(self, name: str) -> None:
        """A pass that was taken goes behind the one it was added behind."""
        if name in self._after:
            names = [one.name for one in self._parts.capture.session.state.passes]
            wanted = [one for one in self.order if one in names]
            if wanted != names and sorted(wanted) == sorted(names):
                self._parts.capture.reorder(wanted)
            del self._after[name]

    def _reconstructed(self, _result) -> None:
        if not self._parts.document.is_behind:  # else it knows nothing of what was laid since
            self._stale.clear()
        if self._parts.capture.active:
            self._place()

    def _place(self) -> None:
        kinds, known = self.kinds, self.known
        there = {one.name for one in self._parts.capture.session.state.passes}
        taken = [
            Lone(name, kinds[name], self._held.curves[name].strip)
            for name in self.order
            if name in there and name in self._held.curves
        ]
        lone = {one.name for one in taken}
        # What only the reconstruction knows, as of another calibration.
        taken += [
            Lone(name, kinds[name], strip)
            for name, strip in known.strips.items()
            if name in kinds and name in there and name not in lone
        ]
        self.placed = place_all(taken, self.pass_order, self.layout.spacing, known)
        self.changed.emit()

    def _glance(self, glance) -> None:
        curve = glance.live.curve
        self._last = curve if curve is not None else None
        item = self._parts.capture.current
        if curve is None or item is None or item.is_pose or is_calibration(self._parts.capture):
            self.lived.emit(None)
            return
        self.lived.emit(self._picture(item.key, item.what.kind, curve))

    def _picture(self, name: str, kind: str, curve: LiveCurve) -> LivePicture:
        lone, known, order = Lone(name, kind, curve.strip), self.known, self.pass_order
        if kind == "tie":
            ties = [one for one in self.order if self.kinds.get(one) == "tie"]
            fraction = tie_places(len(ties))[ties.index(name)] if name in ties else 0.5
            strip = place_tie(lone, fraction, order, self.placed, known)
            return LivePicture(name, kind, strip, curve, None, ())
        strip = place_live(lone, order, self.placed, self.layout.spacing, known)
        there = {one: placed for one, placed in self.placed.items() if one in order and one != name}
        sound = {one: strip for one, strip in there.items() if not self._is_poor(one)}
        neighbour = neighbour_of(name, order, sound or there)
        beside = None if neighbour is None else compare(strip, there[neighbour], neighbour)
        wide = self.layout.spacing * self._gaps(name, neighbour, order)
        hints = () if beside is None else advise(beside, wide)
        return LivePicture(name, kind, strip, curve, beside, hints)

    def _is_poor(self, name: str) -> bool:
        """Whether a pass is to be laid again: nothing should be laid beside it."""
        found = self.quality(name)
        return found is not None and found.verdict == "redo"

    @staticmethod
    def _gaps(name: str, neighbour: str | None, order: list[str]) -> int:
        if neighbour is None or name not in order:
            return 1
        return max(1, abs(order.index(name) - order.index(neighbour)))

    def _marked_starts(self) -> dict[str, FloatArray]:
        """(3,) of the passes whose start was marked."""
        import numpy as np

        return {
            row.passes[0]: np.array(row.values)
            for row in survey_rows(self._parts.capture.survey)
            if row.table == "mark" and row.at[0] <= MARK_AT_START
        }


def merged(planned: list[str], taken: list[str], after: Mapping[str, str]) -> list[str]:
    """All names: those taken in their order, each open one behind all it is planned behind.

    after: names that are to stand behind others than they are planned.
    """
    out = [name for name in taken if name in planned]
    for k, name in enumerate(planned):
        if name not in out:
            out.insert(max((out.index(one) + 1 for one in planned[:k]), default=0), name)
    for name, before in after.items():
        if name in out and before in out:
            out.remove(name)
            out.insert(out.index(before) + 1, name)
    return out
