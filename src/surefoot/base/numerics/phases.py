"""Phases of what is true or false over time."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray


def debounced(time: FloatArray, touch: BoolArray, shortest: float) -> BoolArray:
    """Return (T,) contacts without phases shorter than `shortest` [s], the shortest taken first."""
    edges = [0, *(np.flatnonzero(np.diff(touch.astype(np.int8))) + 1).tolist(), len(touch)]
    state = bool(touch[0])
    end = time[-1] + (time[-1] - time[-2])
    stamps = np.append(time, end)
    while len(edges) > 3:  # first and last phase may be cut and are kept
        lengths = [stamps[edges[k + 1]] - stamps[edges[k]] for k in range(1, len(edges) - 2)]
        k = int(np.argmin(lengths)) + 1
        if lengths[k - 1] >= shortest:
            break
        # both edges of a short phase go: it joins its neighbours, which makes those longer
        del edges[k : k + 2]
    out = np.empty(len(touch), dtype=bool)
    for begin, finish in pairwise(edges):
        out[begin:finish], state = state, not state
    return out


def runs_of(on: BoolArray) -> list[tuple[int, int]]:
    """Return (first, last + 1) of the runs where a (T,) flag is set."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], on.astype(int), [0]]))).tolist()
    return list(zip(edges[::2], edges[1::2], strict=True))


def joined_runs(on: BoolArray, join: int = 1) -> list[tuple[int, int]]:
    """Return the runs of a (T,) flag, those that less than `join` rows part taken for one.

    Examples
    --------
    >>> joined_runs(np.array([1, 0, 1, 0, 0, 1], dtype=bool), 2)
    [(0, 3), (5, 6)]
    """
    out: list[tuple[int, int]] = []
    for start, end in runs_of(on):
        if out and start - out[-1][1] < join:
            out[-1] = out[-1][0], end
        else:
            out.append((start, end))
    return out
