"""The recording folder: what is written is read back, and every defect is named."""

import os
import re
import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from made import RIBBON, readings, recording, recordings, same

from georibbon.errors import RecordingError
from georibbon.recording import Pass, Recording, Workpiece
from georibbon.ribbon import Readings
from georibbon.session import files, folder
from georibbon.session.fields import Source
from georibbon.session.folder import read_recording, write_recording
from georibbon.session.outline import read_outline, tables_of


@pytest.fixture
def place(tmp_path):
    """The folder of the recording made by hand."""
    write_recording(recording(), tmp_path / "made")
    return tmp_path / "made"


def edit(path, old, new):
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new, 1), encoding="utf-8", newline="")


def refused(place):
    """The sentence with which a folder is refused: one line, ended by a remedy."""
    with pytest.raises(RecordingError) as caught:
        read_recording(place)
    assert "\n" not in str(caught.value)
    return str(caught.value)


@given(recordings())
def test_a_recording_written_is_read_back_to_the_last_bit(made):
    with tempfile.TemporaryDirectory() as name:
        write_recording(made, Path(name) / "out")
        assert same(read_recording(Path(name) / "out"), made)


@given(recordings())
def test_files_are_unique_on_any_system_and_stay_in_the_folder(made):
    with tempfile.TemporaryDirectory() as name:
        write_recording(made, Path(name) / "out")
        found = [p for p in Path(name).rglob("*") if p.is_file()]
        assert len(found) == 1 + len(made.poses) + len(made.passes)
        assert len({str(p).lower() for p in found}) == len(found)
        plain = re.compile(r"(recording\.toml|calibration/pose-\d+\.csv|passes/[a-z0-9-]+\.csv)")
        for path in found:
            relative = path.relative_to(Path(name) / "out").as_posix()
            assert plain.fullmatch(relative)
            assert path.stem not in ("con", "nul", "aux")


