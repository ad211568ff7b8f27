"""Folders where a session is not safe: found from the texts and the names alone."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from georibbon.session import place
from georibbon.session.place import drive_of, network_of, place_warnings
from georibbon.session.session import Session

MOUNTS = r"""
22 1 8:2 / / rw,relatime shared:1 - ext4 /dev/sda2 rw
30 22 0:26 / /proc rw - proc proc rw
41 22 0:45 / /mnt/share rw,relatime shared:2 - cifs //server/data rw
42 22 8:3 / /mnt/share/local rw - ext4 /dev/sda3 rw
43 22 0:46 / /home/a/my\040disk rw - nfs4 server:/x rw
44 22 0:47 / /home/a/ssh rw - fuse.sshfs a@b: rw
45 22 0:48 / /home/a/usb rw - fuseblk /dev/sdb1 rw
46 22 0:49 / /mnt/c rw - 9p drvfs rw
47 22 0:50 / /mnt/twice rw - ext4 /dev/sdc1 rw
48 47 0:51 / /mnt/twice rw - nfs server:/y rw
"""


@pytest.mark.parametrize(
    ("folder", "kind"),
    [
        ("/", None),
        ("/home/a", None),
        ("/mnt/share", "cifs"),
        ("/mnt/share/deep/down", "cifs"),
        ("/mnt/share/local/x", None),
        ("/mnt/shared", None),
        ("/home/a/my disk/x", "nfs4"),
        ("/home/a/ssh", "fuse.sshfs"),
        ("/home/a/usb", None),
        ("/mnt/c/Users", "9p"),
        ("/mnt/twice", "nfs"),
        ("//server/share", "a shared folder"),
        ("\\\\server\\share", "a shared folder"),
    ],
)
def test_the_longest_mount_point_tells(folder, kind):
    assert network_of(folder, MOUNTS) == kind


@given(st.text("0123456789/ \\-:.\nacifsn", max_size=200))
def test_any_text_of_mounts_is_no_fault(text):
    assert network_of("/mnt/share", text) in (None, "cifs", "nfs")


@pytest.mark.parametrize(
    ("folder", "marker", "drive"),
    [
        ("/home/a/Dropbox/x", None, "Dropbox"),
        ("/home/a/Dropbox (Firma)/x", None, "Dropbox"),
        ("/home/a/dropboxes", None, None),
        ("/Users/a/OneDrive - Firma", None, "OneDrive"),
        ("/Users/a/Library/CloudStorage/GoogleDrive-a@b.c/My Drive", None, "Google Drive"),
        ("/Users/a/Library/Mobile Documents/x", None, "iCloud"),
        ("/home/a/Nextcloud", None, "Nextcloud"),
        ("/home/a/ownCloud/b/c", None, "ownCloud"),
        ("/home/a/synced/b", "/home/a/synced/.stfolder", "Syncthing"),
        ("/home/a/synced/b", "/home/a/other/.stfolder", None),
        ("/home/a/x", "/home/a/.dropbox", "Dropbox"),
        ("/home/a/x", None, None),
    ],
)
def test_names_and_markers_of_synchronising_programs(folder, marker, drive):
    assert drive_of(Path(folder), lambda path: str(path) == marker) == drive


def test_a_folder_that_may_not_be_looked_at_is_no_fault():
    def refuse(_):
        raise PermissionError(13, "Permission denied")

    assert drive_of(Path("/home/a"), refuse) is None


def test_a_session_tells_of_its_place(tmp_path, monkeypatch):
    folder = tmp_path / "Dropbox"
    folder.mkdir()
    mounts = tmp_path / "mounts"
    mounts.write_text(f"1 1 0:1 / {folder} rw - nfs4 server:/ rw\n")
    monkeypatch.setattr(place, "_MOUNTS", mounts)
    with Session.create(folder / "s.georibbon") as session:
        told = session.warnings
    assert len(told) == 2
    assert "on a network (nfs4)" in told[0]
    assert "in step by Dropbox" in told[1]
    with Session.open(folder / "s.georibbon") as session:
        assert session.warnings == told
        session.move_to(tmp_path / "t.georibbon")
        assert session.warnings == ()
    monkeypatch.setattr(place, "_MOUNTS", tmp_path / "none")
    assert place_warnings(tmp_path / "s.georibbon") == ()
