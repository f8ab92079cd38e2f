"""Nonsmooth Gauss-Seidel: contact after contact, each one solved exactly.

Source: J. J. Moreau, "Unilateral contact and dry friction in finite freedom dynamics", 1988; M. Jean,
"The non-smooth contact dynamics method", CMAME 177, 1999. For the convex law it is block coordinate descent.

Limits: converges linearly, slowly for stacks, large mass ratios and redundant contacts; no proof for
Coulomb's law, and none is needed in practice for mu below about one. Velocities are kept up to date after
each contact, which costs one block column of G. The sweep over a dense matrix, for compiled calls, differs in
its last loop only, and is written out all the same: parts shared between them cost 5 to 20 %.
"""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import inline_kernel, kernel, working_time
from surefoot.contact.problem.blocks import block_product
from surefoot.contact.problem.problem import ContactProblem
from surefoot.contact.solution import Status
from surefoot.contact.solvers.one_contact import WIDTH, block_of, prepare, solve_one
from surefoot.contact.solvers.solver import Answer, SolverSettings, register, start_forces
from surefoot.contact.solvers.stopping import fill_measure, velocity_error

MAX_SWEEPS = 100_000
CIRCLE = 40
"""Sweeps without progress after which they are taken to go in circles, and are relaxed."""


@inline_kernel
def fill_dense(G: FloatArray, scales: FloatArray, local: FloatArray) -> None:
    """Fill the local data (n, WIDTH) of every contact of a dense G (3n, 3n), see `one_contact.prepare`.

    The scales are (4, n).
    """
    for k in range(local.shape[0]):
        i = 3 * k
        prepare(
            G[i, i], G[i, i + 1], G[i, i + 2], G[i + 1, i + 1], G[i + 1, i + 2], G[i + 2, i + 2], local, k
        )
    fill_measure(scales, local)


@inline_kernel
def _change(
    k: int, local: FloatArray, mu: FloatArray, low: FloatArray, high: FloatArray, convex: bool, relax: float,
    forces: FloatArray, velocities: FloatArray,
) -> tuple[float, float, float]:  # fmt: skip
    """Solve contact k with all others held, and change its force; return by how much."""
    if high[k] == 0.0:
        return 0.0, 0.0, 0.0
    i, W = 3 * k, block_of(local, k)
    x, y, z = forces[i], forces[i + 1], forces[i + 2]
    # the damped block of `prepare`, not G's own: what damping adds here
    # it takes away again in the local solve
    q0 = velocities[i] - (W[0] * x + W[1] * y + W[2] * z)  # q = u_k - G_kk λ_k: what the others leave
    q1 = velocities[i + 1] - (W[1] * x + W[3] * y + W[4] * z)
    q2 = velocities[i + 2] - (W[2] * x + W[4] * y + W[5] * z)
    a, b, c, local[k, 12], local[k, 13] = solve_one(
        W, q0, q1, q2, mu[k], low[k], high[k], convex, x, y, local[k, 12], local[k, 13]
    )
    d0, d1, d2 = relax * (a - x), relax * (b - y), relax * (c - z)
    forces[i], forces[i + 1], forces[i + 2] = x + d0, y + d1, z + d2
    return d0, d1, d2


@inline_kernel
def sweep_dense(
    G: FloatArray, local: FloatArray, mu: FloatArray, low: FloatArray, high: FloatArray, convex: bool,
    relax: float, forces: FloatArray, velocities: FloatArray,
) -> None:  # fmt: skip
    """Run once over all contacts, updating flat forces and velocities, (3n,).

    G is (3n, 3n), `local` (n, WIDTH), see `fill_dense`; mu and the bounds are (n,).
    """
    for k in range(mu.size):
        i = 3 * k
        d0, d1, d2 = _change(k, local, mu, low, high, convex, relax, forces, velocities)
        if d0 != 0.0 or d1 != 0.0 or d2 != 0.0:
            # G is symmetric: its columns are taken as rows, which lie side by side in memory
            for j in range(velocities.size):
                velocities[j] += G[i, j] * d0 + G[i + 1, j] * d1 + G[i + 2, j] * d2


@inline_kernel
def refresh_dense(G: FloatArray, g: FloatArray, forces: FloatArray, velocities: FloatArray) -> None:
    """Recompute the flat (3n,) velocities u = G λ + g of flat forces, row by row (G is symmetric)."""
    for j in range(g.size):
        velocities[j] = g[j]
    for i in range(g.size):
        x = forces[i]
        if x != 0.0:
            for j in range(g.size):
                velocities[j] += G[i, j] * x


@inline_kernel
def relaxation(gap: float, relax: float, best: float, since: int) -> tuple[float, float, int]:
    """Return the relaxation, the best gap and the sweeps since it: shorter steps against circles."""
    if gap < 0.99 * best:
        return relax, gap, 0
    if since >= CIRCLE:
        # sweeps that no proof makes converge (Coulomb's law) may go round: half steps cut the circle. A new
        # relaxation starts a record of its own, hence the best gap is forgotten
        return max(0.5 * relax, 0.05), 10.0 * gap, 0
    return relax, best, since + 1


