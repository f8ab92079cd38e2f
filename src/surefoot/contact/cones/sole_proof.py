"""What few wrenches want beside a sole's compiled questions: more digits, and proofs that are checked."""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.contact.cones.sole_answers import SoleVerdict

SEARCHES = 100
"""Newton steps at most for a friction coefficient [-]: 4 to 8 are usual, one for each halving at worst."""
FINEST = 1e-12
"""Relative change of a friction coefficient at which its search ends [-]: the bounds are within 1e-13."""

Given = tuple[FloatArray, FloatArray, FloatArray, FloatArray]
"""What every kernel is given of a sole: numbers, table, start and edges, see `sole_kernels`."""


class FlatSole(Protocol):
    """What is known here of a `Sole`."""

    corners: FloatArray
    mu: float
    torsional_radius: float

    @property
    def centre(self) -> FloatArray:
        """(2,) mean of the corners [m]."""

    @property
    def radius(self) -> float:
        """Largest distance of a corner from the centre [m]."""


def count_moments(sole: FlatSole, w: FloatArray) -> FloatArray:
    """Return a wrench (6,) with moments about a sole's centre and over its radius [N]."""
    return np.concatenate([w[:3], (w[3:] - np.cross([*sole.centre, 0.0], w[:3])) / sole.radius])


def resistance(sole: FlatSole, d: FloatArray) -> FloatArray:
    """Return the largest product of twists (n, 6) with what a newton at each corner gives: (n, k)."""
    x, y = sole.corners.T
    normal = d[:, 2:3] + d[:, 3:4] * y - d[:, 4:5] * x
    slide = np.hypot(d[:, 0:1] - d[:, 5:6] * y, d[:, 1:2] + d[:, 5:6] * x)
    return np.asarray(normal + sole.mu * np.hypot(slide, sole.torsional_radius * d[:, 5:6]))


def measure_in_digits(
    sole: FlatSole, given: Given, w: FloatArray, needs: FloatArray, shares: FloatArray
) -> None:
    """Fill in needs (n,) and shares (n, 3) of finite wrenches (n, 6) where they are NaN, see `measure`."""
    for row in np.flatnonzero(np.isnan(needs) & np.isfinite(w).all(axis=1)):
        needs[row], _, twist = _certify(given, w[row])
        counted = count_moments(sole, w[row])
        turn = twist[3:] * sole.radius
        shares[row] = -twist[:2] @ counted[:2], -turn[:2] @ counted[3:5], -turn[2] * counted[5]


def hold_in_digits(sole: FlatSole, given: Given, w: FloatArray, tol: float, unsure: BoolArray) -> BoolArray:
    """Tell whether the wrenches that are unsure (n,) of (n, 6) are in a sole's cone, see `Sole.contains`."""
    return np.array(
        [
            _certify(given, one)[0]
            <= one[2] + tol * max(1.0, float(np.linalg.norm(count_moments(sole, one))))
            for one in w[unsure]
        ]
    )


def frictions_in_digits(sole: FlatSole, given: Given, w: FloatArray, found: FloatArray) -> None:
    """Settle the least friction coefficients (n,) of wrenches (n, 6) where they have a minus: too small."""
    for row in np.flatnonzero(found < 0.0):
        found[row] = _least_friction(sole, given, w[row], -1.0 / found[row])


def _least_friction(sole: FlatSole, given: Given, w: FloatArray, q: float) -> float:
    """Return the least friction coefficient [-] that holds a wrench (6,); q [-] is not less than one over it.

    Newton's method on N(q) = f_z, as in `sole_kernels.frictions`: from above, on a convex function.
    """
    counted = count_moments(sole, w)
    for _ in range(SEARCHES):
        need, _, twist = _certify(given, w, 1.0 / q)
        slope = -(twist[:2] @ counted[:2] + twist[5] * sole.radius * counted[5]) / q
        over = need - float(w[2])
        if not (slope > 0.0 and over > 0.0):
            break
        less = q - over / slope
        if not less > 0.0:
            return math.inf
        done = q - less <= FINEST * q
        q = less
        if done:
            break
    return 1.0 / q


