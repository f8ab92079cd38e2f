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
from surefoot.base.numerics.vectors import dot
from surefoot.contact import UNSOLVED, solve_compiled
from surefoot.mechanics import apply_impulses, assemble

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
        (3n, nv) maps from v to the contacts' velocities.
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
    n = near.size
    m = 3 * n
    vectors, buffer, poisson = np.zeros((2, m)), np.zeros((2 * n + 3, 3)), False
    depths, slips = np.zeros(n), np.zeros((n, 2))
    for i in range(n):
        x, y, z = dot(J[3 * i], before), dot(J[3 * i + 1], before), dot(J[3 * i + 2], before)
        vectors[1, i] = max(law[MU] + law[GROWTH] * min(math.hypot(x, y), FASTEST), 0.0)
        vectors[1, n + i], vectors[1, 2 * n + i] = 0.0, np.inf
        if z < -calm:
            # A contact that arrives has no depth to take back: it leaves by its restitution alone.
            slips[i, 0], slips[i, 1] = law[TANGENTIAL] * x, law[TANGENTIAL] * y
            poisson |= law[POISSON] > 0.0
        else:
            # What comes out of the ground does so gently: all of a depth in one step would be a throw.
            depths[i] = max(gaps[near[i]], -RISE_SPEED * t / RISE)
    e = np.full(n, law[RESTITUTION])
    Y, G, g = assemble(J, L, before, v, depths, np.arange(n), t, e, calm, RISE)
    for i in range(n):
        for a in range(3):
            vectors[0, 3 * i + a] = g[3 * i + a]
        # Tangential restitution as a shift of the slip that friction opposes: a contact that sticks leaves
        # with -e u_t.
        vectors[0, 3 * i] += slips[i, 0]
        vectors[0, 3 * i + 1] += slips[i, 1]
    done = solve_compiled(G, vectors, TOLERANCE, ITERATIONS, 0, buffer)
    impulses = buffer[:n].copy()
    if poisson:
        _expand(law, vectors, buffer, impulses)
        done = max(done, solve_compiled(G, vectors, TOLERANCE, ITERATIONS, 0, buffer))
        # Both phases happen at one instant: their impulses add up, and so do their changes of velocity.
        impulses += buffer[:n]
    after = apply_impulses(L, Y, impulses.reshape(-1), v)
    for i in range(v.size):
        v[i] = after[i]
    return done < UNSOLVED


@inline_kernel
def _expand(law: FloatArray, vectors: FloatArray, buffer: FloatArray, impulses: FloatArray) -> None:
    """Set up Poisson's second phase: from the velocities of the first, a share of its impulses at least."""
    n = impulses.shape[0]
    for i in range(n):
        vectors[1, n + i] = law[POISSON] * impulses[i, 2]
        for a in range(3):
            vectors[0, 3 * i + a] = buffer[n + i, a]
