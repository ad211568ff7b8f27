"""One thread for many small matrices.

The fits solve thousands of systems of a few dozen unknowns.  A linear algebra
library that shares each of them among threads spends its time waiting for
them: on two busy cores that took more than ten times as long.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache

from threadpoolctl import ThreadpoolController


@cache
def _controller() -> ThreadpoolController:
    """Found once: looking through the loaded libraries takes a millisecond or two."""
    return ThreadpoolController()


@contextmanager
def one_thread() -> Iterator[None]:
    """Keeps the linear algebra libraries to one thread within the block."""
    with _controller().limit(limits=1, user_api="blas"):
        yield
