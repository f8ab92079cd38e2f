"""How many processors there are for this process, and work that is shared among threads."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

SHARES, LEAST = 8, 16
"""Pieces per thread that work is cut into, so that hard ones do not hold up the rest, and the items that a
piece has at least."""


def cores() -> int:
    """Return how many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def in_ranges(work: Callable[[int, int], None], count: int, threads: int) -> None:
    """Run `work(start, stop)` over 0 to count, in pieces on threads if there are more than one."""
    pieces = min(threads * SHARES, count // LEAST)
    if threads == 1 or pieces < 2:
        work(0, count)
        return
    edges = np.linspace(0, count, pieces + 1).astype(int).tolist()
    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(work, edges[:-1], edges[1:]))  # what one raises is raised here
