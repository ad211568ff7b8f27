"""Damaged sessions: opened, salvaged or refused, and never anything but what was captured."""

import functools
import shutil
import sqlite3
import tempfile
from contextlib import closing
from pathlib import Path

import journals
import numpy as np
import old
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from made import RIBBON, readings, same

from georibbon.errors import GeoribbonError, SessionError
from georibbon.ribbon import Readings
from georibbon.session import carving, restoration
from georibbon.session import database as database_module
from georibbon.session.chunks import Chunk, DamagedError, pack
from georibbon.session.database import read_chunks
from georibbon.session.events import ACTIONS
from georibbon.session.reading import contents, frames_of, reading
from georibbon.session.salvage import check_session, salvage
from georibbon.session.schema import PAGE_SIZE
from georibbon.session.session import Session
from georibbon.session.state import parts_of

MADE = journals.capture()


@functools.cache
def written():
    """The bytes of the session."""
    with tempfile.TemporaryDirectory() as name:
        journals.write(Path(name) / "s.georibbon", MADE.events, MADE.chunks)
        return (Path(name) / "s.georibbon").read_bytes()


@pytest.fixture
def session(tmp_path):
    """That session in a file."""
    path = tmp_path / "s.georibbon"
    path.write_bytes(written())
    return path


def held(path):
    """What a session holds: its state, and the frames of all its parts."""
    with reading(path) as database:
        found = contents(database, path)
        frames = {part: frames_of(read_chunks(database, part), found.state) for part in found.sizes}
        return found.state, frames


def captures(state):
    """What was captured under each name, as (kind, name, part)."""
    poses = {("pose", pose.key, pose.part) for pose in state.poses}
    return poses | {("pass", run.name, run.part) for run in state.passes}


CAPTURED = {
    (event.action, event.detail.get("key", event.detail["name"]), event.detail["part"])
    for event in MADE.events
    if event.action in ("pose", "pass")
}


def check_law(path, target):
    """Open, salvage or refuse a damaged session; returns which, and how many passes are there."""
    before = path.read_bytes()
    try:
        found = check_session(path)
    except GeoribbonError as error:
        assert "\n" not in str(error)  # noqa: PT017 (refusing is a good end too)
        return "refused", 0
    if found.ok:
        end, place = "opened", path
    else:
        end, place = "salvaged", target
        saved = salvage(path, target)
        assert check_session(target).verdict == "fine"
        assert (saved.passes, saved.poses) == (found.passes, found.poses)
        assert saved.lost == found.lost
    state, frames = held(place)
    check_held(state, frames, found.lost)
    if found.ok:
        assert captures(state) == captures(held_intact()[0])
    assert path.read_bytes() == before
    return end, len(state.passes)


@functools.cache
def held_intact():
    """What the undamaged session holds."""
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "s.georibbon"
        path.write_bytes(written())
        return held(path)


def check_held(state, frames, lost):
    """Every pass is one that was captured under its name, every event one that was written."""
    assert captures(state) <= CAPTURED
    kept = {part for _, _, part in captures(state)}
    for part, found in frames.items():
        all_of = MADE.parts[part]
        if part in kept:
            assert same(found, all_of)
        there = np.isin(all_of.t, found.t)
        assert np.array_equal(found.t, all_of.t[there])
        assert np.array_equal(found.counts, all_of.counts[there], equal_nan=True)
    for event, was in zip(state.history, MADE.events, strict=False):
        if event.row != was.row:
            assert event.action in ("created", "recovered", "note", "remove", "ribbon", "closed")
            assert lost
    missing = {name for kind, name, _ in captures(held_intact()[0]) if kind == "pass"}
    missing -= {name for kind, name, _ in captures(state) if kind == "pass"}
    assert bool(lost) or not missing


def flipped(body, count, seed):
    """Bytes with some of them changed."""
    body, chance = bytearray(body), np.random.default_rng(seed)
    for place in chance.choice(len(body), count, replace=False):
        body[place] ^= int(chance.integers(1, 256))
    return bytes(body)


