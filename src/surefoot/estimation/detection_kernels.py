"""The arithmetic of contact detection: one step of the momentum observer, and the feet's forces it means."""

from __future__ import annotations

import math

import numpy as np

from surefoot.arrays import BoolArray, FloatArray
from surefoot.kernels import inline_kernel, kernel
from surefoot.numerics.cholesky import cholesky, solve_lower, solve_upper
from surefoot.numerics.points import point_velocity

LEAST_HEIGHT, LEAST_SPEED, MOST_FORCE = -3.0, -4.0, 5.0
"""Bounds of what height, speed and force may say: ground may be elsewhere, readings go wrong."""


@kernel
def observe_momentum(
    M: FloatArray, C: FloatArray, gravity: FloatArray, v: FloatArray, keep: float, dt: float, known: bool,
    momentum: FloatArray, rate: FloatArray, residual: FloatArray,
) -> None:  # fmt: skip
    """Move the observer on by dt [s]: residual [N, N m] follows Jᵀ f, what `rate` leaves of ṗ.

    M (nv, nv) has its upper triangle only; v is (nv,) [m/s, rad/s]. Over one step ṗ - rate = Jᵀ f is
    constant, so that r' = K (Jᵀ f - r) is solved exactly with `keep` = exp(-K dt). `momentum` and `rate`
    (without torques) become those of now; they are not `known` at the first step.
    """
    n = v.shape[0]
    for i in range(n):
        p = r = 0.0
        for j in range(n):
            p += (M[i, j] if j >= i else M[j, i]) * v[j]
            r += C[j, i] * v[j]
        if known:
            seen = (p - momentum[i]) / dt - rate[i]
            residual[i] = keep * residual[i] + (1.0 - keep) * seen
        momentum[i], rate[i] = p, r - gravity[i]


@kernel
def foot_forces(
    twists: FloatArray, support: BoolArray, points: FloatArray, flat: BoolArray, residual: FloatArray,
    v: FloatArray, damping: float, forces: FloatArray, velocities: FloatArray,
) -> None:  # fmt: skip
    """Fill forces (n, 3) [N] that the legs' rows of a residual (nv,) mean, and velocities (n, 3) [m/s].

    The least squares f of Jᵀ f = residual in a leg's joints, where levers are short damped by `damping` times
    the root of their sum of squares; a flat foot takes a moment as well. `twists` (6, nv), `support` (n, nv),
    points (n, 3) and answers in world axes.
    """
    nv = twists.shape[1]
    A, S, f = np.empty((6, nv)), np.empty((6, 6)), np.empty(6)
    for k in range(points.shape[0]):
        x, y, z = points[k, 0], points[k, 1], points[k, 2]
        rows = 6 if flat[k] else 3
        velocities[k, 0] = velocities[k, 1] = velocities[k, 2] = 0.0
        count = 0
        f[:] = 0.0
        for j in range(nv):
            if not support[k, j]:
                continue
            column = point_velocity(twists, j, x, y, z)
            for r in range(3):
                velocities[k, r] += column[r] * v[j]
            if j >= 6:
                for r in range(rows):
                    A[r, count] = column[r] if r < 3 else twists[r, j]
                    f[r] += A[r, count] * residual[j]
                count += 1
        trace = 0.0
        for r in range(rows):
            for s in range(rows):
                total = 0.0
                for j in range(count):
                    total += A[r, j] * A[s, j]
                S[r, s] = total
            trace += S[r, r]
        for r in range(rows):
            S[r, r] += damping * damping * trace
        solved = cholesky(S[:rows, :rows])
        if solved:
            solve_lower(S[:rows, :rows], f[:rows])
            solve_upper(S[:rows, :rows], f[:rows])
        for r in range(3):
            forces[k, r] = f[r] if solved else 0.0


@inline_kernel
def _ratio(x: float, narrow: float, wide: float) -> float:
    """Return log of a normal density of deviation `narrow` at x over that of `wide`."""
    return math.log(wide / narrow) - 0.5 * x * x * (1.0 / (narrow * narrow) - 1.0 / (wide * wide))


@kernel
def contact_odds(
    forces: FloatArray, velocities: FloatArray, up: FloatArray, gaps: FloatArray, prior: FloatArray,
    deviations: FloatArray, scales: FloatArray, contact: BoolArray, odds: FloatArray,
) -> None:  # fmt: skip
    """Fill odds (n,) of contact and move contact (n,) on.

    `forces`, `velocities`, `up` (n, 3) [N], [m/s], [-]; `gaps` (n,) [m]; `prior` (n,) odds by the plan. Odds
    are natural logarithms. `deviations` (n,) are those of the forces [N]; `scales` (6,) the largest usual
    force [N], deviation of gaps and clearance [m], deviations of speeds of feet that stand and swing [m/s],
    hysteresis.
    """
    heavy, gap, clearance, still, swinging, hold = scales
    root = math.sqrt(2.0 * math.pi)
    for k in range(gaps.shape[0]):
        f = v = 0.0
        for r in range(3):
            f += forces[k, r] * up[k, r]
            v += velocities[k, r] * up[k, r]
        s = deviations[k]
        # a uniform density over [0, heavy] against a normal one about 0; a pull says no more than no force
        pushed = math.log(root * s / heavy) + 0.5 * max(f, 0.0) ** 2 / (s * s)
        near = math.log(clearance / (root * gap)) - 0.5 * (gaps[k] / gap) ** 2
        stopped = _ratio(v, still, swinging)
        odds[k] = prior[k] + min(pushed, MOST_FORCE) + max(near, LEAST_HEIGHT) + max(stopped, LEAST_SPEED)
        contact[k] = odds[k] > (-hold if contact[k] else hold)
