"""Output files that appear all together when all are ready, or not at all."""

import shutil
import signal
import tempfile
import threading
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import TracebackType

from georibbon.errors import ExportError, GeoribbonError

SIGNALS = ("SIGINT", "SIGTERM", "SIGHUP")


@contextmanager
def signals_noted() -> Iterator[list[int]]:
    """While the block runs, interrupts come into this list and end nothing by themselves."""
    came: list[int] = []
    numbers = [getattr(signal, name) for name in SIGNALS if hasattr(signal, name)]
    if threading.current_thread() is not threading.main_thread():
        numbers = []  # only the main thread may, and only it is interrupted
    before = {number: signal.signal(number, lambda n, _: came.append(n)) for number in numbers}
    try:
        yield came
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def signals_held() -> Iterator[None]:
    """Holds signals back until the block is done: an exception raised inside VTK is a crash."""
    came: list[int] = []
    try:
        with signals_noted() as came:
            yield
    finally:
        for number in came[:1]:
            signal.raise_signal(number)


@contextmanager
def folder_made(folder: Path) -> Iterator[None]:
    """Makes the folder, and takes it away again where nothing comes to lie in it."""
    missing = [path for path in (folder, *folder.parents) if not path.exists()]
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ExportError(
            f"{folder}: the folder cannot be made ({error.strerror}); choose another place"
        ) from error
    try:
        yield
    except BaseException:
        with suppress(OSError):
            for path in missing:
                path.rmdir()
        raise


class Outputs:
    """Places to write to, each beside the file that is meant.

    Entering claims every target: its folder must be there and let us write, and
    it must not be one of the inputs.  Leaving without an error renames all
    files to their targets; leaving with one removes them.
    """

    def __init__(self, targets: Iterable[Path], inputs: Iterable[Path | None] = ()) -> None:
        self.targets = tuple(targets)
        self._inputs = {path.resolve() for path in inputs if path is not None}
        self._places: dict[Path, Path] = {}

    def __enter__(self) -> "Outputs":
        try:
            for target in self.targets:
                self._claim(target)
        except BaseException:
            self._clear()
            raise
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        try:
            if error is None:
                for target, place in self._places.items():
                    place.replace(target)
            elif isinstance(error, GeoribbonError):
                error.args = (self._in_targets(str(error)),)
        finally:
            self._clear()

    def place(self, target: Path) -> Path:
        """Where to write what is to become `target`: a file of the same name."""
        return self._places[target]

    def _claim(self, target: Path) -> None:
        self._refuse(target)
        try:
            folder = tempfile.mkdtemp(prefix=".georibbon-", dir=target.parent)
        except OSError as error:
            raise ExportError(
                f"{target}: the folder {target.parent} cannot be written to ({error.strerror}); "
                "choose a place where you may write"
            ) from error
        self._places[target] = Path(folder) / target.name

    def _refuse(self, target: Path) -> None:
        if not target.parent.is_dir():
            raise ExportError(
                f"{target}: there is no folder {target.parent}; make it or choose another place"
            )
        if target.is_dir():
            raise ExportError(f"{target}: this is a folder, a file name was expected")
        if target.resolve() in self._inputs:
            raise ExportError(f"{target}: this is an input; write to another file")
        if target.exists() and any(self._raw(target.resolve(), one) for one in self._inputs):
            raise ExportError(
                f"{target}: this is a file of the recording, and raw data is never overwritten; "
                "write to another place"
            )
        if target.resolve() in {other.resolve() for other in self._places}:
            raise ExportError(f"{target}: named for two outputs; give each its own file")

    @staticmethod
    def _raw(target: Path, source: Path) -> bool:
        """Whether the target is a table or description inside a recording folder."""
        return target.suffix.lower() in (".csv", ".toml") and target.is_relative_to(source)

    def _in_targets(self, message: str) -> str:
        """The message with the files named as the person named them."""
        for target, place in self._places.items():
            message = message.replace(str(place), str(target))
        return message

    def _clear(self) -> None:
        for place in self._places.values():
            shutil.rmtree(place.parent, ignore_errors=True)