def cut(body, seed):
    """Bytes cut off somewhere."""
    return body[: int(np.random.default_rng(seed).integers(len(body)))]


def page_lost(body, page):
    """Bytes with one page zeroed."""
    return body[: page * PAGE_SIZE] + bytes(PAGE_SIZE) + body[(page + 1) * PAGE_SIZE :]


DAMAGES = {
    "one byte": [flipped(written(), 1, seed) for seed in range(25)],
    "a byte of the first pages": [
        flipped(written()[: 4 * PAGE_SIZE], 1, seed) + written()[4 * PAGE_SIZE :]
        for seed in range(25)
    ],
    "twenty bytes": [flipped(written(), 20, seed) for seed in range(15)],
    "cut off": [cut(written(), seed) for seed in range(15)],
    "a page": [page_lost(written(), page) for page in (*range(8), *range(9, 70, 6))],
}


@pytest.mark.parametrize("kind", DAMAGES)
def test_damaged_in_any_way_nothing_wrong_is_taken_for_good(session, tmp_path, kind):
    ends = []
    for body in DAMAGES[kind]:
        session.write_bytes(body)
        target = tmp_path / "saved.georibbon"
        ends.append(check_law(session, target))
        target.unlink(missing_ok=True)
    assert len(ends) == len(DAMAGES[kind])
    if kind == "one byte":  # costs at most a pass, and one event
        assert all(passes >= 3 for _, passes in ends)
    if kind == "cut off":
        assert all(end != "opened" for end, _ in ends)


@given(st.data())
@settings(max_examples=25, deadline=None)
def test_whatever_is_damaged_nothing_wrong_is_taken_for_good(data):
    body = bytearray(written())
    for _ in range(data.draw(st.integers(0, 3))):
        start = data.draw(st.integers(0, len(body) - 1))
        length = data.draw(st.integers(1, 2 * PAGE_SIZE))
        other = data.draw(st.integers(0, len(body) - 1) | st.none())
        piece = bytes(length) if other is None else written()[other : other + length]
        body[start : start + length] = piece
    for place in data.draw(st.lists(st.integers(0, len(body) - 1), max_size=5)):
        body[place] ^= data.draw(st.integers(1, 255))
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "s.georibbon"
        path.write_bytes(body)
        check_law(path, Path(name) / "saved.georibbon")


def test_an_undamaged_session_is_fine_and_salvaged_it_is_the_same(session, tmp_path):
    found = check_session(session)
    assert (found.verdict, found.ok, found.lost) == ("fine", True, ())
    assert (found.poses, found.passes, found.notes) == (2, 4, 1)
    assert found.events == len(MADE.events)
    assert found.frames == sum(part.t.size for part in MADE.parts.values())
    saved = salvage(session, tmp_path / "t.georibbon")
    assert saved.lost == ()
    state, frames = held(tmp_path / "t.georibbon")
    assert [event.row for event in state.history[:-2]] == [event.row for event in MADE.events]
    assert [event.action for event in state.history[-2:]] == ["note", "closed"]
    assert frames.keys() == MADE.parts.keys()
    assert all(same(frames[part], MADE.parts[part]) for part in frames)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["s.georibbon", "t.georibbon"]


def test_without_its_first_page_all_is_saved(session, tmp_path):
    session.write_bytes(page_lost(written(), 0))
    found = check_session(session)
    assert (found.verdict, len(found.lost)) == ("damaged", 1)
    assert "its header is destroyed" in found.message
    assert "whether more was done after event 22 (the file was closed) is not known" in found.lost
    assert salvage(session, tmp_path / "t.georibbon").passes == 4


def damaged_rows(path, table, where):
    """Spoil rows of a table so that they do not match their digests."""
    with closing(sqlite3.connect(path)) as database, database:
        database.execute(f"UPDATE {table} SET digest = zeroblob(32) WHERE {where}")  # noqa: S608


def number_of(**wanted):
    """The id of the last event with these values in its detail."""
    return [e.id for e in MADE.events if wanted.items() <= e.detail.items()][-1]


