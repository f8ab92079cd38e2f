"""The smallest shift of a centre of mass's path that takes what forces leave: banded least squares."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import spsolve

from surefoot.base.arrays import FloatArray
from surefoot.base.spatial import GRAVITY
from surefoot.records.certificates.window_kernels import Window


def shift_com(
    residual: FloatArray, needed: FloatArray, shifted: FloatArray, mass: float, arm: float, window: Window,
    reach: float,
) -> FloatArray:  # fmt: skip
    """Return further shifts (T, 3) [m] of a path that is shifted already.

    With the contact forces as they are, a shift d leaves of force and moment::

        r_F + m d'',    r_M + d x F

    (d'' in the window's mean, F what the contacts give). Both are minimised over m g and `arm` m g, with
    (|shifted + d| / reach)² beside them.

    Parameters
    ----------
    residual, needed
        (T, 6) wrenches about the centre of mass [N, N m]; zero where nothing is asked.
    shifted
        (T, 3) what was shifted before [m].
    mass, arm
        [kg], [m].
    window
        Over which forces are averaged.
    reach
        Shift that costs as much as the weight [m].
    """
    count, weight = len(residual), mass * GRAVITY
    bend = _bends(count, window) / GRAVITY
    force = (needed[:, :3] - residual[:, :3]) / (weight * arm)
    rows = [sparse.kron(bend, sparse.identity(3)), _products(force), sparse.identity(3 * count) / reach]
    right = [-residual[:, :3] / weight, -residual[:, 3:] / (weight * arm), -shifted / reach]
    A = sparse.vstack(rows).tocsc()
    b = np.concatenate([r.ravel() for r in right])
    return np.asarray(spsolve((A.T @ A).tocsc(), A.T @ b)).reshape(count, 3)


def _bends(count: int, window: Window) -> Any:
    """Return the matrix (T, T) of second derivatives in the mean over a window [1/s²]; zero at the ends."""
    length, mean, reach = window.length, window.mean, window.reach
    out = sparse.lil_matrix((count, count))
    for k in range(reach, count - reach):
        for s in range(mean):
            last, first = k + (length - mean) // 2 + s, k - reach + s
            for at, sign in ((last + 1, 1.0), (last, -1.0), (first + 1, -1.0), (first, 1.0)):
                out[k, at] += sign / (mean * length * window.step**2)
    return out.tocsr()


def _products(force: FloatArray) -> Any:
    """Return the block diagonal matrix of d -> d x F for (T, 3) F."""
    x, y, z = force.T
    zero = np.zeros_like(x)
    blocks = np.array([[zero, z, -y], [-z, zero, x], [y, -x, zero]])
    return sparse.block_diag(list(np.moveaxis(blocks, 2, 0)))
