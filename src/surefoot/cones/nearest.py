"""The nearest point of a cone that is given by rays: non-negative least squares by SciPy, and checked.

SciPy's `nnls` (seen with 1.17.1) can stop at a wrong point where x is on the cone's boundary, which is where
projections end. An answer that is not optimal is asked for again, of `lsq_linear`, at ten times the time.
"""

from __future__ import annotations

from contextlib import suppress

import numpy as np

from surefoot.arrays import FloatArray

WRONG = 1e-10
"""Share of x that may be left along a ray: the nearest point leaves none."""


def nearest_in_cone(rays: FloatArray, points: FloatArray) -> FloatArray:
    """Return the nearest points of cone(rays) to (n, d) points; rays (r, d) of any length, zeros too."""
    from scipy.optimize import lsq_linear, nnls

    size = np.sqrt(np.einsum("ij,ij->i", rays, rays))
    unit = rays[size > 0.0] / size[size > 0.0, None]
    out = np.zeros(points.shape)
    for k, x in enumerate(points if len(unit) else ()):
        with suppress(RuntimeError):  # out of iterations
            out[k] = nnls(unit.T, x)[0] @ unit
        if (unit @ (x - out[k])).max() > WRONG * np.linalg.norm(x):
            out[k] = lsq_linear(unit.T, x, (0.0, np.inf), method="bvls", tol=1e-15).x @ unit
    return out
