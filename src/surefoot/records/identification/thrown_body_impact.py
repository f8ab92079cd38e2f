"""The impulses that a thrown body exchanges with the plane, under a law of impact that can be fitted.

Newton's restitution: what arrives with u_n leaves with at least -e u_n. Poisson's: the normal impulse of the
second phase is at least e times that of the first, which brings u_n to zero [1]_. Tangentially a share of the
arriving slip may come back. Friction may grow with the slip.

References
----------
.. [1] C. Glocker, F. Pfeiffer, "Multiple impacts with friction in rigid multibody systems", Nonlinear
   Dynamics 7, 1995.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.base.numerics.cholesky import solve_lower, solve_upper
from surefoot.base.numerics.vectors import advance, dot
from surefoot.contact import UNSOLVED, solve_compiled

MU, RESTITUTION, POISSON, TANGENTIAL, GROWTH = range(5)
"""Where a law keeps what: friction, restitution, that of Poisson and of the slip [-], growth [s/m]."""
SIZE = 5
CLOSED = 2e-5
"""Gap up to which a sphere touches [m]."""
RISE = 0.1
"""Share of a penetration that a closed sphere takes back per step, at most at `RISE_SPEED` [m/s]."""
RISE_SPEED = 0.02
TOLERANCE, ITERATIONS = 1e-8, 400
"""Of a contact problem."""
FASTEST = 4.0
"""Slip up to which friction grows [m/s]."""


@kernel
def exchange(
    law: FloatArray, J: FloatArray, L: FloatArray, gaps: FloatArray, near: IntArray, t: float, calm: float,
    before: FloatArray, v: FloatArray,
) -> bool:  # fmt: skip
    """Add the impulses of a time t to the velocity; return whether the certificate accepts them.

    Parameters
    ----------
    law
        (5,) see `MU`.
    J
        (3n, nv) maps from v to the contacts' velocities; becomes J L⁻ᵀ.
    L
        (nv, nv) factor of the mass matrix, in its lower half.
    gaps, near
        (k,) of all spheres [m], and (n,) those that touch.
    t
        [s].
    calm
        Speed up to which an arrival is none [m/s].
    before, v
        (nv,) velocity before the step, and the free one, to which the impulses are added.
    """
    n, nv = near.size, v.size
    m = 3 * n
    packed, buffer, poisson = np.zeros((m + 2, m)), np.zeros((2 * n + 3, 3)), False
    for i in range(n):
        # The problem as `solve_compiled` reads it: rows of G, then g = J v_free + shift, then mu and the
        # bounds on the normal impulses.
        u = np.zeros(3)  # of arrival
        for a in range(3):
            u[a] = dot(J[3 * i + a], before)
            packed[m, 3 * i + a] = dot(J[3 * i + a], v)
        slip = min(math.hypot(u[0], u[1]), FASTEST)
        packed[m + 1, i] = max(law[MU] + law[GROWTH] * slip, 0.0)
        packed[m + 1, n + i], packed[m + 1, 2 * n + i] = 0.0, np.inf
        arrives = u[2] < -calm
        if arrives:
            # Tangential restitution as a shift of the slip that friction opposes: a contact that sticks
            # leaves with -e u_t.
            packed[m, 3 * i] += law[TANGENTIAL] * u[0]
            packed[m, 3 * i + 1] += law[TANGENTIAL] * u[1]
        packed[m, 3 * i + 2] += _shift(law, gaps[near[i]], u[2], arrives, t)
        poisson |= arrives and law[POISSON] > 0.0
    for i in range(m):  # the rows of J L⁻ᵀ
        solve_lower(L, J[i])
    for i in range(m):
        for j in range(i + 1):
            packed[i, j] = packed[j, i] = dot(J[i], J[j])
    done = solve_compiled(packed[:m], packed[m:], TOLERANCE, ITERATIONS, 0, buffer)
    impulses = buffer[:n].copy()
    if poisson:
        _expand(law, packed, buffer, impulses)
        done = max(done, solve_compiled(packed[:m], packed[m:], TOLERANCE, ITERATIONS, 0, buffer))
        # Both phases happen at one instant: their impulses add up, and so do their changes of velocity.
        impulses += buffer[:n]
    change = np.zeros(nv)  # v += L⁻ᵀ Yᵀ λ
    for i in range(m):
        advance(change, impulses[i // 3, i % 3], J[i])
    solve_upper(L, change)
    advance(v, 1.0, change)
    return done < UNSOLVED


@inline_kernel
def _shift(law: FloatArray, gap: float, arrival: float, arrives: bool, t: float) -> float:
    """Return the bias of a normal velocity: leave with -e times that of arrival, or keep the gap."""
    if arrives:
        return float(law[RESTITUTION] * arrival)
    # What comes out of the ground does so gently: all of a depth in one step would be a throw.
    return float(gap / t if gap > 0.0 else -min(-RISE * gap / t, RISE_SPEED))


@inline_kernel
def _expand(law: FloatArray, packed: FloatArray, buffer: FloatArray, impulses: FloatArray) -> None:
    """Set up Poisson's second phase: from the velocities of the first, a share of its impulses at least."""
    n = impulses.shape[0]
    m = 3 * n
    for i in range(n):
        packed[m + 1, n + i] = law[POISSON] * impulses[i, 2]
        for a in range(3):
            packed[m, 3 * i + a] = buffer[n + i, a]
