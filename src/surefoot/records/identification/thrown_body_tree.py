"""Where a jointed body is, and its equations of motion; `thrown_body_step` has coordinates and equation."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, IntArray
from surefoot.base.kernels import borrowed, inline_kernel, kernel
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
    friction, damping, stiffness
        (n,) of each joint [N m], [N m s], and of a spring that holds it at zero [N m/rad]: what a spring
        holds has no dry friction.
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
    stiffness: FloatArray
    links: IntArray
    points: FloatArray
    radii: FloatArray


class Placed(NamedTuple):
    """Work arrays: where a body is, and its equations of motion there.

    `R` (n, 3, 3), `p` (n, 3), `a` (n, 3) are the links' axes, origins and joint axes; `x` (k, 3) the lowest
    points of the spheres and `gaps` (k,) theirs; `M` (nv, nv) becomes its Cholesky factor; `f` (nv,) forces.
    `w`, `u`, `alpha`, `acc` (n, 3) are the links' angular velocities, their origins' velocities, and their
    accelerations at v̇ = 0. `D`, `W` (n, 3) are what unit rates of joints do to the centre of a link, and to
    its turning; `turns` (2, 3, 3) and `vectors` (6, 3) are for what is needed on the way.
    """

    R: FloatArray
    p: FloatArray
    a: FloatArray
    x: FloatArray
    gaps: FloatArray
    M: FloatArray
    f: FloatArray
    w: FloatArray
    u: FloatArray
    alpha: FloatArray
    acc: FloatArray
    D: FloatArray
    W: FloatArray
    turns: FloatArray
    vectors: FloatArray


@kernel
def work_arrays(body: FallingBody) -> Placed:
    """Return arrays for one thread."""
    n, k = body.masses.size, body.radii.size
    nv = 5 + n
    return Placed(
        np.zeros((n, 3, 3)), np.zeros((n, 3)), np.zeros((n, 3)), np.zeros((k, 3)), np.zeros(k),
        np.zeros((nv, nv)), np.zeros(nv), np.zeros((n, 3)), np.zeros((n, 3)), np.zeros((n, 3)),
        np.zeros((n, 3)), np.zeros((n, 3)), np.zeros((n, 3)), np.zeros((2, 3, 3)), np.zeros((6, 3)),
    )  # fmt: skip


@inline_kernel
def borrow_body(body: FallingBody) -> FallingBody:
    """Return a body whose arrays are not counted: a call with a tuple of arrays counts every one of them."""
    return FallingBody(
        borrowed(body.parents), borrowed(body.turns), borrowed(body.places), borrowed(body.axes),
        borrowed(body.sliding), borrowed(body.masses), borrowed(body.centres), borrowed(body.inertias),
        borrowed(body.friction), borrowed(body.damping), borrowed(body.stiffness), borrowed(body.links),
        borrowed(body.points), borrowed(body.radii),
    )  # fmt: skip


@inline_kernel
def borrow_work(at: Placed) -> Placed:
    """Return work arrays that are not counted; whoever owns them must outlive the last use (`keep`)."""
    return Placed(
        borrowed(at.R), borrowed(at.p), borrowed(at.a), borrowed(at.x), borrowed(at.gaps), borrowed(at.M),
        borrowed(at.f), borrowed(at.w), borrowed(at.u), borrowed(at.alpha), borrowed(at.acc), borrowed(at.D),
        borrowed(at.W), borrowed(at.turns), borrowed(at.vectors),
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


@inline_kernel
def place(body: FallingBody, q: FloatArray, at: Placed) -> None:
    """Fill R, p and a at q (7 + joints,): place, quaternion (x, y, z, w), joints."""
    rotation_of(q, at.R[0])
    for k in range(3):
        at.p[0, k] = q[k]
    turn, rest = at.turns[0], at.turns[1]
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


@inline_kernel
def place_spheres(body: FallingBody, at: Placed) -> None:
    """Fill x and gaps where `place` has put the links."""
    for k in range(body.radii.size):
        i = body.links[k]
        _turn(at.R[i], body.points[k], at.x[k])
        for r in range(3):
            at.x[k, r] += at.p[i, r]
        at.x[k, 2] -= body.radii[k]
        at.gaps[k] = at.x[k, 2]


@inline_kernel
def link_velocities(body: FallingBody, at: Placed, v: FloatArray) -> None:
    """Fill w and u, the links' angular velocities and their origins' velocities, at v (nv,)."""
    arm = at.vectors[0]
    for k in range(3):
        at.u[0, k], at.w[0, k] = v[k], v[3 + k]
    for i in range(1, body.masses.size):
        h, rate = body.parents[i], v[5 + i]
        for k in range(3):
            arm[k] = at.p[i, k] - at.p[h, k]
            at.u[i, k], at.w[i, k] = at.u[h, k], at.w[h, k]
        _cross(at.w[h], arm, at.u[i])
        for k in range(3):
            if body.sliding[i]:
                at.u[i, k] += rate * at.a[i, k]
            else:
                at.w[i, k] += rate * at.a[i, k]


@inline_kernel
def climb(body: FallingBody, at: Placed, k: int) -> float:
    """Return how fast [m/s] the lowest point of sphere k rises, by the links' velocities."""
    i = body.links[k]
    x, y = at.x[k, 0] - at.p[i, 0], at.x[k, 1] - at.p[i, 1]
    speed: float = at.u[i, 2] + at.w[i, 0] * y - at.w[i, 1] * x
    return speed


