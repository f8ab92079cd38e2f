"""How contact velocities, generalised contact forces and gaps turn with the configuration, compiled.

Columns of the spatial Jacobian are twists X_j = [linear at the world's origin; angular] in world axes.
Turning joint k takes along every column behind it: ∂X_j/∂q_k = X_k × X_j where the joint of k carries that of
j, or is it. A contact is a point of its body, a radius below a sphere's centre along the ground's normal.

Source: R. Featherstone, Rigid Body Dynamics Algorithms, Springer 2008, chapters 2 and 4.
"""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, IntArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.base.numerics.vectors import Three, cross, times


@inline_kernel
def _three(x: FloatArray, i: int, j: int) -> Three:
    return x[i, j], x[i, j + 1], x[i, j + 2]


@inline_kernel
def _plus(a: Three, b: Three) -> Three:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@inline_kernel
def _centre(c: int, positions: FloatArray, radii: FloatArray, frames: FloatArray) -> Three:
    """Return a sphere's centre."""
    r = radii[c]
    return (
        positions[c, 0] + r * frames[c, 0, 2],
        positions[c, 1] + r * frames[c, 1, 2],
        positions[c, 2] + r * frames[c, 2, 2],
    )


@inline_kernel
def _turning(turns: FloatArray, c: int) -> bool:
    """Return whether a contact's frame turns with its place."""
    # Over a plane the frames are constant: the products with their rates are left out.
    found = False
    for d in range(2):
        for i in range(3):
            for a in range(3):
                found = found or turns[d, c, i, a] != 0.0
    return found


@inline_kernel
def _turn(turns: FloatArray, c: int, centre: Three, radius: float, turn: FloatArray) -> Three:
    """Fill the rate (3, 3) of a contact frame whose sphere's centre moves; return the contact point's."""
    for i in range(3):
        for a in range(3):
            turn[i, a] = turns[0, c, i, a] * centre[0] + turns[1, c, i, a] * centre[1]
    x, y, z = centre
    return x - radius * turn[0, 2], y - radius * turn[1, 2], z - radius * turn[2, 2]


@kernel
def velocity_rates(
    twists: FloatArray, first: IntArray, support: BoolArray, positions: FloatArray, radii: FloatArray,
    frames: FloatArray, turns: FloatArray, v: FloatArray,
) -> FloatArray:  # fmt: skip
    """Return the derivative (3p, nv) of the contact velocities J(q) v, in contact axes, at fixed v (nv,).

    Parameters
    ----------
    twists
        (nv, 6) X_j [m/s, rad/s per unit of v_j], linear at the world's origin.
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
    behind, turn = np.empty((n + 1, 6)), np.zeros((3, 3))
    for c in range(p):
        for i in range(6):
            behind[n, i] = 0.0  # twist of the body that joints from j on make
        # Σ X_i v_i over the joints from j on: all that a motion of joint j carries along
        for j in range(n - 1, -1, -1):
            share = v[j] if support[c, j] else 0.0
            for i in range(6):
                behind[j, i] = behind[j + 1, i] + share * twists[j, i]
        place, at, turning = _three(positions, c, 0), _centre(c, positions, radii, frames), _turning(turns, c)
        spin = _three(behind, 0, 3)
        whole = _plus(_three(behind, 0, 0), cross(spin, place))
        for k in range(n):
            if not support[c, k]:
                continue
            angular, f = _three(twists, k, 3), first[k]
            # velocity of the contact point with joint k
            # Of the sphere's centre first: the contact lies below it along the ground's normal, which on
            # curved ground turns as the centre moves.
            point = _plus(_three(twists, k, 0), cross(angular, at))
            if turning:
                point = _turn(turns, c, point, radii[c], turn)
            # ∂X_j/∂q_k = X_k × X_j for the joints that k carries
            turned = cross(angular, _three(behind, f, 3))
            # Linear part of X_k × X at the origin, then moved to the contact: the twist's own change at a
            # fixed place, and the velocity field's change along the way that the contact point goes.
            rate = cross(angular, _three(behind, f, 0))
            rate = _plus(rate, cross(_three(twists, k, 0), _three(behind, f, 3)))
            rate = _plus(_plus(rate, cross(turned, place)), cross(spin, point))
            for a in range(3):
                # Rᵀ δu + δRᵀ u, in contact axes.
                total = frames[c, 0, a] * rate[0]
                if turning:
                    total += turn[0, a] * whole[0]
                    total += frames[c, 1, a] * rate[1] + turn[1, a] * whole[1]
                    total += frames[c, 2, a] * rate[2] + turn[2, a] * whole[2]
                else:
                    total += frames[c, 1, a] * rate[1]
                    total += frames[c, 2, a] * rate[2]
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
    out, turn = np.zeros((n, n)), np.zeros((3, 3))
    for c in range(p):
        f = _three(impulses, c, 0)
        if f[0] == 0.0 and f[1] == 0.0 and f[2] == 0.0:
            continue
        force = times(frames[c], f)
        place, at, turning = _three(positions, c, 0), _centre(c, positions, radii, frames), _turning(turns, c)
        moment = cross(place, force)
        for k in range(n):
            if not support[c, k]:
                continue
            linear, angular = _three(twists, k, 0), _three(twists, k, 3)
            point = _plus(linear, cross(angular, at))
            change = 0.0, 0.0, 0.0
            if turning:
                point = _turn(turns, c, point, radii[c], turn)
                change = times(turn, f)
            # The wrench about the world's origin [F; x × F] changes as the contact point moves, and as F
            # turns with the frame, in which λ is held.
            swing = cross(point, force)
            if turning:
                swing = _plus(swing, cross(place, change))
            # (X_k × X_j)·F = -X_j·(X_k ×* F) for the joints that k carries
            bent, twisted = cross(angular, force), _plus(cross(angular, moment), cross(linear, force))
            for j in range(n):
                if not support[c, j]:
                    continue
                x, y, z = _three(twists, j, 0)
                a, b, d = _three(twists, j, 3)
                total = x * change[0] + a * swing[0] + (y * change[1] + b * swing[1])
                total += z * change[2] + d * swing[2]
                if first[k] <= j:
                    total -= x * bent[0] + a * twisted[0]
                    total -= y * bent[1] + b * twisted[1]
                    total -= z * bent[2] + d * twisted[2]
                out[j, k] += total
    return out


@kernel
def centre_rates(
    twists: FloatArray, support: BoolArray, positions: FloatArray, radii: FloatArray, frames: FloatArray
) -> FloatArray:
    """Return the derivative (p, 3, nv) of the spheres' centres [m], world axes."""
    p, n = support.shape
    out = np.zeros((p, 3, n))
    for c in range(p):
        at = _centre(c, positions, radii, frames)
        for k in range(n):
            if support[c, k]:
                # Twists are about the world's origin: v + ω x c is what joint k moves the centre by.
                rate = _plus(_three(twists, k, 0), cross(_three(twists, k, 3), at))
                out[c, 0, k], out[c, 1, k], out[c, 2, k] = rate
    return out
