"""Processes that work side by side, of which one may fall without taking others along."""

import multiprocessing
import os
import signal
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Generic, TypeVar

_TICK = 0.2  # seconds between looks at the signals
_MOST = 61  # processes that Windows can wait for
_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
J = TypeVar("J")
R = TypeVar("R")


@dataclass(frozen=True)
class Fallen:
    """A job that came to nothing: it was stopped before its end, or failed, and why."""

    stopped: bool
    message: str


_STOPPED = Fallen(True, "ended before it was done")
_ABRUPT = Fallen(
    False,
    "its process ended abruptly, perhaps for want of memory; try it by itself with "
    "georibbon reconstruct",
)


class Crew(Generic[J, R]):
    """So many processes, 61 at most, each with one thread, for one kind of work.

    work: a function that another process can import; it takes a job.
    """

    def __init__(self, size: int, work: Callable[[J], R]) -> None:
        self._size, self._work = min(size, _MOST), work

    def do(
        self, jobs: Sequence[J], signals: Sequence[int], told: Callable[[bool], None]
    ) -> Iterator[tuple[J, R | Fallen]]:
        """Do the jobs, and yield each with what came of it as soon as it is known.

        signals: those that have come so far; after the first no other job is
        begun, after a second those that run are ended too.  told: called again
        and again meanwhile with whether it is ending.
        """
        waiting, alone = deque(jobs), list[J]()
        while waiting and not signals:
            for job, result in self._together(waiting, signals, told):
                if result is _ABRUPT and self._size > 1:
                    alone.append(job)  # one of those that ran then; not known which
                else:
                    yield job, result
        for job in alone:
            if signals:
                yield job, _STOPPED
            else:
                yield from Crew(1, self._work)._together(deque([job]), signals, told)
        for job in waiting:
            yield job, _STOPPED

    def _together(
        self, waiting: deque[J], signals: Sequence[int], told: Callable[[bool], None]
    ) -> Iterator[tuple[J, R | Fallen]]:
        """Do jobs until none waits, or one has taken the others that ran along."""
        others = set(multiprocessing.active_children())
        running: dict[Future[R], J] = {}
        with _one_thread_each(), self._pool() as pool:
            broken = False
            while running or (waiting and not signals and not broken):
                while waiting and len(running) < self._size and not signals and not broken:
                    broken = not _begun(pool, self._work, waiting, running)
                done, _ = wait(running, timeout=_TICK, return_when=FIRST_COMPLETED)
                if len(signals) > 1:
                    for process in set(multiprocessing.active_children()) - others:
                        process.terminate()
                for future in done:
                    job, result = running.pop(future), _result(future, len(signals) > 1)
                    broken |= result is _ABRUPT
                    yield job, result
                told(bool(signals))

    def _pool(self) -> ProcessPoolExecutor:
        # Not forked: a process with threads, of libraries or of the window, must not be.
        context = multiprocessing.get_context("spawn")
        return ProcessPoolExecutor(self._size, mp_context=context, initializer=_deaf)


def _begun(
    pool: ProcessPoolExecutor,
    work: Callable[[J], R],
    waiting: deque[J],
    running: dict[Future[R], J],
) -> bool:
    """Begin the next job; False where the processes are gone, and it waits still."""
    try:
        future = pool.submit(work, waiting[0])
    except BrokenProcessPool:
        return False
    running[future] = waiting.popleft()
    return True


def _result(future: Future[R], ended: bool) -> R | Fallen:
    try:
        return future.result()
    except BrokenProcessPool:
        return _STOPPED if ended else _ABRUPT
    except Exception as error:
        return Fallen(
            False,
            f"a fault of the program, not of your input: {type(error).__name__}: {error}; please "
            "report it with what georibbon reconstruct --debug prints",
        )


def _deaf() -> None:
    """In a process: interrupts are for the one that began it, which tells when to end."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


@contextmanager
def _one_thread_each() -> Iterator[None]:
    """Processes that are begun meanwhile calculate with one thread each."""
    before = {name: os.environ.get(name) for name in _THREADS}
    os.environ.update(dict.fromkeys(_THREADS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
