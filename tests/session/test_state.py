"""The fold of the journal: undoing is exact, and what cannot be meant is refused."""

import contextlib
import json

import pytest
from hypothesis import given
from hypothesis import strategies as st
from made import RIBBON

from georibbon.errors import SessionError
from georibbon.recording import Mark, Workpiece
from georibbon.session.actions import in_words
from georibbon.session.chunks import DamagedError
from georibbon.session.events import ACTIONS, UNDOABLE, Event, decode_detail, event_of
from georibbon.session.outline import ribbon_table
from georibbon.session.state import SessionPlan, SessionState, advance, fold, parts_of

TIME = "2026-01-02T03:04:05.678+00:00"
POSE = {"key": "pose-01", "name": "roll 0", "roll": 0, "heading": 0, "pitch": 0, "table": True,
        "frames": 3}  # fmt: skip
PLAN = {"poses": 1, "passes": 2, "ties": 3}
RUN = {"name": "P1", "kind": "pass", "frames": 3}
MARK = {"pass": "P1", "at": 0.1, "position": [0, 0, 1], "sigma": 0.001}
SENSORS = [
    {"name": s.name, "gain": [[1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0]][: s.axes],
     "bias": [0.0] * s.axes}
    for s in RIBBON.sensors
]  # fmt: skip
DOCUMENT = {"format": "georibbon-calibration", "version": 1, "ribbon": RIBBON.id, "dip": 1.0,
            "sensors": SENSORS, "notices": []}  # fmt: skip


def journal(*actions):
    """Events of actions, each a word or (word, detail), after those that begin a session."""
    begun = [("created", {"georibbon": "0"}), ("ribbon", ribbon_table(RIBBON))]
    return [Event(i, TIME, *one) for i, one in enumerate([*begun, *actions], start=1)]


def state_of(*actions):
    return fold(journal(*actions))


def plain(state):
    """What a state holds beside its history."""
    names = set(SessionState.__dataclass_fields__) - {"history", "done", "undone", "holding"}
    return {name: getattr(state, name) for name in names}


# What can be done at any time, of few names so that they meet.
KEYS = st.sampled_from(["a", "b"])
NAMES = st.sampled_from(["P1", "P2"])
STEPS = st.one_of(
    st.tuples(st.just("title"), st.fixed_dictionaries({"title": st.none() | KEYS})),
    st.tuples(st.just("pose"), KEYS.map(lambda key: POSE | {"key": key})),
    st.tuples(st.just("pass"), NAMES.map(lambda name: RUN | {"name": name})),
    st.tuples(st.just("remove"), NAMES.map(lambda name: {"pass": name})),
    st.tuples(st.just("skip"), NAMES.map(lambda name: {"pass": name})),
    st.tuples(st.just("order"), st.permutations(["P1", "P2"]).map(lambda p: {"passes": p})),
    st.tuples(st.just("survey"), st.sampled_from([{}, {"mark": [MARK]}])),
    st.tuples(
        st.just("setting"), NAMES.map(lambda name: {"pass": name, "key": "smoothing", "value": 1})
    ),
    st.tuples(st.just("note"), KEYS.map(lambda text: {"text": text})),
    st.tuples(st.just("link"), st.just({"state": "streaming"})),
    st.sampled_from([("undo", None), ("redo", None)]),
)


@given(st.lists(STEPS, max_size=25))
def test_undoing_and_redoing_are_exact_and_step_by_step_is_all_at_once(steps):
    state = fold(journal())
    before, after = [], []  # what undoing and redoing must lead to
    for action, wanted in steps:
        detail = wanted
        if wanted is None:
            stack = state.done if action == "undo" else state.undone
            if not stack:
                continue
            told = state.undoable if action == "undo" else state.redoable
            detail = {"of": stack[-1]}
            assert told == in_words(state.history[stack[-1] - 1])
        elif action in ("pose", "pass"):
            detail = wanted | {"part": len(state.history)}
        try:
            new = advance(state, Event(len(state.history) + 1, TIME, action, detail))
        except SessionError:
            continue
        if action == "undo":
            after.append(plain(state))
            assert plain(new) == before.pop()
        elif action == "redo":
            before.append(plain(state))
            assert plain(new) == after.pop()
        elif action in UNDOABLE:
            before.append(plain(state))
            after.clear()
        state = new
        assert (len(state.done), len(state.undone)) == (len(before), len(after))
    again = fold(state.history)
    assert plain(again) == plain(state)
    assert (again.done, again.undone, again.holding) == (state.done, state.undone, state.holding)


