"""Settings as a session keeps them: what they say, and that nothing odd comes through."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from georibbon.errors import SessionError, SettingsError
from georibbon.fitting.settings import ReconstructionSettings
from georibbon.geometry.settings import SurfaceSettings
from georibbon.session.actions import setting_in_words, settings_in_words
from georibbon.session.session import Session
from georibbon.session.settings import (
    BY_PASS,
    KEYS,
    OF_SURFACE,
    settings_of,
    sound_settings,
    with_setting,
)

PLAIN = ReconstructionSettings()
SOUND = [
    ("P1", "smoothing", 0.06, {"smoothing": {"P1": 0.06}}),
    ("*", "smoothing", 1, {"smoothing": {"*": 1.0}}),
    ("P1", "weight", 2, {"weight": {"P1": 2.0}}),
    ("P1", "trim", [0, 0.05], {"trim": {"P1": (0.0, 0.05)}}),
    ("*", "sensors_off", ["A01", "A01", "M02"], {"sensors_off": {"*": ("A01", "M02")}}),
    ("*", "method", "paper", {"method": "paper"}),
    ("*", "neighbours", False, {"neighbours": False}),
    ("*", "tangents", "averages", {"tangents": "averages"}),
    ("*", "surface.direction", "chord", {"surface": SurfaceSettings(direction="chord")}),
    ("*", "surface.lengths", [1, 1.5], {"surface": SurfaceSettings(lengths=(1.0, 1.5))}),
    ("*", "surface.thickness", 0.002, {"surface": SurfaceSettings(thickness=0.002)}),
    ("*", "surface.cells", True, {"surface": SurfaceSettings(cells=True)}),
    (
        "*",
        "surface.angles",
        [1, 2, 3, 4],
        {"surface": SurfaceSettings(angles=(1.0, 2.0, 3.0, 4.0))},
    ),
]
JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=5) | st.dictionaries(st.text(max_size=4), inner),
    max_leaves=8,
)


@pytest.mark.parametrize(("whose", "key", "value", "said"), SOUND)
def test_a_value_says_its_setting_and_none_takes_it_back(whose, key, value, said):
    settings = with_setting(PLAIN, whose, key, value)
    assert settings == replace(PLAIN, **said)
    assert with_setting(settings, whose, key, None) == PLAIN


def test_every_key_is_known_and_named():
    assert {key for _, key, _, _ in SOUND} >= set(BY_PASS)
    assert set(OF_SURFACE) == {f"surface.{name}" for name in SurfaceSettings.__dataclass_fields__}
    for key in KEYS:
        words = setting_in_words("*", key)
        assert words.startswith("the ")
        assert "_" not in words
        assert "." not in words
        assert setting_in_words("P3", key).endswith("of pass P3")


@pytest.mark.parametrize(
    ("whose", "key", "value", "words"),
    [
        ("P1", "smoothing", "fine", 'the smoothing of "P1" is "fine"; a number of metres'),
        ("P1", "smoothing", True, "a number of metres"),
        ("P1", "smoothing", 10**400, "between 1 and 10000 mm"),
        ("P1", "weight", {}, 'the weight of "P1" is a table; a number is expected'),
        ("P1", "weight", 0, "the weight of pass P1 is 0"),
        ("P1", "trim", 0.1, "two numbers of metres"),
        ("P1", "trim", [0.1, True], "two numbers of metres"),
        ("P1", "trim", [-0.1, 0], "-100 mm"),
        ("P1", "sensors_off", "A01", "a list of names"),
        ("P1", "sensors_off", ["A01", 3], "a list of names"),
        ("*", "method", "guess", "guess"),
        ("*", "method", ["paper"], "a word is expected"),
        ("*", "neighbours", 1, "true or false"),
        ("*", "surface.direction", "sideways", "sideways"),
        ("*", "surface.tolerance", True, "true is found"),
        ("*", "surface.cells", "yes", "must be true or false"),
        ("*", "surface.cells", 1, "must be true or false"),
        ("*", "surface.cells", {}, "a table is found"),
        ("*", "surface.tolerance", "fine", "fine"),
        ("*", "surface.tolerance", 10**400, "a number or a list is expected"),
        ("*", "surface.angles", [1, 2, 3, 10**400], "a number or a list is expected"),
        ("*", "surface.lengths", [1] * 101, "a number or a list is expected"),
        ("*", "surface.lengths", {}, "a table is found"),
        ("*", "surface.direction", "x" * 101, "a number or a list is expected"),
        ("*", "method", "x" * 101, "a word is expected"),
        ("*", "tangents", "guess", "unrolled, averages, components"),
        ("*", "tangents", 3, "a word is expected"),
        ("*", "surface.lengths", [1], "2 numbers"),
        ("*", "surface.angles", [1, 2, 3, 400], "angles"),
        ("P1", "surface.direction", "chord", "of all passes together, not of pass P1"),
        ("P1", "method", "paper", "of all passes together"),
        ("P1", "tangents", "averages", "of all passes together"),
        ("*", "smoothness", 1, 'no setting "smoothness"; did you mean "smoothing"?'),
    ],
)
def test_what_means_nothing_is_refused(whose, key, value, words):
    with pytest.raises(SettingsError) as caught:
        with_setting(PLAIN, whose, key, value)
    assert words in str(caught.value)


def test_a_bad_value_takes_no_sound_one_with_it():
    values = {
        ("P1", "weight"): "heavy",
        ("P2", "weight"): 2,
        ("P9", "weight"): "of a pass that is gone",
        ("*", "colour"): "of another program",
        ("*", "surface.direction"): "sideways",
    }
    settings, wrong = sound_settings(values, ["P1", "P2"])
    assert settings == replace(PLAIN, weight={"P2": 2.0})
    assert len(wrong) == 2
    with pytest.raises(SessionError, match=r'^dome: the weight of "P1" is "heavy"'):
        settings_of(values, ["P1", "P2"], "dome")


@given(
    st.dictionaries(
        st.tuples(st.sampled_from(["*", "P1", "P2"]), st.sampled_from(KEYS) | st.text(max_size=5)),
        JSON,
        max_size=6,
    )
)
def test_anything_is_read_or_told(values):
    settings, wrong = sound_settings(values, ["P1"])
    assert isinstance(settings, ReconstructionSettings)
    assert all(isinstance(one, str) for one in wrong)


@pytest.fixture
def session(tmp_path):
    with Session.create(tmp_path / "plain.georibbon") as made:
        yield made


def change(whose, key, value):
    return {"pass": whose, "key": key, "value": value}


def test_several_settings_are_one_step_of_undo(session):
    session.do("setting", **change("P1", "weight", 2))
    changes = [
        change("P1", "weight", None),
        change("P2", "smoothing", 0.1),
        change("*", "surface.direction", "chord"),
    ]
    session.do("settings", changes=changes)
    after = {("P2", "smoothing"): 0.1, ("*", "surface.direction"): "chord"}
    assert session.state.settings == after
    assert session.undo() == "the settings of all passes"
    assert session.state.settings == {("P1", "weight"): 2}
    assert session.redo() == "the settings of all passes"
    assert session.state.settings == after


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (None, "a list of settings is expected"),
        ([], "a list of settings is expected"),
        ({"pass": "P1"}, "a list of settings is expected"),
        ([3], "pass"),
        ([change("P1", "weight", 2), {"pass": "P1", "key": "weight"}], "value"),
        ([{**change("P1", "weight", 2), "more": 1}], "more"),
        ([change("P1", 7, 2)], "key"),
        ([change("P1", f"key {k}", 2) for k in range(20_000)], "a session keeps at most"),
    ],
)
def test_odd_changes_are_refused_and_nothing_is_changed(session, changes, words):
    with pytest.raises(SessionError) as caught:
        session.do("settings", changes=changes)
    assert words in str(caught.value)
    assert session.state.settings == {}
    assert session.state.undoable is None


@pytest.mark.parametrize(
    ("places", "words"),
    [
        ([("P1", "trim")], "the trimmed ends of pass P1"),
        ([("P1", "trim"), ("P2", "trim")], "the trimmed ends of all passes"),
        ([("P1", "trim"), ("P1", "weight")], "the settings of pass P1"),
        ([("*", "surface.lengths"), ("*", "surface.interior")], "the settings of the surface"),
        ([("*", "surface.lengths"), ("P1", "weight")], "the settings of all passes"),
        ([("*", "method"), ("*", "neighbours")], "the settings of all passes"),
    ],
)
def test_several_settings_in_words(places, words):
    assert settings_in_words(places) == words
