"""Semismooth Newton on the Alart-Curnier equations, globalised by the natural map.

Each contact is classified from its augmented force λ - ρ u (ρ from its own block): take-off, stick, slide,
or held by a normal bound. The linearised equations are then reduced to the forces that are still free (3 for
a contact that sticks, 2 for one that slides, none for one that takes off), and a small proximal term on the
diagonal keeps redundant contacts (a rank-deficient G) solvable without moving any solution. Steps are full:
which contacts slide sorts itself out faster over a few bad steps than under a line search. The natural map
judges them; the best point is kept, and Gauss-Seidel sweeps take over where none comes for a while.

Source: P. Alart, A. Curnier, "A mixed formulation for frictional contact problems prone to Newton like
solution methods", CMAME 92, 1991; V. Acary, M. Bremond, O. Huber, "On solving contact problems with Coulomb
friction: formulations and numerical comparisons", 2018. For the convex law the normal velocity is shifted by
mu ||u_t||.

Limits: fast near a solution and no promise far from one; the reduced matrix is dense in the step below.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.arrays import FloatArray, IntArray
from surefoot.kernels import inline_kernel, kernel
from surefoot.solvers.natural_map import natural_gap, relative_gap
from surefoot.solvers.nsgs import prepare_dense, refresh_dense, sweep_dense

PATIENCE = 10
"""Newton steps that may pass without a better natural map."""
WORTH = 4.0
"""Sweeps that a Newton step is worth, plus one for two contacts."""
PROXIMAL, PROXIMAL_FAR, PROXIMAL_SHARES = 1e-9, 1e-2, (1e-3, 0.1, 1.0)
"""The proximal term, relative to the trace of a contact's block: a share of the natural map, within bounds.