DEFECTS = {
    "unknown format": (
        'format = "georibbon-recording"', 'format = "georibbon-recordings"',
        ["line 1", 'format is "georibbon-recordings"', '"georibbon-recording" is expected'],
    ),
    "no format": ('format = "georibbon-recording"\n', "", ["the field format is missing"]),
    "newer version": ("version = 1", "version = 2", ["line 2", "version is 2", "newer than 1"]),
    "older version": ("version = 1", "version = 0", ["line 2", "version is 0", "1 is expected"]),
    "version of the wrong type": ("version = 1", 'version = "1"', ["line 2", 'version is "1"']),
    "not TOML": ("length = 0.5", "length = ", ["this is not TOML", "line 7"]),
    "cut off": ('name = "T1"', 'name = "T1', ["this is not TOML", "line"]),
    "missing file": ("passes/p2.csv", "passes/p9.csv", ["passes/p9.csv", "missing"]),
    "file outside": ("passes/p2.csv", "../p2.csv", ["../p2.csv", "leaves the recording's folder"]),
    "file inside and out": ("passes/p2.csv", "passes/../../p2.csv", ["leaves the recording's"]),
    "absolute file": ("passes/p2.csv", "/etc/passwd", ["/etc/passwd", "leaves the recording's"]),
    "file of Windows": ('"passes/p2.csv"', r"'passes\p2.csv'", ["no plain path"]),
    "file on a drive": ("passes/p2.csv", "C:p2.csv", ["C:p2.csv", "no plain path"]),
    "a folder for a file": ("passes/p2.csv", "passes", ["passes: this is no regular file"]),
    "no path": ("passes/p2.csv", ".", ["no plain path"]),
    "a file twice": ("passes/p2.csv", "passes/p1.csv", ['"passes/p1.csv"', "named twice"]),
    "a file by two ways": ("passes/p2.csv", "./passes/p1.csv", ["the same one"]),
    "a pass twice": (
        'name = "P2"', 'name = "P1"', ["[[pass]] number 2 (\"P1\")", "that of pass number 1 too"],
    ),
    "a pass without a kind": (
        'name = "P2"\nkind = "pass"', 'name = "P2"', ["field kind is missing"],
    ),
    "an unknown kind of pass": (
        'name = "P2"\nkind = "pass"', 'name = "P2"\nkind = "passs"',
        ['kind is "passs"', '"pass" or "tie" is expected; did you mean "pass"?'],
    ),
    "one pass only": (
        'name = "P2"\nkind = "pass"', 'name = "P2"\nkind = "tie"', ["1 pass of kind"],
    ),
    "a mark on no pass": (
        'pass = "P1"', 'pass = "P7"', ["[[mark]] number 1", 'there is no pass "P7"', "line"],
    ),
    "a distance to no pass": (
        'passes = ["P1", "P2"]', 'passes = ["P1", "X"]',
        ["[[distance]] number 1", 'there is no pass "X"', '"P1", "P2", "T1"'],
    ),
    "a crossing with no pass": ('["P2", "T1"]', '["P2", "T2"]', ["[[crossing]]", 'no pass "T2"']),
    "a crossing with itself": ('["P2", "T1"]', '["P2", "P2"]', ["with itself", "two passes"]),
    "a crossing of three": ('["P2", "T1"]', '["P1", "P2", "T1"]', ["the names of two passes"]),
    "a crossing of numbers": ('["P2", "T1"]', "[1, 2]", ["passes holds 1", "names of two passes"]),
    "at outside": ("at = 0.0", "at = 0.6", ["[[mark]] number 1", "at is 0.6 m; 0 to 0.5 m"]),
    "at before": ("at = [0.0, 0.5]", "at = [-0.1, 0.5]", ["[[distance]]", "at is -0.1 m"]),
    "at missing": ("at = [0.0, 0.5]\n", "", ["[[distance]]", "the field at is missing"]),
    "at of one number": (
        "at = [0.0, 0.5]", "at = 0.5", ["[[distance]]", "at is 0.5", "two numbers"],
    ),
    "a position of two": (
        "[0.1, -0.2, 0.3]", "[0.1, -0.2]", ["position is [0.1, -0.2]", "[x, y, z]"],
    ),
    "a position not finite": ("[0.1, -0.2, 0.3]", "[0.1, nan, 0.3]", ["position is nan"]),
    "sigma zero": ("sigma = 0.0005", "sigma = 0.0", ["sigma is 0.0", "greater than 0"]),
    "sigma negative": ("sigma = 0.001", "sigma = -0.001", ["[[crossing]]", "sigma is -0.001"]),
    "sigma not a number": ("sigma = 0.001", "sigma = nan", ["[[crossing]]", "sigma is nan"]),
    "sigma infinite": ("sigma = 0.001", "sigma = inf", ["[[crossing]]", "sigma is inf"]),
    "sigma tiny": ("sigma = 0.001", "sigma = 1e-300", ["sigma is 1e-300", "at least 1e-09"]),
    "sigma a text": ("sigma = 0.001", 'sigma = "0.001"', ['sigma is "0.001"']),
    "sigma true": ("sigma = 0.001", "sigma = true", ["sigma is true"]),
    "sigma a table": ("sigma = 0.001", "sigma = { m = 1 }", ["sigma is a table"]),
    "sigma misspelt": ("sigma = 0.001", "sigm = 0.001", ['field "sigm"', 'did you mean "sigma"?']),
    "an unknown field": (
        "rate = 100.0", "rate = 1.0\nqqq = 1", ['"qqq"', "known here are id, length"],
    ),
    "an unknown table": ("[[mark]]", "[[marks]]", ['"marks"', 'did you mean "mark"?']),
    "distance zero": ("distance = 0.1", "distance = 0", ["[[distance]]", "distance is 0; metres"]),
    "a distance to itself": (
        'passes = ["P1", "P2"]\nat = [0.0, 0.5]', 'passes = ["P1", "P1"]\nat = [0.5, 0.5]',
        ["[[distance]]", "a point and itself"],
    ),
    "counts_per_unit zero": (
        "counts_per_unit = 16384.0", "counts_per_unit = 0",
        ['[[ribbon.sensor]] number 1 ("A01")', "counts_per_unit is 0", "greater than 0", "line 15"],
    ),
    "no accelerometer": (
        'kind = "accelerometer"', 'kind = "magnetometer"',
        ["[ribbon]", "there is no accelerometer"],
    ),
    "an unknown kind of sensor": (
        'kind = "accelerometer"', 'kind = "gyroscope"', ['kind is "gyroscope"', '"magnetometer"'],
    ),
    "an accelerometer of 2 axes": ("axes = 3", "axes = 2", ["axes is 2; 3 is expected"]),
    "axes not whole": ("axes = 3", "axes = 3.0", ["axes is 3.0"]),
    "a sensor outside": (
        "position = 0.4", "position = 0.6", ['"M02"', "position is 0.6 m", "0.5 m"],
    ),
    "a sensor twice": ('name = "M02"', 'name = "M01"', ['("M01")', "that of sensor number 2 too"]),
    "a sensor with a comma": ('name = "M02"', 'name = "M,2"', ["without commas"]),
    "a sensor without a name": (
        'name = "M02"\n', "", ["[[ribbon.sensor]] number 3", "name is missing"],
    ),
    "no ribbon": ("[ribbon]", "[workpiec]", ["is not known", "did you mean"]),
    "a ribbon of no length": ("length = 0.5", "length = 0", ["[ribbon]", "length is 0"]),
    "a ribbon of no rate": ("rate = 100.0", "rate = -1", ["[ribbon]", "rate is -1"]),
    "a ribbon without a name": ('id = "GR-0001"', 'id = " "', ["[ribbon]", 'id is " "']),
    "an empty pose name": (
        'name = "roll 0"', 'name = ""', ["[[pose]] number 1", "the pose's name"],
    ),
    "a name of two lines": ('name = "roll 0"', r'name = "a\nb"', ["leave out its control"]),
    "a name without end": ('name = "roll 0"', f'name = "{"n" * 300}"', ["300 characters", "200"]),
    "a pose's roll not finite": ("roll = 90.0", "roll = inf", ['("roll 90")', "roll is inf"]),
    "a pose's table a number": ("table = true", "table = 1", ["table is 1", "true or false"]),
    "a tilted workpiece": ("level = true", "level = false", ["[workpiece]", "z axis is vertical"]),
    "a heading of no number": (
        "heading = 25.0", 'heading = "N"', ["[workpiece]", 'heading is "N"'],
    ),
    "a huge number": (
        "length = 0.5", "length = 0x" + "f" * 9000, ["length is a number of thousands"],
    ),
    "a title of no text": ('title = "by hand"', "title = 7", ["line 3", "title is 7"]),
    "a title with a bell": ('title = "by hand"', r'title = "\u0007"', ["title", "control"]),
}  # fmt: skip


