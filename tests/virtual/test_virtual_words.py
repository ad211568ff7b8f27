"""The words that move a virtual ribbon, and what is answered."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from worlds import SMALL, world_of

from georibbon.errors import SettingsError
from georibbon.simulation import PoseSettings
from georibbon.virtual import COMMANDS

WORLD = world_of(pace=0.0)

ANSWERS = {
    "lay P1": "P1, still",
    "lift": "in the air, in moving hands",
    "hold": "in the air, still",
    "pose 2": "in pose 2, still",
    "pose 90,10,0,table": "at roll 90, heading 10, pitch 0 on the table, still",
    "pose -90,10,40": "at roll -90, heading 10, pitch 40, still",
    "poses": "16 poses, one after another",
    "play": "16 poses, then P1, P2, P3, T1",
    "drop 0.1": "0.1 of the frames are lost on the cable",
    "damage 0.25": "0.25 of the frames are damaged on the cable",
    "stall": "stalled for 3 s",
    "stall 0.5": "stalled for 0.5 s",
    "unplug": "unplugged, until replug",
    "unplug 2": "unplugged for 2 s",
    "baud wrong": "the host listens at the wrong baud rate",
    "baud right": "the host listens at the right baud rate",
    "identity GR-7": "answers as GR-7",
    "magnet 0.5": "a magnet of 0.5 of the field at 0.24 m, reaching 0.12 m",
    "magnet 0.5 0.1": "a magnet of 0.5 of the field at 0.1 m, reaching 0.12 m",
    "magnet 0.5 0.1 0.2": "a magnet of 0.5 of the field at 0.1 m, reaching 0.2 m",
    "magnet pass": "a magnet of 0.25 of the field passes within 4 s",
    "magnet pass 0.1 9": "a magnet of 0.1 of the field passes within 9 s",
    "magnet off": "no magnet",
    "dead A03": "A03 says nothing but 0",
    "alive M02": "M02 is alive",
    "noise 2.5": "2.5 times the sensors' own noise",
    "message low  battery": "said: low  battery",
    "status": "in the air, in moving hands; silent; 0 packets, 0 of frames, 0 lost or damaged",
    "help lift": "lift: take it up into the hands, which move",
    "  lift  ": "in the air, in moving hands",
    "quit": "bye",
}


@pytest.mark.parametrize("words", ANSWERS)
def test_a_command_is_answered_in_a_line(words):
    assert world_of(pace=0.0).do(words) == ANSWERS[words]


def test_every_command_is_answered_above():
    named = {words.split()[0] for words in ANSWERS}
    assert named | {"next", "replug", "help"} == set(COMMANDS)
    told = WORLD.do("help")
    assert all(command.usage in told for command in COMMANDS.values())


def test_next_goes_through_all_passes_and_ties_once():
    world = world_of(pace=0.0)
    assert [world.do("next") for _ in range(4)] == [
        "P1, still",
        "P2, still",
        "P3, still",
        "T1, still",
    ]
    with pytest.raises(SettingsError, match="T1 was the last"):
        world.do("next")
    world.do("lay P2")
    world.do("lift")
    assert world.do("next") == "P3, still"


REFUSED = {
    "": "there is no command",
    "jump": "there is no command",
    "lai P1": 'did you mean "lay"',
    "lay": "lay NAME",
    "lay P1 P2": "lay NAME",
    "lay P9": "there is no pass",
    "lay p1": "there are P1, P2, P3, T1",
    "next one": "write it as: next",
    "pose": "pose N",
    "pose 0": "there is no pose 0",
    "pose 17": "there are 1 to 16",
    "pose x": "pose N",
    "pose 1,2": "pose N",
    "pose 1,2,x": "pose N",
    "pose 1,2,nan": "pitch",
    "pose 1,2,95": "pitch",
    "pose 1,2,30,table": "pitch on the table",
    "pose 400,0,0": "roll",
    "drop": "drop SHARE",
    "drop x": "drop SHARE",
    "drop 2": "share",
    "drop -0.1": "share",
    "damage nan": "share",
    "stall -1": "seconds",
    "stall 1 2": "stall [SECONDS]",
    "unplug inf": "seconds",
    "replug": "in already",
    "baud 9600": "baud wrong",
    "identity": "identity ID",
    "identity " + "x" * 61: "60 printable",
    "magnet": "magnet SHARE",
    "magnet 1 2 3 4": "magnet SHARE",
    "magnet 11": "share of the field",
    "magnet 1 5": "place",
    "magnet 1 0.1 0": "reach",
    "magnet off now": "magnet SHARE",
    "magnet pass 0.1 0": "seconds",
    "dead A99": "there is no sensor",
    "dead A1": 'did you mean "A01"',
    "dead ?": "A01, M01 to M08",
    "alive": "alive SENSOR",
    "noise": "noise FACTOR",
    "noise -1": "factor",
    "message": "message TEXT",
    "message a\x1b[0m": "printable",
    "status now": "write it as: status",
    "help jump": "there is no command",
    "quit now": "write it as: quit",
    "message " + "x" * 1000: "give at most 1000",
}


@pytest.mark.parametrize("words", REFUSED)
def test_nonsense_is_refused_with_a_reason(words):
    with pytest.raises(SettingsError) as refusal:
        WORLD.do(words)
    assert REFUSED[words] in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_a_refused_command_changes_nothing():
    world = world_of(pace=0.0)
    world.do("lay P2")
    for words in REFUSED:
        with pytest.raises(SettingsError):
            world.do(words)
    assert world.do("status").startswith("P2, still; silent; 0 packets")


def test_a_cable_that_is_out_cannot_be_pulled():
    world = world_of()
    world.do("unplug")
    with pytest.raises(SettingsError, match="the cable is out"):
        world.do("unplug")
    assert "the cable is out" in world.do("status")
    assert world.do("replug") == "plugged in; silent until the host says start"


def test_without_planned_poses_there_is_nothing_to_pose():
    world = world_of(replace(SMALL, poses=PoseSettings(plan=0)), pace=0.0)
    with pytest.raises(SettingsError, match="no pose is planned"):
        world.do("poses")
    with pytest.raises(SettingsError, match="no pose is planned"):
        world.do("pose 1")
    assert world.do("play") == "0 poses, then P1, P2, P3, T1"


@given(
    st.one_of(
        st.text(max_size=80),
        st.builds(
            "{} {}".format,
            st.sampled_from([*COMMANDS]),
            st.text("0123456789.,-eginfas P", max_size=9),
        ),
    )
)
def test_any_text_is_answered_or_refused_in_a_line(text):
    try:
        told = WORLD.do(text)
    except SettingsError as error:
        told = str(error)
    assert told
    assert len(told.splitlines()) == 1