def _certify(given: Given, w: FloatArray, mu: float | None = None) -> tuple[float, FloatArray, FloatArray]:
    """Return the least normal force [N] of a wrench (6,), corner forces and a velocity, see `certify`."""
    from surefoot.contact.cones.sole_digits import certify_in_digits
    from surefoot.contact.cones.sole_kernels import MU

    numbers, table, start, _ = given
    if mu is not None:
        numbers = numbers.copy()
        numbers[MU] = mu
    forces, twist = np.empty((len(table), 4)), np.empty(6)
    return certify_in_digits(numbers, table, start, w, forces, twist), forces, twist


def verdict_on(sole: FlatSole, given: Given, w: FloatArray, tol: float) -> SoleVerdict:
    """Return the verdict on a finite wrench (6,), see `Sole.verdict`."""
    from surefoot.contact.cones.sole_kernels import certify

    forces, twist = np.empty((len(sole.corners), 4)), np.empty(6)
    need = certify(*given, w, forces, twist)
    verdict = _check_proofs(sole, w, tol, need, forces, twist)
    if verdict.holds is None and sole.mu > 0.0 and w.any():
        verdict = _check_proofs(sole, w, tol, *_certify(given, w))
    return verdict


def _check_proofs(
    sole: FlatSole, w: FloatArray, tol: float, need: float, forces: FloatArray, twist: FloatArray
) -> SoleVerdict:
    """Return what corner forces (k, 4) and a velocity (6,) about the centre prove of a wrench (6,)."""
    margin = float(w[2] - need)
    slack = tol * max(1.0, float(np.linalg.norm(count_moments(sole, w))))
    if margin >= -slack and math.isfinite(need):
        forces[:, 2] += max(margin, 0.0) / len(forces)
        left = _sum_of(sole, forces) - w
        pads = forces[:, 3] / sole.torsional_radius if sole.torsional_radius > 0.0 else forces[:, 3]
        friction = np.hypot(np.hypot(forces[:, 0], forces[:, 1]), pads)
        short = (friction - sole.mu * forces[:, 2]).sum(where=friction > sole.mu * forces[:, 2])
        if np.linalg.norm(count_moments(sole, left)) <= 2.0 * slack and short <= sole.mu * slack + slack:
            return SoleVerdict(True, margin, forces[:, :3], forces[:, 3])
        return SoleVerdict(None, margin)
    if not math.isfinite(need):
        twist = _sliding(sole, w)
    # moments about the centre to moments about the frame's origin
    twist[:3] -= np.cross(twist[3:], [*sole.centre, 0.0])
    over = float(resistance(sole, -twist[None]).max())
    if over <= 1e-12 * max(1.0, float(np.abs(twist).max())) and float(twist @ w) < 0.0:
        return SoleVerdict(False, margin, twist=-twist)
    return SoleVerdict(None, margin)


def _sliding(sole: FlatSole, w: FloatArray) -> FloatArray:
    """Return minus a twist about the centre that feeds on w (6,) and that no normal force resists."""
    counted = count_moments(sole, w)
    twist = np.zeros(6)
    twist[[0, 1]], twist[5] = -counted[[0, 1]], -counted[5] / sole.radius
    return twist


def _sum_of(sole: FlatSole, forces: FloatArray) -> FloatArray:
    """Return the wrench (6,) of corner forces and pad moments (k, 4)."""
    arms = np.column_stack([sole.corners, np.zeros(len(sole.corners))])
    moment = np.cross(arms, forces[:, :3]).sum(axis=0)
    moment[2] += forces[:, 3].sum()
    return np.concatenate([forces[:, :3].sum(axis=0), moment])