Far away it keeps steps short where a wrong guess of who slides leaves no solution; close by it is harmless.
Attempts take turns with the shares: what holds one back lets the next one through.
"""
SHARES_MANY, FEW = (0.1, 1e-6, 1.0), 25
"""The shares above `FEW` contacts: who slides is open for longer there."""


@kernel
def classify(
    forces: FloatArray, velocities: FloatArray, local: FloatArray, mu: FloatArray, low: FloatArray,
    high: FloatArray, convex: bool, rows: FloatArray, columns: FloatArray, weight: FloatArray,
    jump: FloatArray, target: FloatArray, proximal: float,
) -> IntArray:  # fmt: skip
    """Linearise every contact: its free directions, its equations and the part of the step that is known.

    For contact k and each of its count[k] unknowns c: the force moves by jump[k] + sum_c y_c columns[k, c];
    the equations are rows[k, c] . (u + du) + weight[k, c] y_c = target[k, c].
    """
    n = mu.size
    count = np.zeros(n, dtype=np.int64)
    for k in range(n):
        i = 3 * k
        W = local[k]
        trace = W[0] + W[3] + W[5]
        small = proximal * trace
        x, y, z = forces[i], forces[i + 1], forces[i + 2]
        p, q, r = velocities[i], velocities[i + 1], velocities[i + 2]
        rows[k], columns[k], target[k], jump[k] = 0.0, 0.0, 0.0, 0.0
        weight[k] = small
        if low[k] == -np.inf:
            count[k] = 3
            for c in range(3):
                rows[k, c, c] = columns[k, c, c] = 1.0
            continue
        step_t, step_n = 1.0 / max(W[0], W[3]), 1.0 / W[5]
        wx, wy = x - step_t * p, y - step_t * q
        length = math.sqrt(wx * wx + wy * wy)
        shift = 0.0
        lifted = z - step_n * r
        if convex and mu[k] > 0.0:
            # where the contact slides, the convex law adds mu ||u_t|| to its normal velocity
            shift = mu[k] * math.sqrt(p * p + q * q)
            lifted = z - step_n * (r - shift)
            if length <= mu[k] * min(max(z - step_n * r, low[k]), high[k]):
                lifted, shift = z - step_n * r, 0.0
        held = lifted <= low[k] or lifted >= high[k]
        normal = min(max(lifted, low[k]), high[k])
        radius = mu[k] * normal
        c = 0
        if radius == 0.0 and (held or mu[k] == 0.0):
            jump[k, 0], jump[k, 1] = -x, -y
            if held:
                jump[k, 2] = normal - z
            else:
                rows[k, 0, 2] = columns[k, 0, 2] = 1.0
                c = 1
        elif length <= radius:  # stick
            if held:
                jump[k, 2] = normal - z
            for a in range(2 if held else 3):
                rows[k, a, a] = columns[k, a, a] = 1.0
            c = 2 if held else 3
        else:  # slide along e
            ex, ey = wx / length, wy / length
            along = x * ex + y * ey
            ratio = radius / length
            if held:
                jump[k, 2] = normal - z
                change = mu[k] * normal - along
            else:
                change = mu[k] * z - along
                rows[k, 0, 2] = 1.0
                columns[k, 0, 0], columns[k, 0, 1], columns[k, 0, 2] = mu[k] * ex, mu[k] * ey, 1.0
                if convex:
                    rows[k, 0, 0], rows[k, 0, 1] = mu[k] * ex, mu[k] * ey
                c = 1
            jump[k, 0], jump[k, 1] = change * ex, change * ey
            columns[k, c, 0], columns[k, c, 1] = -ey, ex
            rows[k, c, 0], rows[k, c, 1] = -ratio * ey, ratio * ex
            across = -p * ey + q * ex
            target[k, c] = (ratio - 1.0) * across
            weight[k, c] = (1.0 - ratio) / step_t + small
            c += 1
        count[k] = c
    return count


@kernel
def _assemble(
    G: FloatArray, velocities: FloatArray, rows: FloatArray, columns: FloatArray, weight: FloatArray,
    jump: FloatArray, target: FloatArray, count: IntArray, moved: FloatArray, across: FloatArray,
    A: FloatArray, b: FloatArray,
) -> int:  # fmt: skip
    """Fill the reduced matrix and right-hand side of the linearised equations; return their size."""
    n = count.size
    moved[:] = velocities  # u after the known part of the step
    for k in range(n):
        for a in range(3):
            d = jump[k, a]
            if d != 0.0:
                for j in range(moved.size):
                    moved[j] += G[3 * k + a, j] * d
    i = 0
    for k in range(n):
        for c in range(count[k]):
            x, y, z = rows[k, c, 0], rows[k, c, 1], rows[k, c, 2]
            row = across  # this equation's row of G
            if count[k] == 3:  # three unknowns are the three components, here and below
                row = G[3 * k + c]
            else:
                for j in range(moved.size):
                    across[j] = G[3 * k, j] * x + G[3 * k + 1, j] * y + G[3 * k + 2, j] * z
            at = 0
            for h in range(n):
                if count[h] == 0:
                    continue
                p, q, r = row[3 * h], row[3 * h + 1], row[3 * h + 2]
                if count[h] == 3:
                    A[i, at], A[i, at + 1], A[i, at + 2] = p, q, r
                    at += 3
                    continue
                for d in range(count[h]):
                    A[i, at] = p * columns[h, d, 0] + q * columns[h, d, 1] + r * columns[h, d, 2]
                    at += 1
            A[i, i] += weight[k, c]
            b[i] = target[k, c] - (moved[3 * k] * x + moved[3 * k + 1] * y + moved[3 * k + 2] * z)
            i += 1
    return i


@inline_kernel
def _back_substitute(A: FloatArray, b: FloatArray, m: int) -> None:
    """Solve with the upper triangle of A in place."""
    for k in range(m - 1, -1, -1):
        total = b[k]
        for j in range(k + 1, m):
            total -= A[k, j] * b[j]
        b[k] = total / A[k, k]


@kernel
def symmetric_solve(A: FloatArray, b: FloatArray, m: int) -> bool:
    """Solve m equations A x = b with a positive definite A in place (x in b); False if it is not.

    Elimination on the upper half, two columns at a time, without pivoting.
    """
    for k in range(0, m, 2):
        if not A[k, k] > 0.0:
            return False
        if k + 1 == m:
            break
        first = 1.0 / A[k, k]
        factor = A[k, k + 1] * first
        for j in range(k + 1, m):
            A[k + 1, j] -= factor * A[k, j]
        b[k + 1] -= factor * b[k]
        if not A[k + 1, k + 1] > 0.0:
            return False
        second = 1.0 / A[k + 1, k + 1]
        for i in range(k + 2, m):
            p, q = A[k, i] * first, A[k + 1, i] * second
            for j in range(i, m):
                A[i, j] -= p * A[k, j] + q * A[k + 1, j]
            b[i] -= p * b[k] + q * b[k + 1]
    _back_substitute(A, b, m)
    return True


@inline_kernel
def _pivot(A: FloatArray, b: FloatArray, k: int, m: int, first: int) -> bool:
    """Bring the largest entry of column k to its diagonal, rows from `first` on; False if all are zero."""
    pivot, best = k, abs(A[k, k])
    for i in range(k + 1, m):
        if abs(A[i, k]) > best:
            pivot, best = i, abs(A[i, k])
    if not best > 0.0:
        return False
    if pivot != k:
        for j in range(first, m):
            A[k, j], A[pivot, j] = A[pivot, j], A[k, j]
        b[k], b[pivot] = b[pivot], b[k]
    return True


@kernel
def lu_solve(A: FloatArray, b: FloatArray, m: int) -> bool:
    """Solve m equations A x = b in place (x in b), pivoting rows; return False for a zero pivot.

    Two columns at a time: half as often through the matrix.
    """
    for k in range(0, m, 2):
        if not _pivot(A, b, k, m, k):
            return False
        if k + 1 == m:
            break
        inverse = 1.0 / A[k, k]
        for i in range(k + 1, m):
            A[i, k] *= inverse
            A[i, k + 1] -= A[i, k] * A[k, k + 1]
        if not _pivot(A, b, k + 1, m, k):
            return False
        inverse = 1.0 / A[k + 1, k + 1]
        factor = A[k + 1, k]
        for j in range(k + 2, m):
            A[k + 1, j] -= factor * A[k, j]
        b[k + 1] -= factor * b[k]
        for i in range(k + 2, m):
            p, q = A[i, k], A[i, k + 1] * inverse
            for j in range(k + 2, m):
                A[i, j] -= p * A[k, j] + q * A[k + 1, j]
            b[i] -= p * b[k] + q * b[k + 1]
    _back_substitute(A, b, m)
    return True


@kernel
def spread(
    columns: FloatArray, jump: FloatArray, count: IntArray, unknowns: FloatArray, step: FloatArray
) -> None:
    """Fill the flat (3n,) step of the forces from the reduced unknowns."""
    at = 0
    for k in range(count.size):
        for a in range(3):
            step[3 * k + a] = jump[k, a]
        for c in range(count[k]):
            for a in range(3):
                step[3 * k + a] += unknowns[at] * columns[k, c, a]
            at += 1


@kernel
def newton_dense(
    G: FloatArray, g: FloatArray, mu: FloatArray, low: FloatArray, high: FloatArray, convex: bool,
    scale: float, tol: float, limit: int, share: float, local: FloatArray, forces: FloatArray,
    velocities: FloatArray,
) -> tuple[int, float]:  # fmt: skip
    """Take Newton steps while the natural map falls well; return the steps and the relative gap reached.

    Forces and velocities (flat, consistent) are updated in place and never get worse.
    """
    n = mu.size
    m = 3 * n
    work = np.empty(m * (15 + m))  # one allocation: a dozen would take as long as a step
    rows, columns = work[: 3 * m].reshape(n, 3, 3), work[3 * m : 6 * m].reshape(n, 3, 3)
    weight, jump = work[6 * m : 7 * m].reshape(n, 3), work[7 * m : 8 * m].reshape(n, 3)
    target, step = work[8 * m : 9 * m].reshape(n, 3), work[9 * m : 10 * m]
    moved, b, across = work[10 * m : 11 * m], work[11 * m : 12 * m], work[12 * m : 13 * m]
    best_forces, best_velocities = work[13 * m : 14 * m], work[14 * m : 15 * m]
    A = work[15 * m :].reshape(m, m)
    free = 0.0
    for j in range(m):
        free += g[j] * g[j]
    free = scale * math.sqrt(free)
    gap, size = natural_gap(forces, velocities, mu, low, high, scale, convex)
    relative = relative_gap(gap, size, free)
    best = relative
    best_forces[:], best_velocities[:] = forces, velocities
    done = since = 0
    while done < limit and best > tol and since < PATIENCE:
        done += 1
        kinds = classify(
            forces, velocities, local, mu, low, high, convex, rows, columns, weight, jump, target,
            max(PROXIMAL, min(PROXIMAL_FAR, share * relative)),
        )  # fmt: skip
        m = _assemble(G, velocities, rows, columns, weight, jump, target, kinds, moved, across, A, b)
        plain = True  # all of them stick, or carry nothing: G itself, symmetric
        for k in range(n):
            plain = plain and (kinds[k] == 3 or kinds[k] == 0)
        if not (symmetric_solve(A, b, m) if plain else lu_solve(A, b, m)):
            break
        spread(columns, jump, kinds, b, step)
        for j in range(step.size):
            forces[j] += step[j]
        refresh_dense(G, g, forces, velocities)
        gap, size = natural_gap(forces, velocities, mu, low, high, scale, convex)
        relative = relative_gap(gap, size, free)
        since += 1
        if relative < best:
            if relative < 0.9 * best:
                since = 0
            best = relative
            best_forces[:], best_velocities[:] = forces, velocities
    forces[:], velocities[:] = best_forces, best_velocities
    return done, best


@kernel
def run_dense(
    G: FloatArray, g: FloatArray, mu: FloatArray, low: FloatArray, high: FloatArray, convex: bool,
    scale: float, tol: float, rounds: int, burst: int, forces: FloatArray,
) -> tuple[int, int, float]:  # fmt: skip
    """Alternate Gauss-Seidel sweeps with Newton steps; return sweeps, steps, and the relative gap."""
    local = prepare_dense(G)
    velocities = np.empty(g.size)
    refresh_dense(G, g, forces, velocities)
    free = 0.0
    for i in range(g.size):
        free += g[i] * g[i]
    free = scale * math.sqrt(free)
    sweeps = steps = 0
    relative = last = np.inf
    relax = 1.0
    patience = WORTH + 0.5 * mu.size
    for attempt in range(rounds):
        count, before = 0, np.inf
        while True:
            sweep_dense(G, local, mu, low, high, convex, relax, forces, velocities)
            sweeps += 1
            count += 1
            gap, size = natural_gap(forces, velocities, mu, low, high, scale, convex)
            relative = relative_gap(gap, size, free)
            if relative <= tol:
                refresh_dense(G, g, forces, velocities)
                gap, size = natural_gap(forces, velocities, mu, low, high, scale, convex)
                relative = relative_gap(gap, size, free)
            rate, before = relative / before, relative
            if relative <= tol:
                break
            # a Newton step costs as much as so many sweeps: go on where these will do
            if count >= burst and not tol > relative * rate**patience:
                break
            if count >= burst + 30:
                break
        if relative <= tol:
            break
        refresh_dense(G, g, forces, velocities)
        if relative > 0.5 * last and burst > 20:
            relax = max(0.6 * relax, 0.1)
        last = relative
        share = PROXIMAL_SHARES[attempt % 3] if mu.size <= FEW else SHARES_MANY[attempt % 3]
        used, relative = newton_dense(
            G, g, mu, low, high, convex, scale, tol, 20, share, local, forces, velocities
        )  # fmt: skip
        steps += used
        if relative <= tol:
            break
        burst = min(2 * burst, 200)
    return sweeps, steps, relative
