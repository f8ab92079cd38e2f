"""The kernel of `can_stand` for point contacts with exact cones and no bounds."""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.base.numerics.vectors import cross
from surefoot.mechanics.statics.margin import LEAST_MU, most_margin
from surefoot.mechanics.statics.row_blocks import IN_ONE


@kernel
def stand(
    positions: FloatArray, rotations: FloatArray, mu: FloatArray, about: FloatArray, load: FloatArray
) -> tuple[int, float, FloatArray, FloatArray, float]:
    """Hold a load with point contacts and exact friction cones, with the most margin.

    Parameters
    ----------
    positions, rotations, mu
        (n, 3) [m], (n, 3, 3) rotation_world_contact, (n,).
    about
        (3,) the point that moments refer to [m].
    load
        (6,) [force; moment] that the contacts must give together, world axes.

    Returns
    -------
    tuple[int, float, FloatArray, FloatArray, float]
        Outcome, margin [N], forces (3 n,) in contact frames [N], y (6,) with y.(A e) = 1, so that
        y.load >= margin, equal at the optimum, and the reach of y as a proof [N] (`proof_reach`).
    """
    n = mu.size
    A, e, w = np.empty((6, 3 * n)), np.zeros(3 * n), np.empty(6)
    length = spread(positions, about)
    for i in range(n):
        _columns(positions[i], rotations[i], mu[i], about, length, A, 3 * i)
        e[3 * i] = axis_scale(mu[i])
    # Forces in loads, moments in loads times the contacts' spread: margins and tolerances then have no unit,
    # and both kinds of rows are of size one.
    scale = load_scale(load, length)
    for k in range(3):
        w[k], w[k + 3] = load[k] / scale, load[k + 3] / (scale * length)
    outcome, t, x, y, reach = most_margin(A, e, w, n, IN_ONE)
    for i in range(n):
        # Back from (f_z, f_x / mu, f_y / mu).
        height = x[3 * i] * scale
        x[3 * i], x[3 * i + 1] = mu[i] * x[3 * i + 1] * scale, mu[i] * x[3 * i + 2] * scale
        x[3 * i + 2] = height
    for k in range(3):
        y[k + 3] /= length
    return outcome, t * scale, x, y, reach * scale


@inline_kernel
def axis_scale(mu: float) -> float:
    """Return how far [-] the axis must move for a distance of one to the cone's border (1: frictionless)."""
    return math.sqrt(1.0 + mu * mu) / max(mu, LEAST_MU) if mu > 0.0 else 1.0


@inline_kernel
def spread(positions: FloatArray, about: FloatArray) -> float:
    """Return the root mean square distance of places (n, 3) from a point (3,) [m]; 1 where all are there."""
    s = 0.0
    for i in range(positions.shape[0]):
        for k in range(3):
            s += (positions[i, k] - about[k]) ** 2
    s = math.sqrt(s / max(1, positions.shape[0]))
    return s if s > 0.0 else 1.0


@inline_kernel
def load_scale(load: FloatArray, length: float) -> float:
    """Return the size of a load (6,) as a force [N], its moments over `length` [m]; 1 for no load at all."""
    s = 0.0
    for k in range(3):
        s += load[k] ** 2 + (load[k + 3] / length) ** 2
    return math.sqrt(s) if s > 0.0 else 1.0


@inline_kernel
def _columns(
    position: FloatArray, R: FloatArray, mu: float, about: FloatArray, length: float, A: FloatArray, at: int
) -> None:
    """Write the three wrench columns of one contact: normal, and mu times each tangent."""
    arm = (
        (position[0] - about[0]) / length,
        (position[1] - about[1]) / length,
        (position[2] - about[2]) / length,
    )
    for k in range(3):
        axis, factor = (2, 1.0) if k == 0 else (k - 1, mu)
        f = factor * R[0, axis], factor * R[1, axis], factor * R[2, axis]
        A[0, at + k], A[1, at + k], A[2, at + k] = f
        A[3, at + k], A[4, at + k], A[5, at + k] = cross(arm, f)
