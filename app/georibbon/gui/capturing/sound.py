"""What was taken or refused is heard: short tones, played by whatever the system has."""

import math
import shutil
import struct
import sys
import tempfile
import wave
import weakref
from pathlib import Path
from typing import Literal

from PySide6.QtCore import QProcess
from PySide6.QtWidgets import QApplication

from georibbon.gui.parts import Parts

Sound = Literal["taken", "refused", "complete"]
RATE = 22050  # samples a second
LOUDNESS = 0.35
FADE = 0.01  # s, so that no tone begins or ends with a click
# Each sound's tones, (Hz, s): taken rises, refused falls, complete is a chord broken upwards.
TONES: dict[Sound, tuple[tuple[float, float], ...]] = {
    "taken": ((660.0, 0.09), (990.0, 0.14)),
    "refused": ((330.0, 0.14), (247.0, 0.20)),
    "complete": ((523.0, 0.12), (659.0, 0.12), (784.0, 0.12), (1047.0, 0.25)),
}
PLAYERS = (
    ("afplay",),
    ("paplay",),
    ("pw-play",),
    ("aplay", "-q"),
)


def samples(sound: Sound) -> bytes:
    """A sound as 16-bit mono samples."""
    out = bytearray()
    for pitch, seconds in TONES[sound]:
        count = round(seconds * RATE)
        for k in range(count):
            t = k / RATE
            swell = min(1.0, t / FADE, (seconds - t) / FADE)
            level = LOUDNESS * swell * math.sin(2.0 * math.pi * pitch * t)
            out += struct.pack("<h", round(32767 * level))
    return bytes(out)


def write_sound(sound: Sound, path: Path) -> None:
    """Write a sound as a WAV file."""
    with wave.open(str(path), "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(RATE)
        file.writeframes(samples(sound))


class Sounds:
    """Plays sounds unless the settings say to be silent; never waits, never fails."""

    def __init__(self, parts: Parts) -> None:
        self._settings = parts.settings
        self._folder: Path | None = None
        self._clear: weakref.finalize | None = None
        self._files: dict[Sound, Path] = {}

    def play(self, sound: Sound) -> None:
        """Play a sound beside what goes on; a beep where the system has no player."""
        if not self._settings.sound:
            return
        try:
            played = self._played(self._file(sound))
        except OSError:
            played = False
        if not played:
            QApplication.beep()

    def end(self) -> None:
        """Take the files away again; they go with this object anyway."""
        clear, self._clear, self._folder = self._clear, None, None
        self._files.clear()
        if clear is not None:
            clear()

    def _file(self, sound: Sound) -> Path:
        if self._folder is None:
            self._folder = Path(tempfile.mkdtemp(prefix="georibbon-"))
            self._clear = weakref.finalize(self, shutil.rmtree, self._folder, ignore_errors=True)
        if sound not in self._files:
            path = self._folder / f"{sound}.wav"
            write_sound(sound, path)
            self._files[sound] = path
        return self._files[sound]

    def _played(self, path: Path) -> bool:
        if sys.platform == "win32":
            import winsound

            winsound.PlaySound(str(path), winsound.SND_FILENAME | winsound.SND_ASYNC)
            return True
        for player, *options in PLAYERS:
            program = shutil.which(player)
            if program is not None:
                process = QProcess()
                process.setProgram(program)
                process.setArguments([*options, str(path)])
                process.setStandardOutputFile(QProcess.nullDevice())
                process.setStandardErrorFile(QProcess.nullDevice())
                started = process.startDetached()
                # Some versions of PySide6 tell the process's number beside it.
                return bool(started[0] if isinstance(started, tuple) else started)
        return False
