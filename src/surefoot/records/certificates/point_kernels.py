"""Places and speeds of the points that may touch the ground; compiled."""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import kernel


@kernel
def point_centres(turns: FloatArray, origins: FloatArray, body: IntArray, places: FloatArray) -> FloatArray:
    """Return the centres (T, p, 3) of points at (p, 3) places of bodies, world axes [m]."""
    out = np.empty((turns.shape[0], body.shape[0], 3))
    for k in range(out.shape[0]):
        for p in range(body.shape[0]):
            for i in range(3):
                total = origins[k, body[p], i]
                for j in range(3):
                    total += turns[k, body[p], i, j] * places[p, j]
                out[k, p, i] = total
    return out


@kernel
def slide_speeds(
    centres: FloatArray,
    rates: FloatArray,
    body: IntArray,
    radii: FloatArray,
    normals: FloatArray,
    step: float,
) -> FloatArray:
    """Return the velocity (T - 1, p, 3) along the ground of the lowest of spheres between frames [m/s]."""
    out = np.empty((centres.shape[0] - 1, body.shape[0], 3))
    level = normals.shape[0] == 1
    for k in range(out.shape[0]):
        for p in range(body.shape[0]):
            n = normals[0, 0] if level else normals[k, p]
            along = 0.0
            for i in range(3):
                a, b = (i + 1) % 3, (i + 2) % 3
                # the material at -radius n turns with the body
                turned = -radii[p] * (rates[k, body[p], a] * n[b] - rates[k, body[p], b] * n[a])
                out[k, p, i] = (centres[k + 1, p, i] - centres[k, p, i]) / step + turned
                along += out[k, p, i] * n[i]
            for i in range(3):
                out[k, p, i] -= along * n[i]
    return out
