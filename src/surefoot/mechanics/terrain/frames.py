"""Contact frames of many surface normals at once, compiled."""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import kernel


@kernel
def surface_frames(normals: FloatArray, frames: FloatArray) -> None:
    """Write `spatial.rotation_from_normal` of each unit normal (n, 3) into frames (n, 3, 3)."""
    for c in range(normals.shape[0]):
        n = normals[c]
        k = 0
        if 1.0 - n[0] * n[0] < 1e-12:  # the heading x is along the normal: the axis least aligned with it
            k = 1 if abs(n[1]) <= abs(n[2]) else 2
        length = math.sqrt(1.0 - n[k] * n[k])
        for i in range(3):
            frames[c, i, 0] = ((1.0 if i == k else 0.0) - n[k] * n[i]) / length
            frames[c, i, 2] = n[i]
        for i in range(3):
            a, b = (i + 1) % 3, (i + 2) % 3
            frames[c, i, 1] = n[a] * frames[c, b, 0] - n[b] * frames[c, a, 0]


def frames_on(normals: FloatArray) -> FloatArray:
    """Return the frames (..., 3, 3) of unit normals (..., 3), see `surface_frames`."""
    flat = np.ascontiguousarray(normals, dtype=np.float64).reshape(-1, 3)
    frames = np.empty((len(flat), 3, 3))
    surface_frames(flat, frames)
    return frames.reshape(*np.shape(normals), 3)
