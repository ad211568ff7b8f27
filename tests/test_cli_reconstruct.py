"""`georibbon reconstruct`."""

import csv
import json
import math
import shutil

import pytest

from georibbon.cli import main
from georibbon.errors import ExportError
from refusing import refused
from synthetic import reconstruction

OUTPUTS = ("part.stl", "part.obj", "part.ply", "part.csv", "part.json", "part.html", "part.png")
FLAGS = {"stl": "surface", "obj": "surface", "ply": "surface", "csv": "curves", "png": "picture"}


def asked(folder, *names: str) -> list[str]:
    """The options that ask for these files in a folder."""
    return [f"--{FLAGS.get(name.rpartition('.')[2], 'report')}={folder / name}" for name in names]


@pytest.fixture(scope="module")
def done(small_capture, tmp_path_factory):
    """A folder with every output of the small capture."""
    folder = tmp_path_factory.mktemp("done")
    assert main(["reconstruct", str(small_capture), *asked(folder, *OUTPUTS)]) == 0
    return folder


@pytest.fixture
def settings_asked(monkeypatch):
    """The settings and the calibration with which `reconstruct` was called, which then fails."""
    seen = {}

    def reconstruct(_recording, settings, calibration):
        seen.update(settings=settings, calibration=calibration)
        raise ExportError("stopped here")

    monkeypatch.setattr("georibbon.reconstruction.reconstruct", reconstruct)
    return seen


def points(curves) -> list[float]:
    """All coordinates of a curves file, one after the other."""
    with curves.open(newline="", encoding="utf-8") as file:
        return [float(row[axis]) for row in csv.DictReader(file) for axis in ("x", "y", "z")]


def vertices(obj) -> list[float]:
    """All coordinates of an OBJ file's vertices, one after the other."""
    lines = obj.read_text(encoding="ascii").splitlines()
    return [float(word) for line in lines if line.startswith("v ") for word in line.split()[1:]]


def test_every_output_is_there_and_nothing_else(done):
    assert {path.name for path in done.iterdir()} == set(OUTPUTS)
    assert all(path.stat().st_size > 0 for path in done.iterdir())


