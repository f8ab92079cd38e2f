"""Small loops over the arrays of a horizon: bounds, and what is remembered per step and foot."""

from __future__ import annotations

import numpy as np

from surefoot.arrays import BoolArray, FloatArray
from surefoot.kernels import kernel


@kernel
def lowered(bounds: FloatArray, share: FloatArray) -> FloatArray:
    """Return (N, n, 3) bounds whose largest normal forces are lowered to (N, n) shares of them."""
    out = bounds.copy()
    for k in range(share.shape[0]):
        for i in range(share.shape[1]):
            out[k, i, 2] *= share[k, i]
            out[k, i, 1] = min(out[k, i, 1], out[k, i, 2])
    return out


@kernel
def gather(points: FloatArray, contacts: BoolArray) -> FloatArray:
    """Return the (c, 3) rows of points (N, n, 3) that an (N, n) mask selects, in order."""
    out, at = np.empty((points.shape[0] * points.shape[1], 3)), 0
    for k in range(points.shape[0]):
        for i in range(points.shape[1]):
            if contacts[k, i]:
                out[at] = points[k, i]
                at += 1
    return out[:at]


@kernel
def scatter(point: FloatArray, contacts: BoolArray, out: FloatArray) -> None:
    """Fill (N, n, 3) with the (c, 3) rows where an (N, n) mask says so, and NaN elsewhere."""
    at = 0
    for k in range(out.shape[0]):
        for i in range(out.shape[1]):
            out[k, i] = np.nan
            if contacts[k, i]:
                out[k, i] = point[at]
                at += 1