def test_a_pass_with_a_piece_missing_is_not_taken_for_good(session, tmp_path):
    part = MADE.events[number_of(name="P3") - 1].detail["part"]
    damaged_rows(session, "chunk", f"part = {part} AND place = 1")
    saved = salvage(session, tmp_path / "t.georibbon")
    state, frames = held(tmp_path / "t.georibbon")
    assert {run.name for run in state.passes} == {"P1", "P2", "T1"}
    sentence = (
        f"pass P3: 1 of 3 pieces of its frames is damaged; 2952 frames of it are kept beside the "
        f"passes, in part {part}"
    )
    assert sentence in saved.lost
    assert any("the order of the passes" in line for line in saved.lost)
    assert frames[part].t.size == 2952
    assert part in [stream.part for stream in state.streams]
    assert sentence in state.notes[-1].text


def test_what_was_redone_does_not_come_back_unasked(session, tmp_path):
    again = number_of(name="P2", frames=130)
    damaged_rows(session, "chunk", f"part = {MADE.events[again - 1].detail['part']}")
    saved = salvage(session, tmp_path / "t.georibbon")
    state, _ = held(tmp_path / "t.georibbon")
    assert "P2" not in {run.name for run in state.passes}
    assert state.history[again - 1].action == "remove"
    assert saved.lost[0] == "pass P2: 1 of 1 piece of its frames is damaged"


def test_what_was_captured_first_is_told_apart(session, tmp_path):
    first = number_of(name="P2", frames=150)
    damaged_rows(session, "chunk", f"part = {MADE.events[first - 1].detail['part']}")
    saved = salvage(session, tmp_path / "t.georibbon")
    assert saved.lost == (
        f"pass P2 as first captured ({journals.TIME}): 1 of 1 piece of its frames is damaged",
    )
    state, _ = held(tmp_path / "t.georibbon")
    assert {run.name for run in state.passes} == {"P1", "P2", "P3", "T1"}


@pytest.mark.parametrize(
    ("where", "numbers"),
    [("action = 'remove'", "event 15 is lost"), ("id BETWEEN 15 AND 17", "events 15–17 are lost")],
)
def test_a_lost_removal_brings_something_back_and_it_is_told(session, tmp_path, where, numbers):
    damaged_rows(session, "event", where)
    saved = salvage(session, tmp_path / "t.georibbon")
    assert any(line.startswith(numbers) for line in saved.lost)
    state, _ = held(tmp_path / "t.georibbon")
    assert "P4" in {run.name for run in state.passes}


def test_frames_whose_pass_is_lost_are_kept_beside_the_passes(session, tmp_path):
    number = number_of(name="P1")
    damaged_rows(session, "event", f"id = {number}")
    saved = salvage(session, tmp_path / "t.georibbon")
    part = MADE.events[number - 1].detail["part"]
    assert f"the event of part {part} is lost; its 150 frames are kept" in saved.lost
    state, frames = held(tmp_path / "t.georibbon")
    assert same(frames[part], MADE.parts[part])
    assert "P1" not in {run.name for run in state.passes}


def test_without_the_ribbon_the_journal_is_kept_and_it_is_told(session, tmp_path):
    damaged_rows(session, "event", "action = 'ribbon'")
    saved = salvage(session, tmp_path / "t.georibbon")
    assert (saved.poses, saved.passes, saved.frames) == (0, 0, 0)
    assert any("the ribbon's description is lost" in line for line in saved.lost)
    assert "the frames in part 3 do not tell what they are" in saved.lost
    state, _ = held(tmp_path / "t.georibbon")
    assert state.title == "a bonnet"
    assert "the table shook" in [note.text for note in state.notes]


def test_a_ribbon_told_of_again_is_enough(session, tmp_path):
    again = [*MADE.events[:-1], journals.event(len(MADE.events), "ribbon", **journals.RIBBON_TABLE)]
    session.unlink()
    journals.write(session, again, MADE.chunks)
    damaged_rows(session, "event", "id IN (1, 2)")
    saved = salvage(session, tmp_path / "t.georibbon")
    assert (saved.poses, saved.passes) == (2, 4)
    state, frames = held(tmp_path / "t.georibbon")
    check_held(state, frames, saved.lost)