@inline_kernel
def _joint_motion(body: FallingBody, at: Placed, i: int, x: FloatArray, d: FloatArray) -> None:
    """Fill d (3,) with what a unit rate of joint i does to a point x (3,) beyond it: u, or u × (x - p)."""
    a, p = at.a[i], at.p[i]
    for k in range(3):
        j, m = (k + 1) % 3, (k + 2) % 3
        d[k] = a[k] if body.sliding[i] else a[j] * (x[m] - p[m]) - a[m] * (x[j] - p[j])


@inline_kernel
def point_rows(body: FallingBody, at: Placed, link: int, x: FloatArray, J: FloatArray) -> None:
    """Fill the map J (3, nv) from v to the velocity of a point x (3,) of a link."""
    J[:] = 0.0
    d = at.vectors[0]
    for k in range(3):
        J[k, k] = 1.0
        i, j = (k + 1) % 3, (k + 2) % 3  # e_k x r
        J[j, 3 + k] = x[i] - at.p[0, i]
        J[i, 3 + k] = at.p[0, j] - x[j]
    while link > 0:
        _joint_motion(body, at, link, x, d)
        for k in range(3):
            J[k, 5 + link] = d[k]
        link = body.parents[link]


@inline_kernel
def _accelerations(body: FallingBody, at: Placed, v: FloatArray, i: int) -> None:
    """Fill alpha and acc of link i > 0, its accelerations at v̇ = 0, from its parent's.

    The kinematic half of recursive Newton-Euler: origin, α and a move as a point of the parent does, plus the
    joint's rate r along its axis u, which adds ω × r u to α for a hinge and Coriolis' 2 ω × r u to a for a
    slide.
    """
    h, arm, inward = body.parents[i], at.vectors[0], at.vectors[1]
    for k in range(3):
        arm[k], inward[k] = at.p[i, k] - at.p[h, k], 0.0
        at.alpha[i, k], at.acc[i, k] = at.alpha[h, k], at.acc[h, k]
    _cross(at.w[h], arm, inward)
    _cross(at.w[h], inward, at.acc[i])
    _cross(at.alpha[h], arm, at.acc[i])
    for k in range(3):
        inward[k] = (2.0 if body.sliding[i] else 1.0) * v[5 + i] * at.a[i, k]
    if body.sliding[i]:
        _cross(at.w[h], inward, at.acc[i])
    else:
        _cross(at.w[h], inward, at.alpha[i])


@inline_kernel
def _link_forces(body: FallingBody, at: Placed, gravity: FloatArray, i: int) -> None:
    """Fill vectors 2 to 5 with link i's arm of the centre, centre, force and moment, turns 0 with its I."""
    arm, centre, force, moment = at.vectors[2], at.vectors[3], at.vectors[4], at.vectors[5]
    spin, inward, inertia, half = at.vectors[0], at.vectors[1], at.turns[0], at.turns[1]
    _turn(at.R[i], body.centres[i], arm)
    m = body.masses[i]
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
        force[k] *= m
    _cross(spin, at.w[i], moment)