@pytest.mark.parametrize("name", DEFECTS)
def test_a_defect_of_the_toml_is_refused_by_name(place, name):
    old, new, words = DEFECTS[name]
    edit(place / "recording.toml", old, new)
    message = refused(place)
    for word in words:
        assert word in message
    assert "recording.toml" in message or "passes" in message


def test_the_line_is_told_in_the_right_table(place):
    edit(place / "recording.toml", "sigma = 0.001", "sigma = -1")
    lines = (place / "recording.toml").read_text(encoding="utf-8").split("\n")
    assert f"line {lines.index('sigma = -1') + 1}: " in refused(place)


@pytest.mark.parametrize("key", ["ribbon", "workpiece", "pose", "pass", "mark", "distance"])
@pytest.mark.parametrize("value", [5, "x", [5], None])
def test_a_value_where_tables_belong_is_refused(key, value):
    tables = tables_of(recording(), [str(i) for i in range(5)]) | {key: value}
    with pytest.raises(RecordingError, match=r"tables? (written )?\[.*expected"):
        read_outline(tables, Source("here", RecordingError))


def test_too_many_tables_are_refused():
    tables = tables_of(recording(), [str(i) for i in range(5)])
    for key, limit in (("mark", 100_000), ("pose", 10_000)):
        with pytest.raises(RecordingError, match=f"at most {limit} are read"):
            read_outline(tables | {key: [{}] * (limit + 1)}, Source("here", RecordingError))
    run = {"kind": "pass"}
    passes = [run | {"name": f"P{i}", "file": f"P{i}"} for i in range(9_999)]
    unseen = {"mark": [], "distance": [], "crossing": []}
    with pytest.raises(RecordingError, match="10001 poses and passes; at most 10000 are read"):
        read_outline(tables | unseen | {"pass": passes}, Source("here", RecordingError))