def test_of_a_stream_it_is_told_how_much_is_lost(session, tmp_path):
    damaged_rows(session, "chunk", "part = 3 AND place = 2")
    saved = salvage(session, tmp_path / "t.georibbon")
    assert saved.lost == ("904 frames between poses and passes are lost",)
    damaged_rows(session, "event", "action = 'closed'")
    _, line = salvage(session, tmp_path / "u.georibbon").lost
    assert "4096 frames can be read; how many there were is not known" in line


@pytest.mark.parametrize("size", [512, 4096])
def test_a_stream_whose_chunks_were_taken_together_is_saved_once(tmp_path, size):
    """Small chunks at the end become a large one with the first one's place, and are deleted."""
    path, all_of = tmp_path / "s.georibbon", readings(2500, seed=9)
    small = [block(all_of, start, start + 20) for start in range(0, 2500, 20)]
    with closing(journals.opened(path, size)) as database:
        database.execute("PRAGMA secure_delete = OFF")
        journals.add(database, MADE.events[:2])
        journals.add(database, [journals.event(3, "stream", part=1, rate=100.0)])
        for place, part in enumerate(small):
            journals.add(database, chunks=pack(part, 1, place))
            if place == 101:
                database.execute("DELETE FROM chunk")
                journals.add(database, chunks=pack(block(all_of, 0, 2040), 1, 0))
            if place >= 102:
                database.execute("UPDATE chunk SET place = place + 0")
    body = path.read_bytes()
    saved = salvage(path, tmp_path / "t.georibbon")
    assert same(held(tmp_path / "t.georibbon")[1][1], all_of)
    assert saved.frames == 2500
    assert path.read_bytes() == body


def test_frames_that_two_chunks_hold_are_kept_once(tmp_path):
    path, all_of = tmp_path / "s.georibbon", readings(40, seed=9)
    stream = journals.event(3, "stream", part=1, rate=100.0)
    overlapping = [*pack(block(all_of, 0, 20), 1, 0), *pack(block(all_of, 10, 40), 1, 1)]
    journals.write(path, [*MADE.events[:2], stream], overlapping)
    assert check_session(path).verdict == "damaged"
    assert salvage(path, tmp_path / "t.georibbon").frames == 40
    assert same(held(tmp_path / "t.georibbon")[1][1], all_of)


def block(of, start, end):
    """Some frames of readings."""
    return Readings(of.t[start:end], of.counts[start:end])


@pytest.fixture
def crashed(tmp_path):
    """A session as a crash leaves it, with half of it in the log."""
    path, copy = tmp_path / "open" / "s.georibbon", tmp_path / "s.georibbon"
    path.parent.mkdir()
    with closing(journals.opened(path)) as database:
        for event in MADE.events[:-1]:
            if event.id == 8:
                database.execute("PRAGMA journal_mode = WAL")
                database.execute("PRAGMA wal_autocheckpoint = 0")
            part = event.detail.get("part")
            journals.add(database, [event], [c for c in MADE.chunks if c.part == part])
        journals.add(database, [journals.event(len(MADE.events), text="last words")])
        for end in ("", "-wal"):
            shutil.copy(f"{path}{end}", f"{copy}{end}")
    return copy