@inline_kernel
def _add_free(at: Placed, m: float) -> None:
    """Add what a link of mass m is to the free joint: m, m [r]×, I + m (r² - r rᵀ), and its forces."""
    r, centre, force, moment, about = at.vectors[2], at.vectors[3], at.vectors[4], at.vectors[5], at.turns[0]
    for k in range(3):
        r[k] = centre[k] - at.p[0, k]
    square = r[0] * r[0] + r[1] * r[1] + r[2] * r[2]
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        at.M[k, k] += m
        at.M[3 + k, j] += m * r[i]  # the row of e_k x r
        at.M[3 + k, i] -= m * r[j]
        at.M[3 + k, 3 + k] += about[k, k] + m * (square - r[k] * r[k])
        for c in range(k):
            at.M[3 + k, 3 + c] += about[k, c] - m * r[k] * r[c]
        at.f[k] += force[k]
        at.f[3 + k] += moment[k] + r[i] * force[j] - r[j] * force[i]


@inline_kernel
def _add_joint(body: FallingBody, at: Placed, m: float, i: int) -> None:
    """Add what a link of mass m is to the joint i that carries it, and to joints between i and the free one.

    A unit rate of the joint moves the link's centre by d and turns it by w: momenta m d and I w, which are
    the row of M in the free joint's six coordinates, and by d' and w' in those of the other joints.
    """
    r, centre, force, moment = at.vectors[2], at.vectors[3], at.vectors[4], at.vectors[5]
    d, w, row, spin = at.D[i], at.W[i], 5 + i, at.vectors[1]
    _joint_motion(body, at, i, centre, d)
    for k in range(3):
        w[k] = 0.0 if body.sliding[i] else at.a[i, k]
    _turn(at.turns[0], w, spin)
    for k in range(3):
        a, b = (k + 1) % 3, (k + 2) % 3
        at.M[row, k] += m * d[k]
        at.M[row, 3 + k] += spin[k] + m * (r[a] * d[b] - r[b] * d[a])
        at.f[row] += d[k] * force[k] + w[k] * moment[k]


@inline_kernel
def _add_pair(at: Placed, m: float, i: int, j: int) -> None:
    """Add what a link of mass m is to the joints i >= j that carry it, once `_add_joint` has seen both."""
    spin = at.vectors[1]
    _turn(at.turns[0], at.W[i], spin)
    for k in range(3):
        at.M[5 + i, 5 + j] += m * at.D[i, k] * at.D[j, k] + spin[k] * at.W[j, k]


@inline_kernel
def dynamics(
    body: FallingBody, at: Placed, q: FloatArray, v: FloatArray, gravity: FloatArray, step: float
) -> None:
    """Fill the Cholesky factor of M and the forces f (nv,) under gravity (3,) at q (7 + joints,) and v (nv,).

    Springs and their dampers are those of backward Euler over a step [s]: they add to M what they resist, so
    that an impact meets the stiff ones as it would meet no joint, whatever their stiffness.
    """
    at.M[:], at.f[:] = 0.0, 0.0
    at.alpha[0], at.acc[0] = 0.0, 0.0
    link_velocities(body, at, v)
    for link in range(body.masses.size):
        if link > 0:
            _accelerations(body, at, v, link)
        m, i = body.masses[link], link
        if m == 0.0:  # it carries axes only
            continue
        _link_forces(body, at, gravity, link)
        _add_free(at, m)
        while i > 0:
            _add_joint(body, at, m, i)
            i = body.parents[i]
        i = link
        while i > 0:
            j = i
            while j > 0:
                _add_pair(at, m, i, j)
                j = body.parents[j]
            i = body.parents[i]
    for i in range(1, body.masses.size):
        spring, damping, r = body.stiffness[i], body.damping[i], 5 + i
        if spring > 0.0:
            at.M[r, r] += step * (damping + step * spring)
            at.f[r] -= spring * (q[6 + i] + step * v[r]) + damping * v[r]
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
        place_spheres(body, at)
        out[n] = at.x
    return out
