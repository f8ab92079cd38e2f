"""Linear algebra on one thread: matrices of some hundred rows gain nothing from more, and may lose all.

OpenBLAS shares products of 64 rows and more among all cores, and waits for them by spinning. Where another
process has one of these cores, each product waits until the system gives it back: on a busy machine of two
cores contact problems of 150 contacts took ten to twenty times as long so.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from functools import cache
from typing import Any

SHARED_ROWS = 64
"""Rows of a matrix from which OpenBLAS shares products among threads."""
_TAKEN = threading.Lock()
_ANY: AbstractContextManager[None] = nullcontext()


def light_blas(rows: int) -> AbstractContextManager[None]:
    """Return a context in which BLAS takes one thread, if matrices have so many rows that it would take more.

    It is the whole process's. Who enters while another one is open, inside it or in another thread, leaves
    it to that one, which puts back what was before when it ends.
    """
    return _one_thread() if rows >= SHARED_ROWS else _ANY


@contextmanager
def _one_thread() -> Iterator[None]:
    if not _TAKEN.acquire(blocking=False):
        yield
        return
    try:
        with _libraries().limit(limits=1, user_api="blas"):
            yield
    finally:
        _TAKEN.release()


@cache
def _libraries() -> Any:
    """Return what knows the BLAS libraries of this process; finding them takes 10 ms."""
    import scipy.linalg  # noqa: F401 - loads SciPy's BLAS: what is loaded later would not be found
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()
