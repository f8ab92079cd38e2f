"""Compiled last pieces of whole-body control: the torques of contact forces, and whether motors give them."""

from __future__ import annotations

import math

import numpy as np

from surefoot.arrays import BoolArray, FloatArray
from surefoot.kernels import kernel


@kernel
def recover(
    rows: FloatArray, forces: FloatArray, offset: FloatArray, gain: FloatArray, M: FloatArray, nle: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the joint torques (joints,) and accelerations (nv,) that go with contact forces.

    Parameters
    ----------
    rows
        (3p, nv) Jacobian of the contact points, rows in contact axes.
    forces
        (p, 3) contact frames [N].
    offset, gain
        Accelerations are offset + gain w for the ground's force w (6,) on the base; see `eliminate`.
    M, nle
        (nv, nv), (nv,) mass matrix and bias forces.
    """
    nv = len(offset)
    ground, a = np.zeros(nv), np.empty(nv)
    for k in range(len(forces)):
        for i in range(3):
            f = forces[k, i]
            if f != 0.0:
                for j in range(nv):
                    ground[j] += rows[3 * k + i, j] * f
    for j in range(nv):
        total = offset[j]
        for i in range(6):
            total += gain[j, i] * ground[i]
        a[j] = total
    torques = np.empty(nv - 6)
    for j in range(6, nv):
        total = nle[j] - ground[j]
        for i in range(nv):
            total += M[j, i] * a[i]
        torques[j - 6] = total
    return torques, a


@kernel
def exceeded(
    torques: FloatArray, middle: FloatArray, half: FloatArray, loose: BoolArray
) -> tuple[float, float, float, bool]:
    """Return by how much (joints,) torques leave the range middle ± half [N m], and whether all are finite.

    The first two are the largest distances from the middle over the half [-] among the joints that no
    contact loads (`loose`) and among the others, at least zero; the third is the largest excess [N m], of
    either sign.
    """
    light = heavy = 0.0
    most, finite = -math.inf, True
    for j in range(len(torques)):
        size = abs(torques[j] - middle[j])
        if not math.isfinite(size):
            finite = False
            continue
        if size > 0.0:
            share = size / half[j]
            if loose[j]:
                light = max(light, share)
            else:
                heavy = max(heavy, share)
        most = max(most, size - half[j])
    return light, heavy, most, finite