def test_what_the_actions_leave():
    state = state_of(
        ("title", {"title": "x"}),
        ("plan", {"poses": 16, "passes": 5, "ties": 2}),
        ("workpiece", {"level": True, "heading": 25}),
        ("skip", {"pose": "pose-01"}),
        ("skip", {"pass": "P3"}),
        ("pose", POSE | {"part": 1}),
        ("pass", RUN | {"part": 2}),
        ("pass", RUN | {"name": "T1", "kind": "tie", "part": 3}),
        ("pass", RUN | {"part": 4, "frames": 7}),
        ("order", {"passes": ["T1", "P1"]}),
        ("survey", {"mark": [MARK, MARK | {"pass": "P9"}]}),
        ("setting", {"pass": "P1", "key": "smoothing", "value": 0.05}),
        ("setting", {"pass": "*", "key": "smoothing", "value": 0.06}),
        ("setting", {"pass": "P1", "key": "smoothing", "value": None}),
        ("calibration", {"document": DOCUMENT}),
        ("note", {"text": "cold", "pass": "P1"}),
        ("stream", {"part": 9, "rate": 100}),
    )
    assert (state.title, state.plan) == ("x", SessionPlan(16, 5, 2))
    laid = {"spacing": 0.05, "marks": 3, "crossing_sigma": 0.002}
    again = state_of(("plan", {"poses": 0, "passes": 5, "ties": 2, "layout": laid}))
    assert again.plan == SessionPlan(0, 5, 2, laid)
    assert state.workpiece == Workpiece(True, 25.0)
    assert state.skipped == ("P3",)
    assert [(run.name, run.part, run.frames) for run in state.passes] == [
        ("T1", 3, 3),
        ("P1", 4, 7),
    ]
    assert [pose.key for pose in state.poses] == ["pose-01"]
    assert state.marks[0] == Mark("P1", 0.1, (0.0, 0.0, 1.0), 0.001)
    assert state.pending_survey == ("P9",)
    assert state.settings == {("*", "smoothing"): 0.06}
    assert state.calibration is not None
    assert [(note.text, note.pass_name, note.time) for note in state.notes] == [
        ("cold", "P1", TIME)
    ]
    assert [(one.part, one.rate, one.time) for one in state.streams] == [(9, 100.0, TIME)]
    assert state.undoable == 'the note "cold"'
    assert parts_of(state.history) == {1: 3, 2: 3, 3: 3, 4: 7, 9: None}


def test_what_was_taken_back_by_an_entry_of_its_own():
    made = [("pass", RUN | {"part": 1}), ("title", {"title": "x"}), ("workpiece", {"level": True})]
    made += [("calibration", {"document": DOCUMENT}), ("survey", {"mark": [MARK]})]
    state = state_of(
        *made, ("remove", {"pass": "P1"}), ("title", {"title": None}), ("workpiece", {}),
        ("calibration", {"document": None}), ("survey", {}),
    )  # fmt: skip
    assert (state.passes, state.title, state.workpiece) == ((), None, None)
    assert (state.calibration, state.marks) == (None, ())


HOSTILE = {
    "an undo of nothing": ("undo", {"of": 1}, "only the last"),
    "an undo of itself": ("undo", {"of": 4}, "only the last"),
    "an undo of a text": ("undo", {"of": "3"}, "only the last"),
    "an undo of true": ("undo", {"of": True}, "only the last"),
    "an undo of too much": ("undo", {"of": 3, "and": 2}, "only the last"),
    "an undo of none": ("undo", {}, "only the last"),
    "a redo of nothing": ("redo", {"of": 3}, "only the last"),
    "no pose to remove": ("remove", {"pose": "pose-9"}, "there is no pose"),
    "no pass to remove": ("remove", {"pass": "P9"}, 'there is no pass "P9"'),
    "two to remove": ("remove", {"pose": "a", "pass": "P1"}, "one pose or one pass"),
    "a number to remove": ("remove", {"pass": 1}, "pass is 1"),
    "an order of too few": ("order", {"passes": []}, "all 1 passes"),
    "an order of another": ("order", {"passes": ["P2"]}, "name each once"),
    "a negative plan": ("plan", {"poses": -1, "passes": 0, "ties": 0}, "poses is -1"),
    "a plan without end": ("plan", {"poses": 1, "passes": 1e9, "ties": 0}, "passes is"),
    "a plan of no layout": ("plan", PLAN | {"layout": 3}, "it is 3"),
    "a plan of another layout": ("plan", PLAN | {"layout": {"space": 1}}, "not known"),
    "passes on one another": ("plan", PLAN | {"layout": {"spacing": 0}}, "spacing is 0"),
    "half a mark": ("plan", PLAN | {"layout": {"marks": 0.5}}, "marks is 0.5"),
    "half a plan": ("plan", {"poses": 1}, "passes is missing"),
    "no key": ("pose", POSE | {"key": "", "part": 9}, "the pose's key"),
    "frames without end": ("pass", RUN | {"part": 9, "frames": 2**60}, "frames is"),
    "a part without end": ("pass", RUN | {"part": 2**40}, "part is"),
    "a note of nothing": ("note", {}, "text is missing"),
    "a note without end": ("note", {"text": "x" * 20_000}, "20000 characters"),
    "a note of control": ("note", {"text": "\x1b[2J"}, "control"),
    "a setting without a value": ("setting", {"pass": "*", "key": "a"}, "value is missing"),
    "no calibration": ("calibration", {"document": {"format": 1}}, "format is 1"),
    "a calibration of another": (
        "calibration", {"document": DOCUMENT | {"ribbon": "GR-0666"}}, "GR-0666",
    ),
    "a stream that stands": ("stream", {"part": 9, "rate": 0}, "greater than 0"),
    "another ribbon": ("ribbon", ribbon_table(RIBBON) | {"id": "GR-0666"}, "GR-0666"),
    "another length": ("ribbon", ribbon_table(RIBBON) | {"length": 9.0}, "with other sensors"),
    "a firmware of 7": ("ribbon", ribbon_table(RIBBON) | {"firmware": 7}, "firmware is 7"),
    "a title of 7": ("title", {"title": 7}, "title is 7"),
}  # fmt: skip