@kernel
def prepare_blocks(starts: IntArray, columns: IntArray, values: FloatArray, scales: FloatArray) -> FloatArray:
    """Return the local data of every contact of a block matrix: (n, WIDTH)."""
    n = starts.size - 1
    local = np.zeros((n, WIDTH))
    for k in range(n):
        for at in range(starts[k], starts[k + 1]):
            if columns[at] == k:
                B = values[at]
                prepare(B[0, 0], B[0, 1], B[0, 2], B[1, 1], B[1, 2], B[2, 2], local, k)
    fill_measure(scales, local)
    return local


@inline_kernel
def sweep_blocks(
    starts: IntArray, columns: IntArray, values: FloatArray, local: FloatArray, mu: FloatArray,
    low: FloatArray, high: FloatArray, convex: bool, relax: float, forces: FloatArray, velocities: FloatArray,
) -> None:  # fmt: skip
    """Run once over all contacts of a block matrix, updating flat forces and velocities, (3n,).

    Row k of blocks has the columns and 3x3 values starts[k] to starts[k + 1] - 1: (n + 1,), (b,), (b, 3, 3).
    """
    for k in range(mu.size):
        d0, d1, d2 = _change(k, local, mu, low, high, convex, relax, forces, velocities)
        if d0 != 0.0 or d1 != 0.0 or d2 != 0.0:
            for at in range(starts[k], starts[k + 1]):
                B = values[at]
                j = 3 * columns[at]
                # row k holds G_kj and contact j needs G_jk: its transpose, since G is symmetric
                velocities[j] += B[0, 0] * d0 + B[1, 0] * d1 + B[2, 0] * d2
                velocities[j + 1] += B[0, 1] * d0 + B[1, 1] * d1 + B[2, 1] * d2
                velocities[j + 2] += B[0, 2] * d0 + B[1, 2] * d1 + B[2, 2] * d2


@kernel
def run_blocks(
    starts: IntArray, columns: IntArray, values: FloatArray, g: FloatArray, mu: FloatArray, low: FloatArray,
    high: FloatArray, convex: bool, tol: float, sweeps: int, local: FloatArray, forces: FloatArray,
    state: FloatArray,
) -> tuple[int, bool]:  # fmt: skip
    """Sweep until the velocity error passes or the sweeps are used up; return sweeps and success.

    Arrays as for `sweep_blocks`; `state` (3,) holds the relaxation, the best gap and the sweeps since it,
    from call to call.
    """
    velocities = block_product(starts, columns, values, forces) + g
    relax, best, since = state[0], state[1], int(state[2])
    for count in range(1, sweeps + 1):
        sweep_blocks(starts, columns, values, local, mu, low, high, convex, relax, forces, velocities)
        error = velocity_error(forces, velocities, mu, low, high, local, convex)
        relax, best, since = relaxation(error, relax, best, since)
        state[0], state[1], state[2] = relax, best, since
        if error <= tol:
            # a sum of many small changes has drifted from G λ + g: the verdict is on velocities computed anew
            velocities = block_product(starts, columns, values, forces) + g
            if velocity_error(forces, velocities, mu, low, high, local, convex) <= tol:
                return count, True
    return sweeps, False


@register("nsgs", bilateral=True)
def solve_nsgs(problem: ContactProblem, settings: SolverSettings, warm_start: FloatArray | None) -> Answer:
    """Solve either law by Gauss-Seidel with exact local solves from a (n, 3) start; iterations are sweeps."""
    forces = start_forces(problem, warm_start)
    limit = MAX_SWEEPS if settings.max_iterations is None else settings.max_iterations
    end = working_time() + settings.max_time
    laws, convex = (problem.mu, problem.normal_min, problem.normal_max), problem.law.shift == 0.0
    blocks = problem.blocks
    matrix = blocks.starts, blocks.columns, blocks.values
    local, state = prepare_blocks(*matrix, problem.scales), np.array([1.0, np.inf, 0.0])
    # the clock is looked at between compiled calls, after about 2e6 multiplications, 9
    # n² of them a sweep over a full matrix
    chunk = limit if settings.max_time == np.inf else max(1, int(2e6 / (9.0 * problem.contacts**2 + 1)))
    done, solved = 0, False
    while not solved and done < limit:
        now = min(chunk, limit - done)
        used, solved = run_blocks(*matrix, problem.g, *laws, convex, settings.tol, now, local, forces, state)
        done += used
        if not solved and working_time() > end:
            return Answer(forces.reshape(-1, 3), done, Status.MAX_TIME)
    return Answer(forces.reshape(-1, 3), done, Status.MAX_ITERATIONS)