def test_the_curves(done):
    with (done / "part.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert {"pass", "s", "x", "y", "z", "nx", "ny", "nz", "sigma"} <= set(rows[0])
    assert {row["pass"] for row in rows} == {"P1", "P2", "P3"}
    lengths = [float(row["s"]) for row in rows if row["pass"] == "P2"]
    assert lengths == sorted(lengths)
    assert lengths[-1] == pytest.approx(0.6)
    for row in rows[::20]:
        assert math.hypot(*(float(row[axis]) for axis in ("nx", "ny", "nz"))) == pytest.approx(1)
        assert 0 < float(row["sigma"]) < 0.02


def test_the_report(done, small_capture):
    report = json.loads((done / "part.json").read_text(encoding="utf-8"))
    assert report["source"] == str(small_capture)
    assert (report["method"], report["unit"]) == ("ribbon", "mm")
    assert [run["name"] for run in report["passes"]] == ["P1", "P2", "P3"]
    assert set(OUTPUTS) == set(report["files"])


def test_units(done, small_capture, tmp_path):
    words = asked(tmp_path, "part.obj", "part.json")
    assert main(["reconstruct", str(small_capture), *words, "--unit=m"]) == 0
    metres = [1000 * value for value in vertices(tmp_path / "part.obj")]
    assert vertices(done / "part.obj") == pytest.approx(metres, abs=1e-3)
    assert json.loads((tmp_path / "part.json").read_text(encoding="utf-8"))["unit"] == "m"


def test_a_session_gives_what_its_recording_gives(done, small_capture, tmp_path):
    session, back = tmp_path / "s.georibbon", tmp_path / "back"
    assert main(["import", str(small_capture), "-o", str(session)]) == 0
    assert main(["export", str(session), "--recording", str(back)]) == 0
    for source in (session, back):
        assert main(["reconstruct", str(source), *asked(tmp_path, "part.csv")]) == 0
        assert (tmp_path / "part.csv").read_bytes() == (done / "part.csv").read_bytes()


def test_the_summary(small_capture, tmp_path, capsys):
    capsys.readouterr()
    assert main(["reconstruct", str(small_capture), *asked(tmp_path, "part.stl")]) == 0
    told = capsys.readouterr().out
    for line in ("P1 ", "P2 ", "P3 ", "survey   6 observations", "surface "):
        assert f"\n{line}" in f"\n{told}"
    assert told.endswith(f"written: {tmp_path / 'part.stl'} (mm)\n")


def test_without_outputs_it_tells_alone(small_capture, capsys):
    capsys.readouterr()
    assert main(["reconstruct", str(small_capture)]) == 0
    assert "written" not in capsys.readouterr().out


def test_a_calibration_serves_a_recording_without_poses(done, small_capture, tmp_path, capsys):
    bare, file = tmp_path / "bare", tmp_path / "ribbon.json"
    assert main(["calibrate", str(small_capture), "-o", str(file)]) == 0
    shutil.copytree(small_capture, bare)
    shutil.rmtree(bare / "calibration")
    toml = (bare / "recording.toml").read_text(encoding="utf-8")
    parts = toml.split("[[pose]]")
    rest = parts[-1][parts[-1].index("[[") :]
    (bare / "recording.toml").write_text(parts[0] + rest, encoding="utf-8")
    assert "calibration" in refused(["reconstruct", bare], capsys)
    words = [f"--calibration={file}", *asked(tmp_path, "part.csv")]
    assert main(["reconstruct", str(bare), *words]) == 0
    assert points(tmp_path / "part.csv") == pytest.approx(points(done / "part.csv"), abs=2e-4)


def test_settings_by_default(small_capture, settings_asked):
    from georibbon.geometry.surface import SurfaceSettings
    from georibbon.reconstruction import ReconstructionSettings

    main(["reconstruct", str(small_capture)])
    assert settings_asked["calibration"] is None
    settings = settings_asked["settings"]
    assert (settings.method, settings.neighbours) == ("ribbon", True)
    assert dict(settings.smoothing) == {}
    assert settings.surface == SurfaceSettings()
    assert settings.method == ReconstructionSettings().method


@pytest.mark.parametrize(
    ("words", "name", "value"),
    [
        (["--method=paper"], "method", "paper"),
        (["--method=paper", "--tangents=averages"], "tangents", "averages"),
        (["--method=paper", "--tangents=components"], "tangents", "components"),
        (["--no-neighbours"], "neighbours", False),
        (["--smoothing=auto"], "smoothing", {}),
        (["--smoothing=60"], "smoothing", {"*": 0.06}),
        (["--smoothing=60", "--smoothing=P3=90"], "smoothing", {"*": 0.06, "P3": 0.09}),
        (["--smoothing", "P1=40.5"], "smoothing", {"P1": 0.0405}),
        (["--tolerance=0.2"], "surface.tolerance", 0.0002),
        (["--thickness=2"], "surface.thickness", 0.002),
        (["--neighbours"], "neighbours", True),
        (["--sensors-off=A09,M03"], "sensors_off", {"*": ("A09", "M03")}),
        (
            ["--sensors-off=P1=A09", "--sensors-off=M03"],
            "sensors_off",
            {"P1": ("A09",), "*": ("M03",)},
        ),
        (["--trim=20,0"], "trim", {"*": (0.02, 0.0)}),
        (["--trim=P2=5,7.5"], "trim", {"P2": (0.005, 0.0075)}),
        (["--weight=2", "--weight=P3=0.5"], "weight", {"*": 2.0, "P3": 0.5}),
        (["--direction=conormal"], "surface.direction", "conormal"),
        (["--direction=angles", "--angles=1,2,3,4"], "surface.angles", (1.0, 2.0, 3.0, 4.0)),
        (["--lengths=criterion2"], "surface.lengths", "criterion2"),
        (["--lengths=1.1,0.9"], "surface.lengths", (1.1, 0.9)),
        (["--correspondence=fraction"], "surface.correspondence", "fraction"),
        (["--interior=g2"], "surface.interior", "g2"),
        (["--cells"], "surface.cells", True),
        (["--no-cells"], "surface.cells", False),
    ],
)
def test_each_option_reaches_its_setting(small_capture, settings_asked, words, name, value):
    assert main(["reconstruct", str(small_capture), *words]) == 2
    found = settings_asked["settings"]
    for part in name.split("."):
        found = getattr(found, part)
    exact = not isinstance(value, float) and name not in ("smoothing", "trim")
    assert found == value if exact else same(found, value)


def same(found, value):
    """Whether numbers, or numbers by name, are about the same."""
    if isinstance(value, dict):
        return {k: pytest.approx(one) for k, one in value.items()} == found
    return found == pytest.approx(value)


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (["--surface=part.3mf"], "part.3mf"),
        (["--surface=part"], "part"),
        (["--curves=part.txt"], "part.txt"),
        (["--report=part.doc"], "part.doc"),
        (["--picture=part.jpg"], "part.jpg"),
        (["--surface=missing/part.stl"], "missing"),
        (["--surface=part.stl", "--surface=./part.stl"], "two outputs"),
        (["--method=guess"], "guess"),
        (["--unit=inch"], "inch"),
        (["--smoothing=rough"], "rough"),
        (["--smoothing=-5"], "-5"),
        (["--smoothing=20000"], "smoothing"),
        (["--smoothing=60", "--method=paper"], "--method ribbon"),
        (["--smoothing=P1="], "''"),
        (["--smoothing==60"], "=60"),
        (["--smoothing=60", "--method=paper"], "smoothing"),
        (["--weight=2", "--method=paper"], "--weight"),
        (["--tangents=averages"], "--tangents is for --method paper"),
        (["--tangents=averages", "--method=ribbon"], "--tangents is for --method paper"),
        (["--tangents=guess"], "guess"),
        (["--weight=0"], "above 0"),
        (["--weight=1000"], "the weight of all passes is 1000"),
        (["--weight=P1=heavy"], "heavy"),
        (["--trim=20"], "two lengths"),
        (["--trim=P1=-1,0"], "two lengths"),
        (["--sensors-off=P1=A09,"], "names of sensors"),
        (["--angles=1,2"], "four angles"),
        (["--direction=angles", "--angles=1,2,3,400"], "angles"),
        (["--direction=sideways"], "sideways"),
        (["--lengths=long"], "long"),
        (["--lengths=1,2,3"], "two factors"),
        (["--lengths=1,99"], "0.05 and 10"),
        (["--correspondence=none"], "none"),
        (["--interior=g3"], "g3"),
        (["--tolerance=0"], "0"),
        (["--tolerance=-1"], "-1"),
        (["--tolerance=nan"], "nan"),
        (["--thickness=thick"], "thick"),
        (["--calibration=missing.json"], "missing.json"),
    ],
)
@pytest.mark.usefixtures("no_work")
def test_refused_before_the_work(small_capture, tmp_path, monkeypatch, words, named, capsys):
    monkeypatch.chdir(tmp_path)
    told = refused(["reconstruct", small_capture, "--report=good.json", *words], capsys)
    assert named in told
    assert list(tmp_path.iterdir()) == []


