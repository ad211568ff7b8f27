"""What the window remembers, and that nothing in it stops the start."""

import json
import math
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from PySide6.QtCore import QByteArray

from georibbon.gui.notifier import Notifier
from georibbon.gui.settings import LARGEST_FILE, MOST_RECENT, Settings


@pytest.fixture
def file(tmp_path):
    """Where settings are kept."""
    return tmp_path / "settings.ini"


@pytest.fixture(scope="module")
def shelf(tmp_path_factory):
    """A folder that all examples of a law share: each begins with a new file in it."""
    return tmp_path_factory.mktemp("settings")


plain = st.one_of(
    st.booleans(),
    st.integers(),
    st.floats(allow_nan=False, allow_infinity=False),
    st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0")),
    st.lists(st.text(st.characters(exclude_categories=["Cs"]))),
    st.binary(min_size=1).map(QByteArray),
)


@given(values=st.dictionaries(st.sampled_from(["a", "part/b", "c d", "é"]), plain))
def test_what_is_put_comes_back_of_its_type_after_a_restart(values, shelf):
    file = shelf / "put.ini"
    file.unlink(missing_ok=True)
    one = Settings(file)
    for name, value in values.items():
        one.put(name, value)
        assert one.get(name, type(value)()) == value
    one.save()
    other = Settings(file)
    for name, value in values.items():
        found = other.get(name, type(value)())
        assert found == value
        assert type(found) is type(value)


@given(text=st.text(max_size=60), default=st.sampled_from([True, 7, 2.5, ["x"], QByteArray(b"y")]))
def test_any_entry_gives_the_defaults_type(text, default, shelf):
    file = shelf / "any.ini"
    file.write_text(f"[General]\nentry={text}\n", encoding="utf-8", errors="replace")
    found = Settings(file).get("entry", default)
    assert type(found) is type(default)
    assert not isinstance(found, float) or math.isfinite(found)


@given(data=st.binary(max_size=300))
def test_any_file_is_read(data, shelf):
    file = shelf / "bytes.ini"
    file.write_bytes(data)
    settings = Settings(file)
    assert settings.theme in ("light", "dark")
    assert settings.unit in ("mm", "cm", "in")
    assert settings.language in ("en", "fr")
    assert settings.sound in (True, False)
    assert all(path.exists() for path in settings.recent)
    assert settings.folder is None or settings.folder.exists()
    settings.layout()
    settings.put("unit", "in")
    assert settings.unit == "in"


def test_what_is_kept_comes_back(file, tmp_path):
    one = Settings(file)
    assert (one.theme, one.unit, one.sound) == ("light", "mm", True)
    assert (one.recent, one.layout(), one.folder) == ([], None, None)
    one.theme, one.unit, one.language, one.sound = "dark", "in", "fr", False
    one.folder = tmp_path
    one.opened(tmp_path)
    one.keep_layout(QByteArray(b"geometry"), QByteArray(b"state"))
    one.save()
    other = Settings(file)
    assert (other.theme, other.unit, other.language, other.sound) == ("dark", "in", "fr", False)
    assert (other.recent, other.folder) == ([tmp_path], tmp_path)
    assert other.layout() == (b"geometry", b"state")
    other.forget_recent()
    other.folder = None
    assert (other.recent, other.folder) == ([], None)


def test_a_layout_of_another_version_is_not_taken_up(file):
    settings = Settings(file)
    settings.keep_layout(QByteArray(b"geometry"), QByteArray(b"state"))
    assert settings.layout() is not None
    settings.put("layout", 1)
    assert settings.layout() is None


def test_only_what_exists_is_recent_and_the_newest_is_first(file, tmp_path):
    settings = Settings(file)
    files = [tmp_path / f"{i}, a.georibbon" for i in range(MOST_RECENT + 3)]
    for one in files:
        one.touch()
        settings.opened(one)
    assert settings.recent == files[::-1][:MOST_RECENT]
    settings.opened(files[5])
    assert settings.recent[0] == files[5]
    assert settings.recent.count(files[5]) == 1
    files[5].unlink()
    assert files[5] not in settings.recent


def test_bad_entries_are_as_at_first(file, tmp_path):
    file.write_bytes(
        b"[General]\ntheme=@Invalid()\nrecent=@Variant(\x00\x01)\nlayout=one\nunit=furlong\n"
        b"sound=perhaps\nlanguage=tlh\nfolder=/no/such/place\ngeometry=nonsense\nstate=3\n"
    )
    settings = Settings(file)
    assert (settings.theme, settings.unit, settings.sound) == ("light", "mm", True)
    assert settings.language in ("en", "fr")
    assert (settings.recent, settings.layout(), settings.folder) == ([], None, None)
    file.write_text(f"[General]\nrecent={json.dumps(json.dumps([3, str(tmp_path)]))}\n")
    assert Settings(file).recent == []


def test_a_damaged_file_is_told_of_once_and_written_anew(file):
    file.write_bytes(b"theme=dark\n[[[\n\xff\xfe no line of any kind\n]")
    notifier = Notifier()
    settings = Settings(file, notifier)
    (entry,) = notifier.entries
    assert entry.level == "warning"
    assert str(file) in entry.text
    settings.theme = "dark"
    settings.save()
    assert Settings(file).theme == "dark"
    assert len(notifier.entries) == 1


def test_a_file_that_is_far_too_large_is_set_aside(file):
    file.write_bytes(b"theme=dark\n" + bytes(LARGEST_FILE))
    notifier = Notifier()
    settings = Settings(file, notifier)
    assert settings.theme == "light"
    assert len(notifier.entries) == 1
    assert Path(f"{file}.damaged").exists()


def test_what_cannot_be_written_is_told_once_and_lasts(tmp_path):
    (tmp_path / "file").touch()
    notifier = Notifier()
    settings = Settings(tmp_path / "file" / "settings.ini", notifier)
    settings.theme = "dark"
    settings.save()
    settings.save()
    assert settings.theme == "dark"
    (entry,) = notifier.entries
    assert "cannot be written" in entry.text
