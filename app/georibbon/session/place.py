"""Folders where a session is not safe: on a network, or copied about while it is written."""

import re
from collections.abc import Callable
from pathlib import Path, PurePosixPath

from georibbon.session.words import told

_NETWORK = frozenset(
    ("nfs", "nfs3", "nfs4", "cifs", "smb", "smb2", "smb3", "smbfs", "ncpfs", "afs", "9p", "drvfs",
     "ceph", "glusterfs", "lustre", "gfs2", "ocfs2", "davfs", "sshfs", "vboxsf", "prl_fs",
     "acfs", "beegfs", "coda", "moosefs", "orangefs", "gpfs", "vmhgfs")
)  # fmt: skip
_FUSE = frozenset(
    ("sshfs", "rclone", "gvfsd-fuse", "s3fs", "gcsfuse", "davfs", "davfs2", "curlftpfs", "smbnetfs",
     "glusterfs", "ceph-fuse", "vmhgfs-fuse", "google-drive-ocamlfuse", "onedriver", "juicefs")
)  # fmt: skip
_DRIVES = {
    "Dropbox": r"dropbox\b.*",
    "OneDrive": r"onedrive\b.*",
    "Google Drive": r"(google ?drive|my drive)\b.*",
    "Nextcloud": r"nextcloud\b.*",
    "ownCloud": r"owncloud\b.*",
    "iCloud": r"(icloud ?drive|mobile documents)\b.*",
}
_MARKERS = {
    ".dropbox": "Dropbox",
    ".dropbox.cache": "Dropbox",
    ".849C9593-D756-4E56-8D6E-42412F2A707B": "OneDrive",
    ".tmp.drivedownload": "Google Drive",
    ".nextcloudsync.log": "Nextcloud",
    ".owncloudsync.log": "ownCloud",
    ".stfolder": "Syncthing",
}
_MOUNTS = Path("/proc/self/mountinfo")


def place_warnings(path: Path) -> tuple[str, ...]:
    """What a person must know of the place of a session, a sentence each."""
    folder = path.resolve().parent
    found = []
    network = network_of(str(folder), _mounts())
    if network:
        found.append(
            f"{told(str(folder))[1:-1]} is on a network ({network}), where a capture may be lost "
            "when the connection is; save the session on a disk of this computer"
        )
    drive = drive_of(folder, Path.exists)
    if drive:
        found.append(
            f"{told(str(folder))[1:-1]} is kept in step by {drive}, which may copy the session "
            "half written; save it elsewhere and copy it there when it is closed"
        )
    return tuple(found)


def network_of(folder: str, mounts: str) -> str | None:
    """The kind of the network file system that an absolute folder is on; None for a local one.

    mounts: the text of Linux's mountinfo, see proc(5); "" where there is none.
    """
    if re.match(r"(\\\\|//)[^\\/.?]", folder):
        return "a shared folder"
    best, kind = -1, None
    for line in mounts.split("\n"):
        left, dash, right = line.partition(" - ")
        fields = left.split(" ")
        if not dash or len(fields) < 5:
            continue
        point = PurePosixPath(re.sub(r"\\([0-7]{3})", _character, fields[4]))
        if PurePosixPath(folder).is_relative_to(point) and len(point.parts) >= best:
            best, kind = len(point.parts), right.split(" ")[0]
    if kind is None:
        return None
    base, _, below = kind.partition(".")
    return kind if kind in _NETWORK or (base == "fuse" and below in _FUSE) else None


def drive_of(folder: Path, exists: Callable[[Path], bool]) -> str | None:
    """The program that keeps a folder in step with other computers; None where there is none.

    exists: whether there is something at a path.
    """
    for place in (folder, *folder.parents):
        for drive, pattern in _DRIVES.items():
            if re.fullmatch(pattern, place.name, re.IGNORECASE):
                return drive
        for marker, drive in _MARKERS.items():
            if _there(place / marker, exists):
                return drive
    return None


def _there(path: Path, exists: Callable[[Path], bool]) -> bool:
    try:
        return exists(path)
    except OSError:
        return False


def _character(escape: re.Match[str]) -> str:
    return chr(int(escape[1], 8))


def _mounts() -> str:
    try:
        return _MOUNTS.read_text(encoding="utf-8", errors="surrogateescape")
    except OSError:
        return ""