def test_a_pass_that_is_not_there(small_capture, tmp_path, capsys):
    words = ["--smoothing=P9=60", *asked(tmp_path, "part.csv")]
    told = refused(["reconstruct", small_capture, *words], capsys)
    assert "P9" in told
    assert "P1, P2, P3" in told
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("words", "named"),
    [
        ("--sensors-off=A99", "no sensor A99"),
        ("--sensors-off=P9=A01", "no pass P9 to switch sensors off in"),
        ("--trim=P9=1,1", "no pass P9 to trim"),
        ("--trim=300,300", "leave 0 mm"),
        ("--weight=P9=2", "no pass P9 to weigh"),
    ],
)
def test_what_the_recording_has_not(small_capture, tmp_path, words, named, capsys):
    assert named in refused(
        ["reconstruct", small_capture, words, *asked(tmp_path, "a.csv")], capsys
    )
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("option", ["--direction=chord", "--interior=g2", "--tolerance=1"])
def test_options_of_the_surface_ask_for_its_file(small_capture, tmp_path, option, capsys):
    words = ["reconstruct", small_capture, option, *asked(tmp_path, "part.csv")]
    assert "is of the surface" in refused(words, capsys)


def test_for_curves_alone_no_surface_is_made(small_capture, tmp_path, settings_asked):
    main(["reconstruct", str(small_capture), *asked(tmp_path, "part.csv")])
    assert settings_asked["settings"].surface is None
    main(["reconstruct", str(small_capture), *asked(tmp_path, "part.csv", "part.json")])
    assert settings_asked["settings"].surface is not None


@pytest.mark.usefixtures("no_work")
def test_an_input_is_not_overwritten(small_capture, tmp_path, capsys):
    file = tmp_path / "ribbon.json"
    file.write_text("{}")
    words = [f"--calibration={file}", f"--report={file}"]
    assert "input" in refused(["reconstruct", small_capture, *words], capsys)
    assert file.read_text() == "{}"


def test_a_broken_recording_leaves_nothing(small_capture, tmp_path, capsys):
    broken, out = tmp_path / "broken", tmp_path / "out"
    out.mkdir()
    shutil.copytree(small_capture, broken)
    (broken / "passes" / "p3.csv").unlink()
    told = refused(["reconstruct", broken, *asked(out, *OUTPUTS)], capsys)
    assert "p3.csv" in told
    assert list(out.iterdir()) == []


@pytest.mark.parametrize(
    ("error", "code"),
    [(ExportError("no room"), 2), (OSError(28, "No space left", "x"), 2), (RuntimeError(), 1)],
)
def test_a_failure_at_the_last_file_leaves_nothing(
    small_capture, tmp_path, monkeypatch, error, code
):
    def fail(*_args, **_settings):
        raise error

    monkeypatch.setattr("georibbon.reconstruction.reconstruct", lambda *_: reconstruction())
    monkeypatch.setattr("georibbon.export.picture.write_picture", fail)
    (tmp_path / "part.csv").write_text("yesterday's")
    outputs = asked(tmp_path, "part.stl", "part.csv", "part.json", "part.png")
    assert main(["reconstruct", str(small_capture), *outputs]) == code
    assert [path.name for path in tmp_path.iterdir()] == ["part.csv"]
    assert (tmp_path / "part.csv").read_text() == "yesterday's"
