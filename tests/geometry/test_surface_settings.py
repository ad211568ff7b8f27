"""What may be chosen of the surface, and what is refused."""

import subprocess
import sys
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from georibbon.errors import SettingsError
from georibbon.geometry import surface
from georibbon.geometry.settings import (
    CORRESPONDENCES,
    DIRECTIONS,
    INTERIORS,
    LENGTHS,
    SurfaceSettings,
)

ANYTHING = st.one_of(
    st.none(), st.booleans(), st.integers(), st.floats(), st.text(), st.lists(st.floats())
)


def test_the_defaults_are_the_recommended_choices() -> None:
    settings = SurfaceSettings()
    chosen = (settings.direction, settings.lengths, settings.correspondence, settings.interior)
    assert chosen == (DIRECTIONS[0], LENGTHS[0], CORRESPONDENCES[0], INTERIORS[0])
    assert chosen == ("safe-chord", "arc", "foot-cover", "g1")
    assert surface.SurfaceSettings is SurfaceSettings


@pytest.mark.parametrize(
    ("setting", "words"),
    [
        ("direction", DIRECTIONS),
        ("lengths", LENGTHS),
        ("correspondence", CORRESPONDENCES),
        ("interior", INTERIORS),
    ],
)
def test_every_word_is_taken_and_no_other(setting: str, words: tuple[str, ...]) -> None:
    for word in words:
        assert getattr(SurfaceSettings(**{setting: word}), setting) == word
    with pytest.raises(SettingsError, match=f'is "straight"; it must be one of {words[0]}, '):
        SurfaceSettings(**{setting: "straight"})


def test_settings_compare_and_hash_by_value_also_when_given_as_lists() -> None:
    listed = SurfaceSettings(lengths=[1, 2], angles=[0, 5, 0, -5])
    assert listed == SurfaceSettings(lengths=(1.0, 2.0), angles=(0.0, 5.0, 0.0, -5.0))
    assert hash(listed) == hash(replace(listed))
    assert listed.lengths == (1.0, 2.0)


@pytest.mark.parametrize("cells", [1, 0, "true", None, (True,)])
def test_cells_are_asked_for_or_not(cells: object) -> None:
    assert not SurfaceSettings().cells
    assert SurfaceSettings(cells=True).cells
    with pytest.raises(SettingsError, match=r"cells is .*it must be true or false"):
        SurfaceSettings(cells=cells)
    for interior in INTERIORS:
        assert SurfaceSettings(cells=True, interior=interior).uses_cells == (interior == "g1")


@pytest.mark.parametrize("lengths", [(1.0,), (1.0, 0.0), (1.0, 11.0), (1.0, float("nan")), 3, None])
def test_lengths_that_mean_nothing_are_refused(lengths: object) -> None:
    with pytest.raises(
        SettingsError, match=r"tangent lengths are .*2 numbers between 0\.05 and 10"
    ):
        SurfaceSettings(lengths=lengths)


@pytest.mark.parametrize("angles", [(1.0, 2.0), (0.0, 0.0, 0.0, 81.0), "none"])
def test_angles_that_mean_nothing_are_refused(angles: object) -> None:
    with pytest.raises(SettingsError, match=r"angles are .*4 numbers between -80 and 80°"):
        SurfaceSettings(angles=angles)


@given(st.sampled_from(sorted(SurfaceSettings.__dataclass_fields__)), ANYTHING)
def test_anything_else_is_refused_in_one_sentence(setting: str, value: object) -> None:
    try:
        told = repr(SurfaceSettings(**{setting: value}))
    except SettingsError as error:
        told = str(error)
    assert told.startswith(("the surface's ", "SurfaceSettings("))


@pytest.mark.parametrize(
    ("chosen", "direction", "lengths"),
    [
        ({}, True, True),
        ({"interior": "c1-lines"}, False, True),
        ({"interior": "g2"}, False, False),
        ({"lengths": "criterion4"}, False, True),
    ],
)
def test_they_say_which_of_them_count(
    chosen: dict[str, str], direction: bool, lengths: bool
) -> None:
    settings = SurfaceSettings(**chosen)
    assert settings.uses_direction == direction
    assert settings.uses_lengths == lengths


def test_they_are_read_without_loading_numpy() -> None:
    code = (
        "import sys, georibbon.geometry.settings; "
        "assert not {'numpy', 'scipy'} & set(sys.modules), 'loaded'"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
