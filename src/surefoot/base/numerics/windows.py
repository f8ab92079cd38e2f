"""Sums and means over windows that slide along rows."""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import releasing_kernel


def sliding_sum(values: FloatArray, rows: int) -> FloatArray:
    """Return the sum over a window of so many rows about each row: shape and unit of (T, ...) values."""
    flat = np.ascontiguousarray(values, dtype=np.float64).reshape(len(values), math.prod(values.shape[1:]))
    out = np.empty(flat.shape)
    _sums(flat, (rows - 1) // 2, rows // 2 + 1, out)
    return out.reshape(values.shape)


@releasing_kernel
def _sums(values: FloatArray, below: int, above: int, out: FloatArray) -> None:
    """Fill out (T, k) with sums over the rows from `below` before each to that before `above` after it.

    As differences of sums from the first row on.
    """
    count, width = values.shape
    total = np.zeros((count + 1, width))
    for t in range(count):
        for k in range(width):
            total[t + 1, k] = total[t, k] + values[t, k]
    for t in range(count):
        first, last = max(t - below, 0), min(t + above, count)
        for k in range(width):
            out[t, k] = total[last, k] - total[first, k]


def sliding_mean(values: FloatArray, rows: int) -> FloatArray:
    """Return the mean of (T, ...) values over so many rows, of what is not NaN: in shape and unit of them.

    NaN for less than half.
    """
    known = np.isfinite(values)
    if known.all():
        places = np.arange(len(values))
        inside = np.minimum(places + rows // 2 + 1, len(values)) - np.maximum(places - (rows - 1) // 2, 0)
        return np.asarray(sliding_sum(values, rows) / inside.reshape(-1, *[1] * (values.ndim - 1)))
    count = sliding_sum(known.astype(np.float64), rows)
    total = sliding_sum(np.where(known, values, 0.0), rows)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(count >= 0.5 * min(rows, len(values)), total / count, np.nan)