@pytest.mark.parametrize("name", HOSTILE)
def test_what_cannot_be_meant_is_refused(name):
    action, detail, words = HOSTILE[name]
    with pytest.raises(SessionError) as caught:
        state_of(("pass", RUN | {"part": 1}), (action, detail))
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("action", ["pose", "pass", "stream", "survey"])
def test_without_a_ribbon_there_is_nothing_to_capture(action):
    detail = {"pose": POSE | {"part": 1}, "pass": RUN | {"part": 1},
              "stream": {"part": 1, "rate": 9}, "survey": {"mark": [MARK]}}[action]  # fmt: skip
    made = Event(1, TIME, "created", {})
    with pytest.raises(SessionError, match="no ribbon is known"):
        fold([made, Event(2, TIME, action, detail)])


def test_the_frames_of_one_ribbon_stay_its_even_undone():
    done = ("pass", RUN | {"part": 1}), ("undo", {"of": 3})
    with pytest.raises(SessionError, match="GR-0666"):
        state_of(*done, ("ribbon", ribbon_table(RIBBON) | {"id": "GR-0666"}))
    faster = ribbon_table(RIBBON) | {"rate": 50.0, "firmware": "2"}
    state = state_of(*done, ("ribbon", faster))
    assert (state.ribbon.rate, state.firmware) == (50.0, "2")
    other = ribbon_table(RIBBON) | {"id": "GR-0002"}
    assert state_of(("ribbon", other)).ribbon.id == "GR-0002"
    with pytest.raises(SessionError, match="GR-0002"):
        state_of(("calibration", {"document": DOCUMENT}), ("ribbon", other))


def test_entries_of_a_kind_are_bounded(monkeypatch):
    monkeypatch.setattr("georibbon.session.state.MAX_FILES", 2)
    for actions in (
        [("note", {"text": str(i)}) for i in range(3)],
        [("skip", {"pass": str(i)}) for i in range(3)],
        [("pose", POSE | {"key": str(i), "part": i + 1}) for i in range(3)],
        [("setting", {"pass": str(i), "key": "a", "value": 1}) for i in range(3)],
    ):
        state_of(*actions[:2])
        with pytest.raises(SessionError, match="at most 2"):
            state_of(*actions)
    monkeypatch.setattr("georibbon.session.state.MAX_EVENTS", 2)
    with pytest.raises(SessionError, match="more than 2 events"):
        state_of(("note", {"text": "x"}))


def test_a_journal_with_a_gap_is_damaged():
    events = journal(("note", {"text": "a"}), ("note", {"text": "b"}))
    for left in ([], events[1:], [*events[:2], events[3]], [events[0], events[0]]):
        with pytest.raises(DamagedError, match="missing"):
            fold(left)


