"""A first-order step and its derivative, compiled: free of any robot library, callable under `numba.njit`.

With Λ = ∂λ/∂g of the contact problem, W = M⁻¹ Jᵀ and K = M⁻¹ + W Λ Wᵀ (what impulses of other forces do while
the ground answers), and S = ∂(J v⁺ + shift)/∂q at fixed v⁺::

    ∂v⁺/∂q = K (∂(Jᵀλ)/∂q - dt ∂ID/∂q) + W Λ S
    ∂v⁺/∂v = 1 + W Λ (J + ∂shift/∂v) - dt K ∂ID/∂v
    ∂v⁺/∂τ = dt K,      ∂v⁺/∂mu = W ∂λ/∂mu

with inverse dynamics ID at (q, v, (v⁺ - v) / dt), and q⁺ = q ⊕ dt v⁺.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, IntArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.base.numerics.cholesky import invert, product
from surefoot.base.numerics.points import contact_jacobian, point_velocity
from surefoot.base.numerics.vectors import advance, dot, largest
from surefoot.contact import (
    CONVEX_CALL,
    UNBOUNDED,
    UNSOLVED,
    contact_blocks,
    follow_path,
    path_blocks,
    solve_compiled,
)
from surefoot.mechanics.dynamics.arithmetic import (
    FASTEST,
    apply_impulses,
    assemble,
    bounces,
    contact_speeds,
    factorise,
    free_velocity,
    near_ground,
    with_missed,
)
from surefoot.mechanics.dynamics.derivative.rate_kernels import force_rates, velocity_rates

SOLVED, NOT_SOLVED, LOST = 0, 1, 2
"""How a step ended."""


class KnotSettings(NamedTuple):
    """Settings of all steps of a knot.

    Attributes
    ----------
    dt, reach
        Length of a step [s], and distance up to which a contact counts as near [m].
    restitution, rest_speed
        Share of a closing speed that a contact gives back [-], and the closing speed up to which that is none
        [m/s].
    pull
        Share of a penetration that a step takes back [-].
    tol
        Tolerance of the contact problem.
    """

    dt: float
    restitution: float
    rest_speed: float
    pull: float
    tol: float
    reach: float


Place = tuple[FloatArray, IntArray, BoolArray, FloatArray, FloatArray, FloatArray, FloatArray]
"""The first arguments of `derivative_kernels.velocity_rates`."""
Problem = tuple[FloatArray, FloatArray, FloatArray, FloatArray]
"""Y (3k, nv), G (3k, 3k), g (3k,) and the record (2k + 3, 3) of k contacts."""


@inline_kernel
def _locate(
    centres: FloatArray, radii: FloatArray, frames: FloatArray, gaps: FloatArray, above: FloatArray,
    positions: FloatArray,
) -> None:  # fmt: skip
    """Fill the contact points and, over a plane (`above` is not empty), their gaps."""
    for c in range(centres.shape[0]):
        height = 0.0
        for i in range(3):
            height += frames[c, i, 2] * centres[c, i]
            positions[c, i] = centres[c, i] - radii[c] * frames[c, i, 2]
        if above.size:
            gaps[c] = height - above[c]


@kernel
def _solve(
    J: FloatArray, L: FloatArray, v: FloatArray, free: FloatArray, gaps: FloatArray, near: IntArray,
    settings: KnotSettings, mu: float, convex: bool,
) -> tuple[bool, FloatArray, FloatArray, FloatArray, FloatArray]:  # fmt: skip
    """Solve the problem of the near contacts; return whether it is solved, and `Problem`."""
    k = near.size
    e = np.full(gaps.size, settings.restitution)
    Y, G, g = assemble(J, L, v, free, gaps, near, settings.dt, e, settings.rest_speed, settings.pull)
    record = np.zeros((2 * k + 3, 3))
    vectors = np.empty((2, 3 * k))
    for i in range(k):
        vectors[1, i], vectors[1, k + i], vectors[1, 2 * k + i] = mu, 0.0, np.inf
        for a in range(3):
            vectors[0, 3 * i + a] = g[3 * i + a]
    # A state that ran away is no contact problem: it counts as unsolved, and no solver is asked.
    if not (largest(g) < np.inf and (k == 0 or largest(G.reshape(-1)) < np.inf)):
        return False, Y, G, g, record
    done = 0
    if k:
        done = solve_compiled(G, vectors, settings.tol, UNBOUNDED, CONVEX_CALL if convex else 0, record)
    return done < UNSOLVED, Y, G, g, record


@kernel
def first_order_step(
    bodies: tuple[FloatArray, FloatArray, BoolArray, FloatArray],
    ground: tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray],
    v: FloatArray, effort: FloatArray, settings: KnotSettings, mu: float, convex: bool,
    J: FloatArray, L: FloatArray, impulses: FloatArray, after: FloatArray,
) -> tuple[int, FloatArray, IntArray, Problem]:  # fmt: skip
    """Take a step of semi-implicit Euler up to its new velocity.

    Parameters
    ----------
    bodies
        (nv, nv) mass matrix in its upper triangle; (nv, 6) twists, linear at the world's origin, world axes;
        (p, nv) which of them move each contact; (p,) radii of the spheres.
    ground
        (p, 3) the spheres' centres, (p, 3, 3) rotation_world_contact below them, (p,) gaps [m], filled over a
        plane; (p,) the plane's distance from the origin plus the radius, empty for curved ground; and (p, 3)
        to be filled with the contact points.
    v, effort
        (nv,) velocity and generalised forces less those of bias.
    settings, mu
        Of the knot, and friction of the ground [-].
    convex
        Whether the law is convex; else Coulomb's.
    J, L, impulses, after
        To be filled: (3p, nv) in contact axes, (nv, nv) lower factor of the mass matrix, (p, 3) [N s], and
        (nv,) the velocity after the step.

    Returns
    -------
    tuple
        `SOLVED`, `NOT_SOLVED` or `LOST`; (nv,) velocity without the ground's forces; (k,) contacts of the
        problem, and the problem with its solution.
    """
    upper, twists, support, radii = bodies
    centres, frames, gaps, above, positions = ground
    dt, p = settings.dt, gaps.size
    own = np.arange(p)
    _locate(centres, radii, frames, gaps, above, positions)
    # M = L Lᵀ, J at the configuration of the start: semi-implicit Euler
    factorise(upper, L)
    contact_jacobian(twists.T, support, own, positions, frames, J)
    # without the ground
    free = free_velocity(L, effort, v, dt)
    # A motion that is lost goes through the loop below once, without contacts, so that all outputs are
    # filled.
    near = own[:0]
    lost = not (largest(gaps) < np.inf and largest(free) < FASTEST)
    if not lost:
        near = near_ground(J, v, free, gaps, dt, settings.reach)
    velocities = np.empty((p, 3))
    # contacts that the others' impulses press in are added, until none is
    while True:
        solved, Y, G, g, record = _solve(J, L, v, free, gaps, near, settings, mu, convex)
        impulses[:] = 0.0
        for i in range(near.size):
            for a in range(3):
                impulses[near[i], a] = record[i, a]
        after[:] = apply_impulses(L, Y, record[: near.size].reshape(-1), free)
        if lost or not largest(after) < FASTEST:
            return LOST, free, near, (Y, G, g, record)
        if not solved:
            return NOT_SOLVED, free, near, (Y, G, g, record)
        contact_speeds(J, after, velocities)
        more = with_missed(velocities, gaps, dt, near)
        if more.size == near.size:
            return SOLVED, free, near, (Y, G, g, record)
        near = more


@kernel
def answer(problem: Problem, mu: float, convex: bool, out: FloatArray) -> bool:
    """Fill out (3k, 4k) with the derivatives of impulses by g and by every contact's mu.

    False where contacts are redundant; see `contact_blocks`.
    """
    _, G, g, record = problem
    laws = np.empty((3, g.size // 3))
    for i in range(laws.shape[1]):
        laws[0, i], laws[1, i], laws[2, i] = mu, 0.0, np.inf
    return contact_blocks(G, laws, convex, record, out)


@kernel
def smooth_step(
    J: FloatArray, L: FloatArray, v: FloatArray, free: FloatArray, gaps: FloatArray, settings: KnotSettings,
    mu: float, convex: bool, kappa: float, impulses: FloatArray, after: FloatArray,
) -> tuple[bool, FloatArray, FloatArray]:  # fmt: skip
    """Bring a step's impulses to the central path, all contacts taking part; see `batch.central_path`.

    Parameters
    ----------
    J, L, v, free, gaps, settings, mu, convex
        As `first_order_step` took, filled and returned them.
    kappa
        Normal impulse times normal velocity on the path [N s m/s].
    impulses, after
        (p, 3) to start from, and filled; (nv,) to be filled with the velocity after the step.

    Returns
    -------
    tuple
        Whether the path was reached, Y (3p, nv), and (3p, 4p) what `answer` fills.
    """
    # On the central path every contact has a force, however far from the ground: no set of near ones to
    # choose, and the derivative knows of contacts that are not there yet.
    p = gaps.size
    e = np.full(p, settings.restitution)
    Y, G, g = assemble(J, L, v, free, gaps, np.arange(p), settings.dt, e, settings.rest_speed, settings.pull)
    frictions, by_g = np.full(p, mu), np.empty((3 * p, 4 * p))
    found = p == 0 or follow_path(G, g, frictions, convex, kappa, impulses)
    if p and found:
        found = path_blocks(G, g, frictions, convex, kappa, impulses, by_g)
    after[:] = apply_impulses(L, Y, impulses.reshape(-1), free)
    return found, Y, by_g


@inline_kernel
def _shift_rates(
    arriving: FloatArray, slopes: FloatArray, place: Place, J: FloatArray, near: IntArray,
    shifts: FloatArray, out: FloatArray,
) -> None:  # fmt: skip
    """Fill out (3k, 3nv) with the rates of the shift by q and v, from column nv on; zeros elsewhere there.

    `arriving` (3p, nv) are the rates of J v by q, `slopes` (p, 3) the gaps' rates with the spheres' centres,
    and `shifts` (k, 2) what the shift takes of the gap [1/s] and of the normal velocity on arrival.
    """
    twists, support, radii, frames, positions = place[0], place[2], place[4], place[5], place[3]
    n = J.shape[1]
    for i in range(near.size):
        c = near[i]
        r, share, bounce = 3 * i + 2, shifts[i, 0], shifts[i, 1]
        for a in range(3):
            for j in range(n, 3 * n):
                out[3 * i + a, j] = 0.0
        # A gap moves with the sphere's centre, along the slope of the ground's distance there.
        x = positions[c, 0] + radii[c] * frames[c, 0, 2]
        y = positions[c, 1] + radii[c] * frames[c, 1, 2]
        z = positions[c, 2] + radii[c] * frames[c, 2, 2]
        for j in range(n):
            if support[c, j]:
                p, q, w = point_velocity(twists.T, j, x, y, z)
                out[r, n + j] = share * (slopes[c, 0] * p + slopes[c, 1] * q + slopes[c, 2] * w)
        if bounce != 0.0:
            for j in range(n):
                out[r, n + j] += bounce * arriving[3 * c + 2, j]
                out[r, 2 * n + j] = bounce * J[3 * c + 2, j]


@inline_kernel
def _shifts(
    J: FloatArray, v: FloatArray, free: FloatArray, gaps: FloatArray, near: IntArray, settings: KnotSettings
) -> FloatArray:
    """Return (k, 2) how `arithmetic.normal_shift` depends on gap and arriving velocity: on one of them."""
    out = np.zeros((near.size, 2))
    dt, e, slow, pull = settings.dt, settings.restitution, settings.rest_speed, settings.pull
    for i in range(near.size):
        c = near[i]
        before, ahead = dot(J[3 * c + 2], v), dot(J[3 * c + 2], free)
        if bounces(gaps[c], before, ahead, dt, e, slow, pull):
            out[i, 1] = e
        else:
            out[i, 0] = (1.0 if gaps[c] > 0.0 else pull) / dt
    return out


@kernel
def first_order_blocks(
    place: Place,
    ground: tuple[FloatArray, FloatArray, FloatArray],
    speeds: tuple[FloatArray, FloatArray, FloatArray],
    near: IntArray, Y: FloatArray, by_g: FloatArray, impulses: FloatArray, settings: KnotSettings,
    L: FloatArray, dynamics: tuple[FloatArray, FloatArray], moved: tuple[FloatArray, FloatArray],
    A: FloatArray, B: FloatArray,
) -> FloatArray:  # fmt: skip
    """Fill A (2nv, 2nv) and B (2nv, joints) of a first-order step; return by mu (2nv,).

    Parameters
    ----------
    place
        See `derivative_kernels.velocity_rates`: twists, first, support, positions, radii, frames, turns.
    ground
        (p,) gaps, (p, 3) their rates with the spheres' centres, (3p, nv) J.
    speeds
        (nv,) before the step, without the ground's forces, and after it.
    near, Y
        As `first_order_step` returned them.
    by_g
        (3k, 4k) derivatives of the impulses by g and by every contact's mu.
    impulses, settings, L
        As `first_order_step` filled and took them.
    dynamics
        (nv, nv) derivatives of inverse dynamics by q and v, at the acceleration of the step.
    moved
        (nv, nv) derivatives of q ⊕ dt v⁺ by q and by the way.
    """
    twists, first, support, positions, radii, frames, turns = place
    gaps, slopes, J = ground
    v, free, after = speeds
    n, m, dt = v.size, 3 * near.size, settings.dt
    by_q, by_v = dynamics
    # half = L⁻¹, and W = Y L⁻¹ = (M⁻¹ Jᵀ)ᵀ: a row for each row of the contact problem.
    half, K = np.empty((n, n)), np.empty((n, n))
    # K = M⁻¹ first; what the ground's answer adds comes below
    invert(L, half, K)
    # what moves the contact problem's g: columns of W, q, v
    W, columns = np.empty((m, n)), np.empty((m, 3 * n))
    product(Y, half, W)
    shifts = _shifts(J, v, free, gaps, near, settings)
    spin = velocity_rates(twists, first, support, positions, radii, frames, turns, after)
    arriving = spin
    if settings.restitution > 0.0:
        arriving = velocity_rates(twists, first, support, positions, radii, frames, turns, v)
    _shift_rates(arriving, slopes, place, J, near, shifts, columns)
    # g = J v_free + shift moves with the impulse of any force (W), with q, and with v
    for i in range(m):
        r = 3 * near[i // 3] + i % 3
        for j in range(n):
            columns[i, j] = W[i, j]
            columns[i, n + j] += spin[r, j]
            columns[i, 2 * n + j] += J[r, j]
    # what the ground's answer does to v⁺
    answer, back = np.empty((m, 3 * n)), np.empty((n, 3 * n))
    product(by_g[:, :m], columns, answer)
    product(W.T, answer, back)
    pushed = force_rates(twists, first, support, positions, radii, frames, turns, impulses)
    given = np.empty((n, 2 * n))
    for i in range(n):
        for j in range(n):
            K[i, j] += back[i, j]
            given[i, j] = pushed[i, j] - dt * by_q[i, j]
            given[i, n + j] = -dt * by_v[i, j]
    velocity = np.empty((n, 2 * n))
    product(K, given, velocity)
    by_mu = np.zeros(2 * n)
    for i in range(n):
        velocity[i, n + i] += 1.0
        for j in range(2 * n):
            velocity[i, j] += back[i, n + j]
        for r in range(m):
            total = 0.0
            for c in range(near.size):
                total += by_g[r, m + c]
            by_mu[n + i] += W[r, i] * total
    _advance(moved, velocity, K, by_mu, dt, A, B)
    return by_mu


@inline_kernel
def _advance(
    moved: tuple[FloatArray, FloatArray], velocity: FloatArray, K: FloatArray, by_mu: FloatArray, dt: float,
    A: FloatArray, B: FloatArray,
) -> None:  # fmt: skip
    """Fill A, B and the first half of by_mu from the rates of v⁺: q⁺ = q ⊕ dt v⁺."""
    by_start, by_way = moved
    n, joints = K.shape[0], B.shape[1]
    for i in range(n):
        for j in range(2 * n):
            A[n + i, j] = velocity[i, j]
            A[i, j] = by_start[i, j] if j < n else 0.0
        for j in range(joints):
            B[n + i, j] = dt * K[i, n - joints + j]
            B[i, j] = 0.0
    for i in range(n):
        for k in range(n):
            # δq⁺ = ∂(q ⊕ w)/∂q δq + dt ∂(q ⊕ w)/∂w δv⁺, with w = dt v⁺: rows of v⁺ are there already.
            s = dt * by_way[i, k]
            if s != 0.0:
                advance(A[i], s, A[n + k])
                advance(B[i], s, B[n + k])
                by_mu[i] += s * by_mu[n + k]
