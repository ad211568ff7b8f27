"""What the window remembers, and that nothing in it stops the start."""

from georibbon.gui.settings import MOST_RECENT, Settings


def test_what_is_kept_comes_back(tmp_path):
    file = tmp_path / "settings.ini"
    one = Settings(file)
    assert one.theme == "light"
    assert one.recent == []
    assert one.layout() is None
    one.theme = "dark"
    one.opened(tmp_path)
    one.save()
    other = Settings(file)
    assert other.theme == "dark"
    assert other.recent == [tmp_path]
    other.forget_recent()
    assert other.recent == []


def test_only_what_exists_is_recent_and_the_newest_is_first(tmp_path):
    settings = Settings(tmp_path / "settings.ini")
    files = [tmp_path / f"{i}.georibbon" for i in range(MOST_RECENT + 3)]
    for file in files:
        file.touch()
        settings.opened(file)
    assert settings.recent == files[::-1][:MOST_RECENT]
    settings.opened(files[5])
    assert settings.recent[0] == files[5]
    assert settings.recent.count(files[5]) == 1
    files[5].unlink()
    assert files[5] not in settings.recent


def test_a_bad_file_stops_nothing(tmp_path):
    file = tmp_path / "settings.ini"
    file.write_bytes(
        b"[General]\ntheme=@Invalid()\nrecent=@Variant(\x00\x01)\nlayout=one\n"
        b"geometry=nonsense\nstate=3\n\xff\xfe[[["
    )
    settings = Settings(file)
    assert settings.theme == "light"
    assert settings.recent == []
    assert settings.layout() is None
    settings.opened(tmp_path)
    assert settings.recent == [tmp_path]