OTHER = st.one_of(
    st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=3),
    st.lists(st.floats(), max_size=3), st.just({}), st.just([{}]),
)  # fmt: skip
DETAILS = {
    "ribbon": ribbon_table(RIBBON), "title": {"title": "x"}, "workpiece": {"level": True},
    "plan": PLAN | {"layout": {"spacing": 0.1, "marks": 2}}, "pose": POSE | {"part": 5},
    "pass": RUN | {"part": 5}, "remove": {"pass": "P1"}, "order": {"passes": ["P1"]},
    "skip": {"pass": "P1"}, "survey": {"mark": [MARK], "distance": [], "crossing": []},
    "setting": {"pass": "*", "key": "a", "value": 1}, "calibration": {"document": DOCUMENT},
    "settings": {"changes": [{"pass": "P1", "key": "a", "value": [1, 2]}]},
    "note": {"text": "x", "pass": "P1"}, "undo": {"of": 3}, "redo": {"of": 3},
    "stream": {"part": 5, "rate": 9.0}, "link": {"state": "x", "reason": "y"},
    "recovered": {"to": TIME, "frames": 1}, "moved": {"from": "x"}, "closed": {"frames": 1},
    "opened": {}, "created": {"georibbon": "0"},
}  # fmt: skip


@given(st.data())
def test_any_other_value_anywhere_is_refused_or_meant_and_never_a_fault(data):
    action = data.draw(st.sampled_from(sorted(DETAILS)))
    detail = json.loads(json.dumps(DETAILS[action]))
    container = detail
    while isinstance(container, dict | list) and container:
        keys = sorted(container) if isinstance(container, dict) else range(len(container))
        key = data.draw(st.sampled_from(list(keys)))
        below = container[key]
        if not isinstance(below, dict | list) or not below or data.draw(st.booleans()):
            container[key] = data.draw(OTHER)
            break
        container = below
    events = journal(("pass", RUN | {"part": 1}), (action, detail))
    with contextlib.suppress(SessionError, DamagedError):
        parts_of(events)
        state = fold(events)
        assert in_words(state.history[-1])
        assert state.undoable


def test_every_action_has_its_words():
    assert sorted(DETAILS) == sorted(ACTIONS)
    for action, detail in DETAILS.items():
        words = in_words(Event(1, TIME, action, detail))
        assert words
        assert words != action
        assert in_words(Event(1, TIME, action, {"pass": {"a": 9}}))


def row(**changes):
    """The row of an event with other values; its digest is of the values as they were."""
    names = ("id", "time", "action", "detail", "digest")
    good = dict(zip(names, Event(3, TIME, "note", {"text": "ä"}).row, strict=True))
    return tuple((good | changes).values())


def test_a_row_comes_back():
    found = event_of(row())
    assert (found.id, found.time, found.action, found.detail) == (3, TIME, "note", {"text": "ä"})


@pytest.mark.parametrize(
    "changes",
    [{"id": 4}, {"time": TIME.replace("5", "6")}, {"action": "title"}, {"detail": "{}"},
     {"digest": b""}, {"digest": None}, {"id": "3"}, {"detail": b"{}"}, {"time": None}],
)  # fmt: skip
def test_a_row_that_is_not_as_it_was_written_is_damaged(changes):
    with pytest.raises(DamagedError):
        event_of(row(**changes))


@pytest.mark.parametrize(
    "forged",
    [Event(0, TIME, "note", {}), Event(1, TIME, "dance", {}), Event(1, "yesterday", "note", {}),
     Event(1, "2026-01-02T03:04:05", "note", {}), Event(1, "2" * 99, "note", {})],
)  # fmt: skip
def test_a_row_of_another_make_is_refused(forged):
    with pytest.raises(DamagedError):
        event_of(forged.row)


@pytest.mark.parametrize("values", [(), (1,), (*Event(1, TIME, "note", {}).row, None)])
def test_a_row_of_another_table_is_refused(values):
    with pytest.raises(DamagedError, match="the values that it should"):
        event_of(values)


@pytest.mark.parametrize(
    "text", ["", "[]", "1", "{", "[" * 100_000, '{"a":NaN}', '{"a":Infinity}', "9" * 9999, "{}" * 2]
)
def test_a_detail_that_is_no_object_is_damaged(text):
    with pytest.raises(DamagedError):
        decode_detail(text)


def test_what_is_no_json_or_too_long_is_not_written(monkeypatch):
    deep = []
    for _ in range(100_000):
        deep = [deep]
    for value in (float("nan"), b"x", "\ud800", {1, 2}, deep):
        with pytest.raises(SessionError, match="plain numbers and texts"):
            _ = Event(1, TIME, "note", {"text": value}).row
    monkeypatch.setattr("georibbon.session.events.MAX_DETAIL", 10)
    with pytest.raises(SessionError, match="at most 10 are kept"):
        _ = Event(1, TIME, "note", {"text": "xxxxxxxxx"}).row
    with pytest.raises(DamagedError, match="more than 10"):
        decode_detail("{" + " " * 20 + "}")
