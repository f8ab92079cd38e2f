"""Up to 128 contacts on exact cones in one compiled call: sweeps, Newton steps, and the certificate.

Bursts of Gauss-Seidel sweeps, which find out who sticks, slides or takes off, take turns with Newton steps,
which finish. The problem is taken as it lies in memory (G and all vectors are two arrays), so what a
user changes in place is seen. Every argument of a compiled call costs time, arrays most.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import (
    INTEGER,
    MATRIX,
    REAL,
    borrowed,
    entry_point,
    inline_kernel,
    keep,
    kernel,
    window,
)
from surefoot.contact.problem.blocks import MOST_DENSE, checked_copy
from surefoot.contact.problem.problem import ContactProblem
from surefoot.contact.problem.redundancy import few_bodies
from surefoot.contact.problem.residuals import certify_dense
from surefoot.contact.problem.scales import scales_dense
from surefoot.contact.solvers.newton_step import FEW, run_dense
from surefoot.contact.solvers.nsgs import fill_dense
from surefoot.contact.solvers.one_contact import WIDTH
from surefoot.contact.solvers.stopping import settle

COMPILED_CONTACTS = MOST_DENSE
"""Contacts up to which a dense compiled call pays: of 100 to 120 it takes half the time of sweeps and Newton
steps on blocks, of 200 more than they do."""
CONVEX_CALL, WARM, SOON, FIRST, LATER = 1, 2, 4, 8, 16
"""Bits of a call's mode: Γ = 0; the record holds forces to start from; a Newton step after one sweep; of
more than `FEW` contacts only the first round, for another method may do better than the next ones, or only
those that come after it."""
UNSOLVED = 1 << 50
"""Added to the iterations of a call whose forces the certificate refuses."""
ROUNDS, BURST, BURST_MANY = 8, 2, 10
"""Alternations, and sweeps before the first Newton step (then twice as many each time), of few contacts and
of many."""
UNBOUNDED = 1 << 40
NOT_NUMBERS, DOUBTFUL = -(1 << 40), -(1 << 40) - 1
"""Instead of iterations, for a G or g that is not finite, and for a G that is not symmetric positive
semidefinite as far as `read_system` looks."""
WORK = 10 + WIDTH
"""Numbers of scratch memory per contact."""
ITERATION, HEAVIER = 2e-7, 20
"""Seconds that an iteration takes per contact, sweeps and Newton steps as they come, and the contacts of
which it takes twice as long: the factors of a Newton step grow with their cube."""
_empty, _INFINITY = np.empty, math.inf
Entry = Callable[[FloatArray, FloatArray, float, int, int, FloatArray], int]
_entry: Entry | None = None
"""`solve_compiled`, once it is compiled."""
TASTE, _MANY = 13, 2 * FEW + 3
"""Iterations of a first round where contacts hold few bodies: its Newton steps defeat most of these, an
interior point none; and the rows of a record above which there are more than few contacts."""
NAME = "compiled call"
"""Of the packed form among what a problem has prepared."""


@kernel
def solve_compiled(
    G: FloatArray, vectors: FloatArray, tol: float, most: int, mode: int,
    record: FloatArray,
) -> int:  # fmt: skip
    """Fill the record (2n + 3, 3) of `ContactSolution` in at most so many iterations; return their number."""
    memory = np.empty(WORK * (vectors.shape[1] // 3))
    done = solve_within(borrowed(G), borrowed(vectors), tol, most, mode, borrowed(record), memory, 0)
    keep(memory)
    return done


@inline_kernel
def solve_within(
    G: FloatArray, vectors: FloatArray, tol: float, most: int, mode: int, record: FloatArray,
    memory: FloatArray, at: int,
) -> int:  # fmt: skip
    """Do as `solve_compiled` with borrowed arrays, in `WORK` n numbers of memory (..,) from a place on.

    G is (3n, 3n); vectors (2, 3n): g; mu, normal_min and normal_max; the record (2n + 3, 3).
    """
    m = vectors.shape[1]
    n = m // 3
    g, mu, low, high = vectors[0], vectors[1, :n], vectors[1, n : 2 * n], vectors[1, 2 * n :]
    convex = mode & CONVEX_CALL != 0
    forces, velocities = window(memory, at, 1, m)[0], window(memory, at + m, 1, m)[0]
    scales, local = window(memory, at + 2 * m, 4, n), window(memory, at + 2 * m + 4 * n, n, WIDTH)
    # the certificate's scales first: solver and judge measure by the same ruler
    scales_dense(G, g, low, high, scales)
    for i in range(m):
        forces[i] = record[i // 3, i % 3] if mode & WARM else 0.0
    burst, first, last = BURST, 0, ROUNDS
    if n > FEW:
        burst = BURST_MANY
        if mode & LATER:
            burst, first = 2 * BURST_MANY, 1
        elif mode & FIRST:
            last = 1
    if mode & SOON:
        burst = 1
    settle(low, scales, forces)
    fill_dense(G, scales, local)
    done, _ = run_dense(G, g, mu, low, high, convex, local, tol, first, last, burst, most, forces, velocities)
    # Newton may have moved what `settle` had put right: a part at rest has one solution, known beforehand
    settle(low, scales, forces)
    # the judge computes velocities anew from G, g and the forces; nothing
    # of what the iteration believed counts
    numbers = certify_dense(G, g, mu, low, high, scales, 0, True, not convex, forces, velocities)
    for k in range(n):
        for a in range(3):
            record[k, a], record[n + k, a] = forces[3 * k + a], velocities[3 * k + a]
    record[2 * n, 0], record[2 * n, 1], record[2 * n, 2] = numbers[0], numbers[1], numbers[2]
    record[2 * n + 1, 0], record[2 * n + 1, 1], record[2 * n + 1, 2] = numbers[3], numbers[4], numbers[5]
    record[2 * n + 2, 0], record[2 * n + 2, 1], record[2 * n + 2, 2] = numbers[6], 0.0, 0.0
    return done if max(numbers[0], numbers[1], numbers[2]) <= tol else done + UNSOLVED


@inline_kernel
def read_system(
    G: FloatArray, g: FloatArray, asymmetry: float, matrix: FloatArray, vectors: FloatArray
) -> int:
    """Copy G (m, m) and g (m,) into the matrix and the first of the vectors (2, m), as they are checked.

    A copy, because the caller's matrix may change, or be read-only. Return 0, NOT_NUMBERS or DOUBTFUL.
    """
    total = 0.0
    for i in range(g.size):
        vectors[0, i] = g[i]
        total += g[i]
    if not abs(total) < np.inf:  # NaN and infinity survive a sum
        return NOT_NUMBERS
    finite, sound = checked_copy(G, asymmetry, matrix)
    if not finite:
        return NOT_NUMBERS
    return 0 if sound else DOUBTFUL


Packed = tuple[FloatArray, FloatArray, int, tuple[int, int]]
"""G and the vectors (a problem's own arrays, no copies), the mode of its law, and the shape of
a record."""
Attempt = tuple[FloatArray, int, bool, int]
"""The record of `ContactSolution`, the iterations taken, whether the certificate says SOLVED, and the
iterations that were allowed; a plain tuple, because a solve of two microseconds would notice another."""


def packed_form(problem: ContactProblem) -> Packed | None:
    """Return what the compiled call takes, kept with the problem; None where it takes no such problem."""
    n = problem.contacts
    found: Packed | None = None
    if not problem.general and problem.facets is None and 0 < n <= COMPILED_CONTACTS:
        mode = CONVEX_CALL if problem.law.shift == 0.0 else 0
        found = problem.G, problem.vectors, mode, (2 * n + 3, 3)
    problem.prepared[NAME] = found
    return found


def attempt(
    problem: ContactProblem, tol: float, most: int | None, max_time: float, start: FloatArray | None,
    mode: int = FIRST,
) -> Attempt | None:  # fmt: skip
    """Solve a problem by the compiled call, None where it is not one for it; see `solve` for the arguments.

    The call looks at no clock: the time is kept by an estimate of its iterations.
    """
    packed = problem.prepared.get(NAME) or packed_form(problem)
    if packed is None:
        return None
    G, vectors, law, shape = packed
    limit = UNBOUNDED if most is None else most
    if shape[0] > _MANY and mode == FIRST and few_bodies(problem):
        limit = min(limit, TASTE)
    if max_time < _INFINITY:
        n = problem.contacts
        limit = min(limit, int(min(max_time / (ITERATION * n * (1.0 + (n / HEAVIER) ** 2)), 1e9)))
    record = _empty(shape)
    if start is not None:
        record[: problem.contacts] = start
        mode |= WARM
    done = (_entry or _compile())(G, vectors, tol, limit, mode | law, record)
    if done < UNSOLVED:
        return record, done, True, limit
    return record, done - UNSOLVED, False, limit


def _compile() -> Entry:
    """Compile `solve_compiled` on first use: importing compiles nothing."""
    global _entry
    types = MATRIX, MATRIX, REAL, INTEGER, INTEGER, MATRIX
    _entry = entry_point(solve_compiled, *types)
    return _entry
