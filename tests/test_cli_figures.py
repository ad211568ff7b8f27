"""`georibbon figures`."""

import json

import pytest

from georibbon.cli import main


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """A folder that did not exist before, with two figures."""
    folder = tmp_path_factory.mktemp("figures") / "new" / "paper"
    assert main(["figures", "-o", str(folder), "--only", "9,8", "--width", "500"]) == 0
    return folder


def test_it_writes_pictures_a_table_and_a_page(written):
    names = {path.name for path in written.iterdir()}
    assert names == {"figure-08.png", "figure-09.png", "figures.json", "index.html"}
    for name in ("figure-08.png", "figure-09.png"):
        head = (written / name).read_bytes()[:24]
        assert head.startswith(b"\x89PNG")
        assert int.from_bytes(head[16:20]) == 500


def test_the_table_is_what_its_help_says(written):
    data = json.loads((written / "figures.json").read_text(encoding="utf-8"))
    assert (data["format"], data["version"]) == ("georibbon paper figures", 1)
    assert [one["number"] for one in data["figures"]] == [8, 9]
    for one in data["figures"]:
        assert one.keys() == {
            "number", "title", "situation", "paper_shows", "found", "picture", "choices",
        }  # fmt: skip
        assert (written / one["picture"]).is_file()
        for choice in one["choices"]:
            assert choice.keys() == {"name", "whose", "settings", "verdict", "numbers"}
            assert choice["whose"] in {"paper", "georibbon", "other"}
            assert choice["numbers"].keys() <= data["numbers"].keys()
    exact = data["figures"][1]["choices"][1]["numbers"]
    assert exact["rms_mm"] < 1e-6
    assert exact["skew_greatest_deg"] == pytest.approx(28.6, abs=0.1)


def test_the_page_names_its_pictures(written):
    text = (written / "index.html").read_text(encoding="utf-8")
    assert 'src="figure-08.png"' in text
    assert "Computer-Aided Design" in text


def test_it_tells_the_numbers_and_writes_over_an_earlier_time(tmp_path, capsys):
    (tmp_path / "figures.json").write_text("of an earlier time")
    assert main(["figures", "-o", str(tmp_path), "--only", "8", "--width", "400"]) == 0
    told = capsys.readouterr().out
    assert "Figure 8. A geodesic of a cone" in told
    assert "georibbon  A = 1 / tan a" in told
    assert (
        f"written: {tmp_path / 'index.html'}, {tmp_path / 'figures.json'} and 1 picture\n" in told
    )
    assert json.loads((tmp_path / "figures.json").read_text())["version"] == 1


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (["--only", "14"], "there is no figure 14"),
        (["--only", "7,x"], "'x'"),
        (["--width", "10"], "400 to 6000 pixels"),
    ],
)
def test_words_that_mean_nothing(tmp_path, capsys, words, named):
    assert main(["figures", "-o", str(tmp_path / "new"), *words]) == 2
    told = capsys.readouterr().err
    assert named in told
    assert told.startswith("georibbon: error: ")
    assert not (tmp_path / "new").exists()


def test_a_place_that_is_no_folder(tmp_path, capsys):
    (tmp_path / "file").write_text("")
    assert main(["figures", "-o", str(tmp_path / "file"), "--only", "8"]) == 2
    assert "the folder cannot be made" in capsys.readouterr().err


def test_nothing_is_left_where_it_cannot_be_drawn(tmp_path, monkeypatch):
    from georibbon.errors import ExportError

    def refuse(*_):
        raise ExportError("there is nothing to draw with")

    monkeypatch.setattr("georibbon.export.paper.pictures.picture_of", refuse)
    assert main(["figures", "-o", str(tmp_path / "new"), "--only", "8"]) == 2
    assert not (tmp_path / "new").exists()