def everything(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


def test_a_session_left_by_a_crash_is_told_from_a_damaged_one(crashed):
    before = everything(crashed.parent)
    found = check_session(crashed)
    assert (found.verdict, found.ok) == ("not closed", True)
    assert "was not closed" in found.message
    assert found.passes == 4
    assert everything(crashed.parent) == before


def test_what_stands_behind_a_damaged_place_of_the_log_is_saved(crashed, tmp_path):
    log = Path(f"{crashed}-wal")
    body = bytearray(log.read_bytes())
    body[-3 * (PAGE_SIZE + 24) - 100] ^= 1
    log.write_bytes(body)
    before = everything(crashed.parent)
    found = check_session(crashed)
    assert found.verdict == "damaged"
    assert "would lose" in found.message
    assert everything(crashed.parent) == before
    salvage(crashed, tmp_path / "t.georibbon")
    state, frames = held(tmp_path / "t.georibbon")
    assert "last words" in [note.text for note in state.notes]
    assert all(same(frames[part], MADE.parts[part]) for part in frames)


@pytest.mark.parametrize("seed", range(12))
def test_a_damaged_log_never_gives_wrong_data(crashed, tmp_path, seed):
    log = Path(f"{crashed}-wal")
    body = flipped(log.read_bytes(), 1 + seed, seed)
    log.write_bytes(body if seed % 2 else body[: len(body) * seed // 12])
    try:
        found = check_session(crashed)
        target = crashed if found.ok else tmp_path / "t.georibbon"
        if not found.ok:
            salvage(crashed, target)
    except GeoribbonError as error:
        assert "\n" not in str(error)  # noqa: PT017 (refusing is a good end too)
        return
    state, _ = held(target)
    assert captures(state) <= CAPTURED


def test_another_event_under_the_same_number_is_told(crashed, tmp_path):
    with closing(sqlite3.connect(crashed)) as database, database:
        database.execute("PRAGMA journal_mode = WAL")
    with closing(sqlite3.connect(crashed, isolation_level=None)) as database:
        row = (*journals.event(3, "title", title="another").row, 3)
        query = "UPDATE event SET id=?, time=?, action=?, detail=?, digest=? WHERE id=?"
        database.execute(query, row)
        copy = tmp_path / "copy.georibbon"
        for end in ("", "-wal"):
            shutil.copy(f"{crashed}{end}", f"{copy}{end}")
    saved = salvage(copy, tmp_path / "t.georibbon")
    assert "there are two different events 3; the later one is kept" in saved.lost
    assert held(tmp_path / "t.georibbon")[0].title == "another"


def live(session, path):
    """A copy of an open session's files, as a crash would leave them, and what is in it then."""
    for end in ("", "-wal"):
        shutil.copy(f"{session.path}{end}", f"{path}{end}")
    parts = parts_of(session.state.history)
    return session.state, {part: session.readings(part) for part in parts}


def check_same(found, expected, more):
    """The same events and frames, and so many events more."""
    (state, frames), (was, parts) = found, expected
    rows = [event.row for event in state.history]
    assert rows[: len(rows) - more] == [event.row for event in was.history]
    assert frames.keys() == parts.keys()
    assert all(same(frames[part], parts[part]) for part in parts)


def test_a_session_is_saved_as_it_is_at_any_moment(tmp_path):
    """Streams grow, and their small chunks are taken together, while passes come."""
    chance = np.random.default_rng(4)
    with Session.create(tmp_path / "live.georibbon", RIBBON, title="live") as session:
        stream, start, everything_of = session.stream(100.0), 0, readings(6000, seed=3)
        for i in range(12):
            for _ in range(int(chance.integers(1, 25))):
                end = start + int(chance.integers(1, 60))
                stream.append(block(everything_of, start, end))
                assert stream.flush()
                start = end
            session.add_pass(f"P{i % 5}", "pass", readings(30 + 500 * i, seed=i))
            if i % 3 == 0:
                session.undo()
            copy, target = tmp_path / f"{i}.georibbon", tmp_path / f"saved-{i}.georibbon"
            expected = live(session, copy)
            assert check_session(copy).verdict == "not closed"
            saved = salvage(copy, target)
            check_same(held(target), expected, 2)
            assert [line for line in saved.lost if "not known" not in line] == []
        with pytest.raises(SessionError, match="has the session open"):
            check_session(session.path)
        with pytest.raises(SessionError, match="has the session open"):
            salvage(session.path, tmp_path / "t.georibbon")
    assert check_session(tmp_path / "live.georibbon").verdict == "fine"
    salvage(tmp_path / "live.georibbon", tmp_path / "t.georibbon")
    check_same(held(tmp_path / "t.georibbon"), held(tmp_path / "live.georibbon"), 2)


VERSION_1 = old.VERSION_1.read_bytes()


def old_held(path):
    """Poses and passes with their frames, by name."""
    state, frames = held(path)
    return {one.name: frames[one.part] for one in (*state.poses, *state.passes)}


def test_a_session_of_version_1_is_checked(tmp_path):
    path = tmp_path / "s.georibbon"
    path.write_bytes(VERSION_1)
    found = check_session(path)
    assert (found.verdict, found.poses, found.passes) == ("fine", 2, 3)


@pytest.mark.parametrize("seed", range(12))
def test_a_damaged_session_of_version_1_is_saved(tmp_path, seed):
    path, target = tmp_path / "s.georibbon", tmp_path / "t.georibbon"
    body = flipped(VERSION_1, 1 + seed, seed)
    path.write_bytes(page_lost(body, 0) if seed % 3 == 0 else body)
    try:
        found = check_session(path)
        if not found.ok:
            saved = salvage(path, target)
            assert check_session(target).verdict == "fine"
    except SessionError as error:
        assert "nothing of the session's journal" in str(error)  # noqa: PT017
        return
    was = {one.name: one.readings for one in (*old.recording().poses, *old.recording().passes)}
    there = old_held(path if found.ok else target)
    assert all(same(there[name], was[name]) for name in there)
    if not found.ok and len(there) < len(was):
        assert saved.lost


def test_of_version_1_all_but_the_damaged_pass_is_saved(tmp_path):
    path, target = tmp_path / "s.georibbon", tmp_path / "t.georibbon"
    path.write_bytes(VERSION_1)
    with closing(sqlite3.connect(path)) as database, database:
        database.execute("UPDATE chunk SET digest = zeroblob(32) WHERE part = 3 AND place = 1")
        database.execute("UPDATE mark SET x = 9 WHERE place = 0")
        database.execute("INSERT INTO note VALUES (9, 'now', 'not sealed')")
    saved = salvage(path, target)
    assert saved.lost == (
        "the table mark (version 1) is lost",
        "pass P1: 1 of 2 pieces of its frames is damaged; 2048 frames of it are kept beside the "
        "passes, in part 3",
    )
    state, _ = held(target)
    assert state.ribbon == RIBBON
    assert [run.name for run in state.passes] == ["Ärmel 2", "T1"]
    assert state.title == old.recording().title
    assert state.marks == ()
    assert state.distances == old.recording().distances
    assert "not sealed" not in [note.text for note in state.notes]


JSON = st.recursive(
    st.none() | st.booleans() | st.integers(-3, 2**70) | st.floats(allow_nan=False,
    allow_infinity=False) | st.text(max_size=5) | st.sampled_from(["P1", "pass", "\n"]),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=4), inner,
    max_size=3), max_leaves=5,
)  # fmt: skip


@st.composite
def any_events(draw):
    """The capture's events, some left out, some with other ids, actions and values."""
    events = []
    for was in MADE.events:
        kind = draw(st.sampled_from(["as it was"] * 9 + ["left out", "action", "value", "id"]))
        number, action, detail = was.id, was.action, dict(was.detail)
        if kind == "left out":
            continue
        if kind == "action":
            action = draw(st.sampled_from(sorted(ACTIONS)))
        if kind == "value":
            known = [*sorted(detail), "pass", "of", "part", "name"]
            detail[draw(st.sampled_from(known) | st.text(max_size=3))] = draw(JSON)
        if kind == "id":
            number = draw(st.integers(1, 60) | st.integers(1, 2**62))
        events.append(journals.event(number, action, **detail))
    return list({event.id: event for event in events}.values())


@given(any_events())
@settings(max_examples=40, deadline=None)
def test_any_events_with_their_digests_are_read_salvaged_or_refused(events):
    with tempfile.TemporaryDirectory() as name:
        path, target = Path(name) / "s.georibbon", Path(name) / "t.georibbon"
        journals.write(path, events, MADE.chunks)
        try:
            found = check_session(path)
            if found.ok:
                return
            saved = salvage(path, target)
        except GeoribbonError as error:
            assert "\n" not in str(error)  # noqa: PT017 (refusing is a good end too)
            return
        assert all("\n" not in line for line in saved.lost)
        assert check_session(target).verdict == "fine"
        state, frames = held(target)
        for _, _, part in captures(state):
            assert same(frames[part], MADE.parts[part])


def test_what_is_no_session_is_refused(tmp_path):
    (tmp_path / "text.georibbon").write_text("t,A01x\n" * 1000)
    (tmp_path / "folder").mkdir()
    with closing(sqlite3.connect(tmp_path / "other.georibbon")) as database, database:
        database.execute("CREATE TABLE event (id INTEGER PRIMARY KEY, a TEXT)")
    for name, words in (
        ("text.georibbon", "no Georibbon session"),
        ("other.georibbon", "another program's database"),
        ("folder", "this is no file"),
        ("none.georibbon", "no such file"),
        ("n" * 5000, "no such file"),
    ):
        with pytest.raises(SessionError, match=words):
            check_session(tmp_path / name)
        with pytest.raises(SessionError):
            salvage(tmp_path / name, tmp_path / "t.georibbon")
    assert not (tmp_path / "t.georibbon").exists()


def test_a_newer_session_is_refused_and_not_cut_down(session):
    with closing(sqlite3.connect(session)) as database:
        database.execute("PRAGMA user_version = 3")
    with pytest.raises(SessionError, match="newer than 2"):
        check_session(session)
    with closing(sqlite3.connect(session)) as database:
        database.execute("PRAGMA user_version = 1073741826")
    assert check_session(session).lost == ()


def test_nothing_is_overwritten(session, tmp_path):
    (tmp_path / "t.georibbon").write_text("years of work")
    for target in (tmp_path / "t.georibbon", session, tmp_path):
        with pytest.raises(SessionError):
            salvage(session, target)
    assert (tmp_path / "t.georibbon").read_text() == "years of work"
    assert session.read_bytes() == written()
    with pytest.raises(SessionError, match="cannot be written"):
        salvage(session, tmp_path / "none" / "t.georibbon")


def test_a_journal_that_makes_no_sense_is_refused(tmp_path, monkeypatch):
    path = tmp_path / "s.georibbon"
    nonsense = [journals.event(n, "undo", of=n) for n in range(2, 200)]
    journals.write(path, [journals.event(1, "created"), *nonsense])
    assert check_session(path).lost[-1].startswith("event 199")
    monkeypatch.setattr(restoration, "MAX_FOLDED", 500)
    with pytest.raises(SessionError, match="makes no sense"):
        check_session(path)


def test_an_event_far_off_is_left_out(session, tmp_path, monkeypatch):
    monkeypatch.setattr(restoration, "MAX_LOST", 50)
    session.unlink()
    journals.write(session, [*MADE.events, journals.event(100_000, text="far")], MADE.chunks)
    saved = salvage(session, tmp_path / "t.georibbon")
    assert "the events from 100000 on are left out: too many before are lost" in saved.lost
    assert (saved.passes, saved.events) == (4, len(MADE.events) + 2)
    session.unlink()
    journals.write(session, [journals.event(100_000, text="far")], MADE.chunks)
    with pytest.raises(SessionError, match="only 14 pieces of frames of which nothing says"):
        check_session(session)


def test_not_more_is_told_than_a_person_reads(session, tmp_path, monkeypatch):
    monkeypatch.setattr(restoration, "MAX_TOLD", 2)
    damaged_rows(session, "chunk", "part < 6")
    saved = salvage(session, tmp_path / "t.georibbon")
    assert saved.lost[2:] == ("and 4 losses more",)


def test_frames_of_which_there_are_two_kinds_are_not_taken_for_good(tmp_path):
    """As when another pass was written over a part whose first frames are still in the file."""
    path = tmp_path / "s.georibbon"
    run = journals.event(3, "pass", name="P1", kind="pass", part=1, frames=300)
    with closing(journals.opened(path)) as database:
        (made,) = database.execute("SELECT sql FROM sqlite_schema WHERE name = 'chunk'").fetchone()
        database.execute("DROP TABLE chunk")
        database.execute(made.replace(", UNIQUE (part, place)", ""))
        journals.add(database, [*MADE.events[:2], run], pack(readings(300, seed=7), 1))
        journals.add(database, chunks=pack(readings(300, seed=8), 1))
    assert "more than once and differ" in check_session(path).lost[0]
    assert salvage(path, tmp_path / "t.georibbon").passes == 0


def test_a_file_that_changes_while_it_is_salvaged_is_told(session, tmp_path, monkeypatch):
    def changed(*_):
        raise DamagedError("frames of part 1 changed while they were read")

    monkeypatch.setattr(restoration, "stretch", changed)
    damaged_rows(session, "event", "id = 3")
    with pytest.raises(SessionError, match="see that no program writes to it"):
        check_session(session)
    with pytest.raises(SessionError, match="see that no program writes to it"):
        salvage(session, tmp_path / "t.georibbon")
    assert list(tmp_path.iterdir()) == [session]


def test_a_session_that_another_program_has_locked_is_no_damaged_one(session, monkeypatch):
    at_once = functools.partial(database_module.connect, timeout=0.0)
    monkeypatch.setattr("georibbon.session.reading.connect", at_once)
    with closing(sqlite3.connect(session, isolation_level=None)) as database:
        database.execute("BEGIN EXCLUSIVE")
        with pytest.raises(SessionError, match="another program is writing"):
            check_session(session)


def test_what_was_not_gone_through_wholly_is_told(session, tmp_path, monkeypatch):
    monkeypatch.setattr(carving, "MAX_ROWS", 30)
    saved = salvage(session, tmp_path / "t.georibbon")
    assert "the file leads in circles; not all of it was searched" in saved.lost


def forged(t, width=2, columns=8):
    """A chunk with any times and the digest that goes with them."""
    t = np.array(t, dtype="<f8")
    return Chunk(1, 0, t.size, width, t.tobytes(), bytes(t.size * width * columns))


@pytest.mark.parametrize("t", [[0.0, 0.0], [1.0, np.nan], [0.0, np.inf], [2.0, 1.0]])
@pytest.mark.parametrize("action", ["pass", "stream"])
def test_frames_with_a_digest_and_no_sense_are_not_kept(tmp_path, t, action):
    detail = {"name": "P", "kind": "pass", "part": 1, "frames": 2}
    if action == "stream":
        detail = {"part": 1, "rate": 100.0}
    path = tmp_path / "s.georibbon"
    journals.write(path, [*MADE.events[:2], journals.event(3, action, **detail)], [forged(t)])
    assert check_session(path).verdict == "damaged"
    saved = salvage(path, tmp_path / "t.georibbon")
    assert (saved.passes, saved.frames) == (0, 0)


HOSTILE = {
    "very many frames": [journals.event(3, "pass", name="P", kind="pass", part=1, frames=2**53)],
    "a part twice": [journals.event(3, "stream", part=1, rate=1.0)] * 2,
    "no part": [journals.event(3, "stream", part="1", rate=1.0)],
    "no frames": [journals.event(3, "pass", name="P", kind="pass", part=1, frames=0)],
    "no name": [journals.event(3, "pass", name=["P"], kind="pass", part=1, frames=4)],
    "another's part": [
        journals.event(3, "pass", name="P", kind="pass", part=1, frames=4),
        journals.event(4, "pass", name="Q", kind="pass", part=1, frames=4),
    ],
    "an undo of nothing": [journals.event(3, "undo", of=1)],
}


@pytest.mark.parametrize("name", HOSTILE)
def test_what_has_a_digest_and_no_sense_is_left_out(tmp_path, name):
    path = tmp_path / "s.georibbon"
    events = [journals.event(i, e.action, **e.detail) for i, e in enumerate(HOSTILE[name], start=3)]
    journals.write(path, [*MADE.events[:2], *events], pack(readings(4), 1))
    assert check_session(path).verdict == "damaged"
    saved = salvage(path, tmp_path / "t.georibbon")
    words = ("left out", "not known", "are damaged")
    assert any(word in line for word in words for line in saved.lost)
    assert check_session(tmp_path / "t.georibbon").verdict == "fine"
