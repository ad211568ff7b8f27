"""`georibbon simulate`."""

import dataclasses
import json

import pytest

from georibbon.cli import build_parser, main
from georibbon.cli.simulation import GROUPS, REPEATED, default_of, settings_from
from georibbon.session.folder import read_recording
from georibbon.simulation import SURFACES, SimulationSettings, simulate

QUICK = ("--sensors=8", "--passes=2", "--frames=5", "--length=0.4")


def settings(*words: str) -> SimulationSettings:
    return settings_from(build_parser(("simulate",)).parse_args(["simulate", *words]))


def leaves(value: object, name: str = "") -> set[str]:
    """The dotted names of all settings."""
    if not dataclasses.is_dataclass(value):
        return {name}
    fields = dataclasses.fields(value)
    prefix = f"{name}." if name else ""
    return set().union(*(leaves(getattr(value, f.name), prefix + f.name) for f in fields))


def test_every_setting_can_be_set():
    options = [option.setting for group in GROUPS.values() for option in group]
    assert len(options) == len(set(options))
    elsewhere = {"surface", "parameters", "tell_heading"}
    assert set(options) | elsewhere == leaves(SimulationSettings())


def test_no_words_no_change():
    assert settings("bonnet", "-o", "x") == SimulationSettings(surface="bonnet")


WORDS = {
    "ribbon.sensors": ("24", 24),
    "ribbon.length": ("0.5", 0.5),
    "ribbon.rate": ("50", 50.0),
    "ribbon.magnetometer_axes": ("3", 3),
    "poses.plan": ("20", 20),
    "layout.passes": ("7", 7),
    "layout.ties": ("2", 2),
    "frames": ("30", 30),
    "seed": ("12", 12),
    "ribbon.id": ("GR-0042", "GR-0042"),
    "title": ("a title", "a title"),
    "poses.poses": ("90,0,-40.5,table", ((90.0, 0.0, -40.5, True),)),
    "layout.start": ("0.1,-0.2", (0.1, -0.2)),
    "layout.fan_kind": ("spread", "spread"),
    "survey.kinds": ("starts,distances", ("starts", "distances")),
    "faults.dead": ("A03", ("A03",)),
    "faults.magnet_on": ("P3", "P3"),
}
OPTIONS = [option for group in GROUPS.values() for option in group]
ALONE = [option for option in OPTIONS if option.setting != "layout.tie_places"]


@pytest.mark.parametrize("option", ALONE, ids=lambda option: option.setting)
def test_each_option_sets_its_setting_alone(option):
    word, value = WORDS.get(option.setting, ("0.07", 0.07))
    changed = settings("dome", "-o", "x", f"{option.flag}={word}")
    assert default_of(changed, option.setting) == value
    others = leaves(SimulationSettings()) - {option.setting, "surface"}
    unchanged = {name: default_of(SimulationSettings(), name) for name in others}
    assert {name: default_of(changed, name) for name in others} == unchanged


def test_each_tie_has_its_place():
    layout = settings("dome", "-o", "x", "--ties=2", "--tie-place=0.3", "--tie-place=0.6").layout
    assert (layout.ties, layout.tie_places) == (2, (0.3, 0.6))


def test_repeated_options_add_up():
    changed = settings(
        "dome", "-o", "x", "--dead=A01", "--dead=M02", "--pose=0,0,0", "--pose=-9,0,0"
    )
    assert changed.faults.dead == ("A01", "M02")
    assert changed.poses.poses == ((0.0, 0.0, 0.0, False), (-9.0, 0.0, 0.0, False))
    assert {option.setting for option in OPTIONS} > REPEATED


def test_what_is_written_is_what_is_simulated(tmp_path, capsys):
    folder = tmp_path / "ball"
    words = ["sphere", "-o", str(folder), *QUICK, "--parameter=radius=0.5", "--seed=5"]
    assert main(["simulate", *words, "--tell-heading", "--survey=none"]) == 0
    assert str(folder) in capsys.readouterr().out
    found, meant = (
        read_recording(folder),
        simulate(settings(*words, "--tell-heading", "--survey=none")),
    )
    assert found.ribbon == meant.recording.ribbon
    assert found.workpiece == meant.recording.workpiece
    assert found.workpiece.heading is not None
    assert found.marks == ()
    assert (found.passes[0].readings.counts == meant.recording.passes[0].readings.counts).all()
    truth = json.loads((tmp_path / "ball.truth.json").read_text(encoding="utf-8"))
    assert set(truth["passes"]) == {"P1", "P2"}
    assert sorted(path.name for path in tmp_path.iterdir()) == ["ball", "ball.truth.json"]


def test_the_help_lists_every_surface(capsys):
    main(["simulate", "--help"])
    told = capsys.readouterr().out
    for name, kind in SURFACES.items():
        assert f"  {name} " in told
        assert all(parameter in told for parameter in kind.parameters)


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (["cube"], "cube"),
        (["dome", "--parameter=colour=3"], "colour"),
        (["dome", "--parameter=radius"], "NAME=NUMBER"),
        (["dome", "--parameter=radius=wide"], "wide"),
        (["dome", "--sensors=1.5"], "1.5"),
        (["dome", "--sensors=1"], "sensors"),
        (["dome", "--length=-1"], "length"),
        (["dome", "--length=nan"], "nan"),
        (["dome", "--pose=1,2"], "1,2"),
        (["dome", "--pose=1,2,up"], "up"),
        (["dome", "--start=1"], "1"),
        (["dome", "--survey=middles"], "middles"),
        (["dome", "--plan=5"], "plan"),
        (["dome", "--dead=Z99"], "Z99"),
        (["dome", "--magnet=0.2", "--magnet-on=P9"], "P9"),
        (["dome", "--passes=1"], "passes"),
        (["dome", "--lost=2"], "lost"),
    ],
)
def test_what_cannot_be_simulated(words, named, tmp_path, capsys):
    assert main(["simulate", *words, "-o", str(tmp_path / "x")]) == 2
    told = capsys.readouterr().err
    assert named in told
    assert told.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_no_folder_is_overwritten(tmp_path, capsys):
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "thesis.txt").write_text("years of work")
    (tmp_path / "file").write_text("")
    for place in ("full", "file", "missing/x", ".."):
        assert main(["simulate", "dome", "-o", str(tmp_path / place), *QUICK]) == 2
        assert str(tmp_path / place) in capsys.readouterr().err
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["file", "full", "thesis.txt"]


def test_an_empty_folder_is_filled(tmp_path):
    (tmp_path / "empty").mkdir()
    assert main(["simulate", "dome", "-o", str(tmp_path / "empty"), *QUICK]) == 0
    assert (tmp_path / "empty" / "recording.toml").is_file()