def test_tables_written_inline_have_no_line_and_are_named_all_the_same(place):
    text = (place / "recording.toml").read_text(encoding="utf-8")
    text = text[: text.index("[[mark]]")].replace(
        "version = 1\n", 'version = 1\nmark = [{ pass = "P9", at = 0.0 }]\n'
    )
    (place / "recording.toml").write_text(text, encoding="utf-8")
    assert refused(place).startswith('recording.toml: [[mark]] number 1 ("P9"): there is no pass')


def test_a_file_that_may_not_be_read_is_told(place, monkeypatch):
    def fail(*_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "open", fail)
    assert "recording.toml: the file cannot be read (Permission denied)" in refused(place)


def test_names_that_come_to_one_file_name_get_several(tmp_path):
    names = ["a-3", "a", "A", "a/", "A 4", "a-3x", "CON", "§", "ß"]
    passes = tuple(Pass(name, "pass", readings(seed=i)) for i, name in enumerate(names))
    write_recording(Recording(RIBBON, (), passes), tmp_path / "out")
    assert same(read_recording(tmp_path / "out").passes, passes)
    assert len(list((tmp_path / "out/passes").iterdir())) == len(names)


def test_deep_nesting_is_refused(place):
    (place / "recording.toml").write_text("a = " + "[" * 100_000)
    assert "nested too deeply" in refused(place)


def test_bytes_that_are_not_utf8_are_refused(place):
    (place / "recording.toml").write_bytes(b'format = "x"\n# \xff\n')
    assert "recording.toml, line 2: this is not UTF-8" in refused(place)


def test_a_link_out_of_the_folder_is_refused(place, tmp_path):
    (place / "passes/p1.csv").replace(tmp_path / "p1.csv")
    (place / "passes/p1.csv").symlink_to(tmp_path / "p1.csv")
    assert "passes/p1.csv: the file leads out of the recording's folder" in refused(place)


def test_a_circle_of_links_is_refused(place):
    (place / "passes/p1.csv").unlink()
    (place / "passes/p1.csv").symlink_to("p1.csv")
    assert "passes/p1.csv" in refused(place)


def test_a_pipe_is_refused_and_not_waited_for(place):
    (place / "passes/p1.csv").unlink()
    os.mkfifo(place / "passes/p1.csv")
    assert "passes/p1.csv: this is no regular file" in refused(place)


def test_no_recording_toml_is_refused(place):
    (place / "recording.toml").unlink()
    assert "there is no recording.toml in this folder" in refused(place)


@pytest.mark.parametrize("name", ["nothing", "made/recording.toml", "n" * 5000, "a\0b"])
def test_what_is_no_folder_is_refused(place, name):
    assert "give the folder of a recording" in refused(place.parent / name)


def test_bounds_hold(place, monkeypatch):
    monkeypatch.setattr(folder, "MAX_TOML", 100)
    assert "recording.toml: the file has more than 100 bytes" in refused(place)
    monkeypatch.undo()
    monkeypatch.setattr(folder, "MAX_CSV", 100)
    assert "calibration/pose-01.csv: the file has more than 100 bytes" in refused(place)
    monkeypatch.undo()
    monkeypatch.setattr(folder, "MAX_RECORDING", 300)
    assert "calibration/pose-02.csv: the file has more than" in refused(place)


def test_order_and_line_ends_of_others_are_read(place):
    expected = read_recording(place)
    for path in place.rglob("*.*"):
        if path.is_file():
            path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes().replace(b"\n", b"\r\n"))
    assert same(read_recording(place), expected)


@given(st.data())
def test_damaged_bytes_are_refused_or_read_and_never_a_fault(data):
    with tempfile.TemporaryDirectory() as name:
        place = Path(name) / "made"
        write_recording(recording(), place)
        path = place / data.draw(st.sampled_from(["recording.toml", "passes/p1.csv"]))
        body = bytearray(path.read_bytes())
        for _ in range(data.draw(st.integers(1, 3))):
            at = data.draw(st.integers(0, len(body) - 1))
            cut = data.draw(st.integers(0, 9))
            body[at : at + cut] = data.draw(st.binary(max_size=5) | st.sampled_from(
                [b"=", b"\n", b"[", b"]", b'"', b"nan", b"-", b",", b"1e9", b".", b"'"]
            ))  # fmt: skip
        path.write_bytes(body)
        try:
            assert isinstance(read_recording(place), Recording)
        except RecordingError as error:
            assert "\n" not in str(error)  # noqa: PT017 (a refusal is one of two good ends)


