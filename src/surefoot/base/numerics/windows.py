"""Sums and means over windows that slide along rows."""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray


def sliding_sum(values: FloatArray, rows: int) -> FloatArray:
    """Return the sum over a window of so many rows about each row: shape and unit of (T, ...) values."""
    count, below, above = len(values), (rows - 1) // 2, rows // 2 + 1
    total = np.zeros((count + 1, *values.shape[1:]))
    np.cumsum(values, axis=0, out=total[1:])
    out, inside = np.empty_like(total[1:]), max(count - above + 1, 0)
    out[:inside], out[inside:] = total[above : above + inside], total[count]
    if below < count:
        out[below:] -= total[: count - below]
    return out


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
