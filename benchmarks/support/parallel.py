"""Many captures at a time, each on one thread."""

import os
import sys
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from typing import TypeVar

A = TypeVar("A")
B = TypeVar("B")

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


def in_parallel(work: Callable[[A], B], items: Sequence[A], processes: int = 2) -> list[B]:
    """work(item) for all items, in order, in processes of one thread each; progress on stderr."""
    # Started afresh, so that numpy sees the number of threads before it is loaded.
    os.environ.update(dict.fromkeys(THREADS, "1"))
    done = []
    with ProcessPoolExecutor(processes, mp_context=get_context("spawn")) as pool:
        for result in pool.map(work, items):
            done.append(result)
            if sys.stderr.isatty():
                print(f"\r{len(done)} of {len(items)}", end="", file=sys.stderr, flush=True)
    if sys.stderr.isatty():
        print(file=sys.stderr)
    return done