@pytest.mark.parametrize("there", [True, False])
def test_a_new_or_an_empty_folder_is_filled(tmp_path, there):
    place = tmp_path / "deep" / "out"
    if there:
        place.mkdir(parents=True)
    write_recording(recording(), place)
    assert same(read_recording(place), recording())
    assert [p.name for p in place.parent.iterdir()] == ["out"]


def test_a_folder_with_contents_is_left_alone(place):
    before = (place / "recording.toml").read_bytes()
    with pytest.raises(RecordingError, match="not empty"):
        write_recording(recording(), place)
    with pytest.raises(RecordingError, match="no folder"):
        write_recording(recording(), place / "recording.toml")
    assert (place / "recording.toml").read_bytes() == before


@pytest.mark.parametrize("there", [True, False])
@pytest.mark.parametrize("call", ["write_bytes", "rename"])
def test_a_failure_while_writing_leaves_nothing(tmp_path, monkeypatch, there, call):
    place = tmp_path / "out"
    if there:
        place.mkdir()
    real, calls = getattr(Path, call), []

    def fail(self, *arguments):
        calls.append(self)
        if self.name in ("recording.toml", "built"):
            raise OSError(28, "No space left on device")
        return real(self, *arguments)

    monkeypatch.setattr(Path, call, fail)
    with pytest.raises(RecordingError, match="No space left on device"):
        write_recording(recording(), place)
    assert calls
    assert [p.name for p in tmp_path.rglob("*")] == (["out"] if there else [])


def test_a_folder_in_a_file_cannot_be_made(tmp_path):
    (tmp_path / "file").write_text("x")
    with pytest.raises(RecordingError, match="cannot be written"):
        write_recording(recording(), tmp_path / "file" / "out")


BAD = {
    "no frame": (Readings(np.empty(0), np.empty((0, 8))), "no frame"),
    "too few columns": (Readings(np.zeros(1), np.zeros((1, 7))), "shapes"),
    "not whole": (Readings(np.zeros(1), np.full((1, 8), 0.5)), "no whole number"),
    "infinite": (Readings(np.zeros(1), np.full((1, 8), np.inf)), "out of range"),
    "out of range": (Readings(np.zeros(1), np.full((1, 8), 2.0**31)), "out of range"),
    "times not growing": (Readings(np.zeros(2), np.zeros((2, 8))), "that grow"),
    "no time": (Readings(np.array([np.nan]), np.zeros((1, 8))), "seconds"),
}


@pytest.mark.parametrize("name", BAD)
def test_readings_that_a_recording_cannot_hold_are_not_written(tmp_path, name):
    bad, words = BAD[name]
    made = Recording(RIBBON, (), (Pass("P1", "pass", readings()), Pass("P2", "pass", bad)))
    with pytest.raises(RecordingError, match=rf'pass "P2".*{words}'):
        write_recording(made, tmp_path / "out")
    assert not list(tmp_path.iterdir())


def test_what_cannot_be_read_back_is_not_written(tmp_path):
    passes = (Pass("P1", "pass", readings()), Pass("P1", "pass", readings()))
    with pytest.raises(RecordingError, match="that of pass number 1 too"):
        write_recording(Recording(RIBBON, (), passes), tmp_path / "out")
    tilted = Recording(RIBBON, (), recording().passes, workpiece=Workpiece(False))
    with pytest.raises(RecordingError, match="vertical"):
        write_recording(tilted, tmp_path / "out")
    assert not list(tmp_path.iterdir())


def test_kinds_of_places(tmp_path):
    (tmp_path / "file").write_text("x")
    os.mkfifo(tmp_path / "pipe")
    kinds = [files.kind_of(tmp_path / name) for name in ("", "file", "pipe", "none")]
    assert kinds == ["folder", "file", "other", "nothing"]
