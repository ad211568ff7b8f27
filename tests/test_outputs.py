"""Outputs appear together or not at all."""

import pytest

from georibbon.cli.outputs import Outputs
from georibbon.errors import ExportError, SurfaceError


def test_all_appear_together(tmp_path):
    a, b = tmp_path / "a.txt", tmp_path / "b.txt"
    with Outputs([a, b]) as outputs:
        outputs.place(a).write_text("A")
        assert not a.exists()
        outputs.place(b).write_text("B")
        assert outputs.place(b).name == "b.txt"
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {
        "a.txt": "A",
        "b.txt": "B",
    }


def test_an_older_file_is_replaced(tmp_path):
    target = tmp_path / "a.txt"
    target.write_text("old")
    with Outputs([target]) as outputs:
        outputs.place(target).write_text("new")
        assert target.read_text() == "old"
    assert target.read_text() == "new"


def test_an_error_leaves_nothing(tmp_path):
    a, b = tmp_path / "a.txt", tmp_path / "b.txt"
    b.write_text("old")

    def fail() -> None:
        with Outputs([a, b]) as outputs:
            outputs.place(a).write_text("A")
            raise SurfaceError(f"{outputs.place(b)}: no triangle")

    with pytest.raises(SurfaceError) as caught:
        fail()
    assert str(caught.value) == f"{b}: no triangle"  # not the place it was prepared in
    assert [path.name for path in tmp_path.iterdir()] == ["b.txt"]
    assert b.read_text() == "old"


@pytest.mark.parametrize("kind", [KeyboardInterrupt, RuntimeError])
def test_any_error_leaves_nothing(tmp_path, kind):
    target = tmp_path / "a.txt"

    def fail() -> None:
        with Outputs([target]) as outputs:
            outputs.place(target).write_text("A")
            raise kind

    with pytest.raises(kind):
        fail()
    assert list(tmp_path.iterdir()) == []


def refusal(targets, inputs=()) -> str:
    with pytest.raises(ExportError) as caught, Outputs(targets, inputs):
        pass
    return str(caught.value)


def test_refusals_name_the_file_and_leave_nothing(tmp_path):
    good, folder = tmp_path / "good.stl", tmp_path / "folder.stl"
    folder.mkdir()
    (tmp_path / "file").write_text("")
    assert "there is no folder" in refusal([good, tmp_path / "missing" / "a.stl"])
    assert "there is no folder" in refusal([good, tmp_path / "file" / "a.stl"])
    assert "this is a folder" in refusal([good, folder])
    assert "this is an input" in refusal([good], inputs=[None, tmp_path / "." / "good.stl"])
    assert "named for two outputs" in refusal([good, folder / ".." / "good.stl"])
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "folder.stl"]


def test_a_folder_that_cannot_be_written_to(tmp_path, monkeypatch):
    def deny(**_: object) -> str:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("georibbon.cli.outputs.tempfile.mkdtemp", deny)
    told = refusal([tmp_path / "a.stl"])
    assert str(tmp_path / "a.stl") in told
    assert "Permission denied" in told
