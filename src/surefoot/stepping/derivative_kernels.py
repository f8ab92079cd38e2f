"""How contact velocities, generalised contact forces and gaps turn with the configuration, compiled.

Columns of the spatial Jacobian are twists X_j = [linear at the world's origin; angular] in world axes.
Turning joint k takes along every column behind it: ∂X_j/∂q_k = X_k × X_j where the joint of k carries that of
j, or is it. A contact is a point of its body, a radius below a sphere's centre along the ground's normal.

Source: R. Featherstone, Rigid Body Dynamics Algorithms, Springer 2008, chapters 2 and 4.
"""

from __future__ import annotations

import numpy as np

from surefoot.arrays import BoolArray, FloatArray, IntArray
from surefoot.kernels import inline_kernel, kernel


@inline_kernel
def _cross(a: FloatArray, b: FloatArray, out: FloatArray) -> None:
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        out[i] += a[j] * b[k] - a[k] * b[j]


@inline_kernel
def _moved(
    c: int, X: FloatArray, positions: FloatArray, radii: FloatArray, frames: FloatArray, turns: FloatArray,
    centre: FloatArray, point: FloatArray, turn: FloatArray,
) -> None:  # fmt: skip
    """Fill the rates (3,) of a sphere's centre and of its contact point, and (3, 3) of the contact frame."""
    at = np.empty(3)
    for i in range(3):
        at[i], centre[i] = positions[c, i] + radii[c] * frames[c, i, 2], X[i]
    _cross(X[3:], at, centre)
    for i in range(3):
        for a in range(3):
            turn[i, a] = turns[0, c, i, a] * centre[0] + turns[1, c, i, a] * centre[1]
        point[i] = centre[i] - radii[c] * turn[i, 2]


@kernel
def velocity_rates(
    twists: FloatArray, first: IntArray, support: BoolArray, positions: FloatArray, radii: FloatArray,
    frames: FloatArray, turns: FloatArray, v: FloatArray,
) -> FloatArray:  # fmt: skip
    """Return the derivative (3p, nv) of the contact velocities J(q) v, in contact axes, at fixed v (nv,).

    Parameters
    ----------
    twists
        (nv, 6) X_j.
    first
        (nv,) first velocity of the joint that each belongs to.
    support
        (p, nv) which of them move each contact.
    positions, radii, frames
        (p, 3), (p,) and (p, 3, 3) of the contacts.
    turns
        (2, p, 3, 3) rates of the frames with the centre's place along x and y.
    """
    p, n = support.shape
    out = np.zeros((3 * p, n))
    behind, whole = np.empty((n + 1, 6)), np.empty(3)
    centre, point, turn, rate = np.empty(3), np.empty(3), np.empty((3, 3)), np.empty((2, 3))
    for c in range(p):
        behind[n, :] = 0.0  # twist of the body that joints from j on make
        for j in range(n - 1, -1, -1):
            share = v[j] if support[c, j] else 0.0
            for i in range(6):
                behind[j, i] = behind[j + 1, i] + share * twists[j, i]
        whole[:] = behind[0, :3]
        _cross(behind[0, 3:], positions[c], whole)
        for k in range(n):
            if not support[c, k]:
                continue
            X, W = twists[k], behind[first[k]]
            _moved(c, X, positions, radii, frames, turns, centre, point, turn)
            rate[:, :] = 0.0
            _cross(X[3:], W[3:], rate[1])
            _cross(X[3:], W[:3], rate[0])
            _cross(X[:3], W[3:], rate[0])
            _cross(rate[1], positions[c], rate[0])
            _cross(behind[0, 3:], point, rate[0])
            for a in range(3):
                total = 0.0
                for i in range(3):
                    total += frames[c, i, a] * rate[0, i] + turn[i, a] * whole[i]
                out[3 * c + a, k] = total
    return out


@kernel
def force_rates(
    twists: FloatArray, first: IntArray, support: BoolArray, positions: FloatArray, radii: FloatArray,
    frames: FloatArray, turns: FloatArray, impulses: FloatArray,
) -> FloatArray:  # fmt: skip
    """Return the derivative (nv, nv) of Jᵀ(q) λ at fixed impulses (p, 3) in contact axes.

    Arguments as for `velocity_rates`.
    """
    p, n = support.shape
    out = np.zeros((n, n))
    force, rate, moment = np.empty((2, 3)), np.empty((2, 3)), np.empty(3)
    centre, point, turn = np.empty(3), np.empty(3), np.empty((3, 3))
    for c in range(p):
        if impulses[c, 0] == 0.0 and impulses[c, 1] == 0.0 and impulses[c, 2] == 0.0:
            continue
        for i in range(3):
            force[0, i] = 0.0
            for a in range(3):
                force[0, i] += frames[c, i, a] * impulses[c, a]
        force[1, :] = 0.0
        _cross(positions[c], force[0], force[1])
        for k in range(n):
            if not support[c, k]:
                continue
            X = twists[k]
            _moved(c, X, positions, radii, frames, turns, centre, point, turn)
            rate[:, :] = 0.0
            for i in range(3):
                for a in range(3):
                    rate[0, i] += turn[i, a] * impulses[c, a]
            _cross(point, force[0], rate[1])
            _cross(positions[c], rate[0], rate[1])
            # (X_k × X_j)·F = -X_j·(X_k ×* F) for the joints that k carries
            moment[:] = 0.0
            _cross(X[3:], force[1], moment)
            _cross(X[:3], force[0], moment)
            for j in range(n):
                if not support[c, j]:
                    continue
                total = 0.0
                for i in range(3):
                    total += twists[j, i] * rate[0, i] + twists[j, 3 + i] * rate[1, i]
                if first[k] <= j:
                    for i in range(3):
                        a, b = (i + 1) % 3, (i + 2) % 3
                        turned = X[3 + a] * force[0, b] - X[3 + b] * force[0, a]
                        total -= twists[j, i] * turned + twists[j, 3 + i] * moment[i]
                out[j, k] += total
    return out


@kernel
def centre_rates(
    twists: FloatArray, support: BoolArray, positions: FloatArray, radii: FloatArray, frames: FloatArray
) -> FloatArray:
    """Return the derivative (p, 3, nv) of the spheres' centres, world axes."""
    p, n = support.shape
    out = np.zeros((p, 3, n))
    at, rate = np.empty(3), np.empty(3)
    for c in range(p):
        for i in range(3):
            at[i] = positions[c, i] + radii[c] * frames[c, i, 2]
        for k in range(n):
            if support[c, k]:
                rate[:] = twists[k, :3]
                _cross(twists[k, 3:], at, rate)
                for i in range(3):
                    out[c, i, k] = rate[i]
    return out
