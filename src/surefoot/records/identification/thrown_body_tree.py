"""Where a jointed body is, and its equations of motion; see `falling` for coordinates and equation."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, IntArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.base.numerics.cholesky import cholesky, solve_lower, solve_upper
from surefoot.base.numerics.rotations import rotation_about, rotation_of


class FallingBody(NamedTuple):
    """A tree of n links with k spheres; link 0 is free, the others hang on the joint of the same index.

    Attributes
    ----------
    parents
        (n,) link that carries each, -1 for the first.
    turns, places
        (n, 3, 3) and (n, 3) of each joint in its parent's axes [m].
    axes, sliding
        (n, 3) of each joint, and (n,) whether it slides along it.
    masses, centres, inertias
        (n,) [kg], (n, 3) [m] and (n, 3, 3) about the centre of mass [kg m²], in the link's axes.
    friction, damping
        (n,) of each joint [N m], [N m s].
    links, points, radii
        (k,) link, (k, 3) place in its axes and (k,) radius of each sphere [m].
    """

    parents: IntArray
    turns: FloatArray
    places: FloatArray
    axes: FloatArray
    sliding: BoolArray
    masses: FloatArray
    centres: FloatArray
    inertias: FloatArray
    friction: FloatArray
    damping: FloatArray
    links: IntArray
    points: FloatArray
    radii: FloatArray


class Placed(NamedTuple):
    """Work arrays: where a body is, and its equations of motion there.

    `R` (n, 3, 3), `p` (n, 3), `a` (n, 3) are the links' axes, origins and joint axes; `x` (k, 3) the lowest
    points of the spheres and `gaps` (k,) theirs; `M` (nv, nv) becomes its Cholesky factor; `f` (nv,) forces.
    `w`, `alpha`, `acc` (n, 3) are the links' angular velocities and accelerations at v̇ = 0.
    """

    R: FloatArray
    p: FloatArray
    a: FloatArray
    x: FloatArray
    gaps: FloatArray
    M: FloatArray
    f: FloatArray
    w: FloatArray
    alpha: FloatArray
    acc: FloatArray
    Jc: FloatArray
    Jw: FloatArray


@kernel
def work_arrays(body: FallingBody) -> Placed:
    """Return arrays for one thread."""
    n, k = body.masses.size, body.radii.size
    nv = 5 + n
    return Placed(
        np.zeros((n, 3, 3)), np.zeros((n, 3)), np.zeros((n, 3)), np.zeros((k, 3)), np.zeros(k),
        np.zeros((nv, nv)), np.zeros(nv), np.zeros((n, 3)), np.zeros((n, 3)), np.zeros((n, 3)),
        np.zeros((3, nv)), np.zeros((3, nv)),
    )  # fmt: skip


@inline_kernel
def _cross(a: FloatArray, b: FloatArray, out: FloatArray) -> None:
    """Add a x b to out (3,)."""
    out[0] += a[1] * b[2] - a[2] * b[1]
    out[1] += a[2] * b[0] - a[0] * b[2]
    out[2] += a[0] * b[1] - a[1] * b[0]


@inline_kernel
def _turn(R: FloatArray, x: FloatArray, out: FloatArray) -> None:
    """Fill out (3,) with R x: for so little a call of BLAS costs more than the product."""
    for k in range(3):
        out[k] = R[k, 0] * x[0] + R[k, 1] * x[1] + R[k, 2] * x[2]


@inline_kernel
def _product(A: FloatArray, B: FloatArray, out: FloatArray) -> None:
    """Fill out (3, 3) with A B."""
    for i in range(3):
        for j in range(3):
            out[i, j] = A[i, 0] * B[0, j] + A[i, 1] * B[1, j] + A[i, 2] * B[2, j]


@kernel
def place(body: FallingBody, q: FloatArray, at: Placed) -> None:
    """Fill R, p, a, x and gaps at q (7 + joints,): place, quaternion (x, y, z, w), joints."""
    rotation_of(q, at.R[0])
    for k in range(3):
        at.p[0, k] = q[k]
    turn, rest = np.empty((3, 3)), np.empty((3, 3))
    for i in range(1, body.masses.size):
        h, axis, angle = body.parents[i], body.axes[i], q[6 + i]
        # the joint's axes at rest, and its own axis, in the plane's axes
        _product(at.R[h], body.turns[i], rest)
        _turn(rest, axis, at.a[i])
        _turn(at.R[h], body.places[i], at.p[i])
        for k in range(3):
            at.p[i, k] += at.p[h, k] + (angle * at.a[i, k] if body.sliding[i] else 0.0)
        if body.sliding[i]:
            at.R[i] = rest
            continue
        rotation_about(axis, math.cos(angle), math.sin(angle), turn)
        _product(rest, turn, at.R[i])
    for k in range(body.radii.size):
        i = body.links[k]
        _turn(at.R[i], body.points[k], at.x[k])
        for r in range(3):
            at.x[k, r] += at.p[i, r]
        at.x[k, 2] -= body.radii[k]
        at.gaps[k] = at.x[k, 2]


@inline_kernel
def point_rows(body: FallingBody, at: Placed, link: int, x: FloatArray, J: FloatArray, W: FloatArray) -> None:
    """Fill the maps J, W (3, nv) from v to the velocity of a point x (3,) of a link, and to its turning."""
    J[:], W[:] = 0.0, 0.0
    for k in range(3):
        J[k, k] = W[k, 3 + k] = 1.0
        i, j = (k + 1) % 3, (k + 2) % 3  # e_k x r
        J[j, 3 + k] = x[i] - at.p[0, i]
        J[i, 3 + k] = at.p[0, j] - x[j]
    while link > 0:
        # Joints between the link and the free one: a slide moves the point along its axis, a hinge by a x (x
        # - p).
        a, c = at.a[link], 5 + link
        for k in range(3):
            i, j = (k + 1) % 3, (k + 2) % 3
            if body.sliding[link]:
                J[k, c] = a[k]
            else:
                J[k, c] = a[i] * (x[j] - at.p[link, j]) - a[j] * (x[i] - at.p[link, i])
                W[k, c] = a[k]
        link = body.parents[link]


@kernel
def dynamics(body: FallingBody, at: Placed, v: FloatArray, gravity: FloatArray) -> None:
    """Fill the Cholesky factor of M and the forces f (nv,) under gravity (3,) at v (nv,)."""
    nv = v.size
    at.M[:], at.f[:] = 0.0, 0.0
    force, arm, centre = np.empty(3), np.empty(3), np.empty(3)
    moment, spin, inward = np.empty(3), np.empty(3), np.empty(3)
    inertia, half, turned = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, nv))
    for i in range(body.masses.size):
        # angular velocity, and the accelerations at v̇ = 0
        h = body.parents[i]
        if i == 0:
            at.w[0] = v[3:6]
            at.alpha[0], at.acc[0] = 0.0, 0.0
        else:
            for k in range(3):
                # From the parent outwards (recursive Newton-Euler, its kinematic half): origin, α and a move
                # as a point of the parent does, plus the joint's rate r along its axis u, which adds ω × r u
                # to α for a hinge and Coriolis' 2 ω × r u to a for a slide.
                arm[k], inward[k] = at.p[i, k] - at.p[h, k], 0.0
                at.w[i, k], at.alpha[i, k], at.acc[i, k] = at.w[h, k], at.alpha[h, k], at.acc[h, k]
            _cross(at.w[h], arm, inward)
            _cross(at.w[h], inward, at.acc[i])
            _cross(at.alpha[h], arm, at.acc[i])
            for k in range(3):
                inward[k] = (2.0 if body.sliding[i] else 1.0) * v[5 + i] * at.a[i, k]
            if body.sliding[i]:
                _cross(at.w[h], inward, at.acc[i])
            else:
                _cross(at.w[h], inward, at.alpha[i])
                for k in range(3):
                    at.w[i, k] += inward[k]
        _turn(at.R[i], body.centres[i], arm)
        for k in range(3):
            centre[k], force[k], inward[k] = at.p[i, k] + arm[k], gravity[k] - at.acc[i, k], 0.0
        # Newton at the centre of mass: g - a - α × arm - ω × (ω × arm), by products turned round to add.
        _cross(arm, at.alpha[i], force)
        _cross(at.w[i], arm, inward)
        _cross(inward, at.w[i], force)
        _product(at.R[i], body.inertias[i], half)
        _product(half, at.R[i].T, inertia)
        # Euler about it: -(I α + ω × I ω).
        _turn(inertia, at.w[i], spin)
        _turn(inertia, at.alpha[i], moment)
        for k in range(3):
            moment[k] = -moment[k]
        _cross(spin, at.w[i], moment)
        point_rows(body, at, i, centre, at.Jc, at.Jw)
        for k in range(3):
            for c in range(nv):
                turned[k, c] = 0.0
                for r in range(3):
                    turned[k, c] += inertia[k, r] * at.Jw[r, c]
        m = body.masses[i]
        for r in range(nv):
            for k in range(3):
                at.f[r] += m * at.Jc[k, r] * force[k] + at.Jw[k, r] * moment[k]
                # Jᵀ m J + Wᵀ I W, the lower triangle alone: Cholesky reads no more.
                for c in range(r + 1):
                    at.M[r, c] += m * at.Jc[k, r] * at.Jc[k, c] + at.Jw[k, r] * turned[k, c]
    if not cholesky(at.M):  # a state that went too far: lost, and seen to be
        at.M[:] = np.nan


@inline_kernel
def solve_mass(L: FloatArray, x: FloatArray) -> None:
    """Replace x (nv,) by M⁻¹ x."""
    solve_lower(L, x)
    solve_upper(L, x)


@kernel
def sphere_places(body: FallingBody, poses: FloatArray) -> FloatArray:
    """Return the lowest points (N, k, 3) of the spheres at (N, nq) poses [m]."""
    at, out = work_arrays(body), np.empty((poses.shape[0], body.radii.size, 3))
    for n in range(poses.shape[0]):
        place(body, poses[n], at)
        out[n] = at.x
    return out
