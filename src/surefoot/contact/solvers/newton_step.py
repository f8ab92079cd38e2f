"""Semismooth Newton on the Alart-Curnier equations, globalised by the velocity error.

Each contact is classified from its augmented force λ - ρ u (ρ from its own block): take-off, stick, slide,
or held by a normal bound. The linearised equations are then reduced to the forces that are still free (3 for
a contact that sticks, 2 for one that slides, none for one that takes off), and a small proximal term on the
diagonal keeps redundant contacts (a rank-deficient G) solvable without moving any solution. Steps are full:
which contacts slide sorts itself out faster over a few bad steps than under a line search. The velocity
error judges them; the best point is kept, and Gauss-Seidel sweeps take over where none comes for a while.

Source: P. Alart, A. Curnier, "A mixed formulation for frictional contact problems prone to Newton like
solution methods", CMAME 92, 1991; V. Acary, M. Bremond, O. Huber, "On solving contact problems with Coulomb
friction: formulations and numerical comparisons", 2018. For the convex law the normal velocity is shifted by
mu ||u_t||.

Limits: fast near a solution and no promise far from one; the reduced matrix is dense in the step below.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import inline_kernel
from surefoot.base.numerics.elimination import lu_solve, symmetric_solve
from surefoot.contact.solvers.nsgs import refresh_dense, sweep_dense
from surefoot.contact.solvers.stopping import velocity_error

PATIENCE = 10
"""Newton steps that may pass without a better velocity error."""
WORTH = 4
"""Sweeps that a Newton step is worth, plus half a sweep a contact."""
PROXIMAL, PROXIMAL_FAR, PROXIMAL_SHARES = 1e-9, 1e-2, (1e-3, 0.1, 1.0)
"""The proximal term, relative to the trace of a contact's block: a share of the velocity error, within
bounds.

Far away it keeps steps short where a wrong guess of who slides leaves no solution; close by it is harmless.
Attempts take turns with the shares: what holds one back lets the next one through.
"""
FEW = 25
"""Contacts up to which who slides is found out by two sweeps."""


@inline_kernel
def _stick(
    k: int, count: int, small: float, rows: FloatArray, columns: FloatArray, weight: FloatArray,
    target: FloatArray,
) -> None:  # fmt: skip
    """Give contact k its first `count` components as unknowns, and that their velocities vanish."""
    # in the contact's own axes, u + du = 0 in every free direction: with count = 2 the normal force is
    # held at a bound and its velocity is free
    for c in range(count):
        for a in range(3):
            rows[k, c, a] = columns[k, c, a] = 1.0 if a == c else 0.0
        weight[k, c], target[k, c] = small, 0.0


@inline_kernel
def _only_normal(
    k: int, small: float, rows: FloatArray, columns: FloatArray, weight: FloatArray, target: FloatArray
) -> None:
    """Give contact k its normal force as first unknown, and that the normal velocity vanishes."""
    rows[k, 0, 0] = rows[k, 0, 1] = columns[k, 0, 0] = columns[k, 0, 1] = 0.0
    rows[k, 0, 2] = columns[k, 0, 2] = 1.0
    weight[k, 0], target[k, 0] = small, 0.0


@inline_kernel
def classify(
    forces: FloatArray, velocities: FloatArray, local: FloatArray, mu: FloatArray, low: FloatArray,
    high: FloatArray, convex: bool, rows: FloatArray, columns: FloatArray, weight: FloatArray,
    jump: FloatArray, target: FloatArray, proximal: float, count: IntArray,
) -> None:  # fmt: skip
    """Linearise every contact: its free directions, its equations and the part of the step that is known.

    For contact k and each of its count[k] unknowns c: the force moves by jump[k] + sum_c y_c columns[k, c];
    the equations are rows[k, c] . (u + du) + weight[k, c] y_c = target[k, c].

    Alart and Curnier's equations are λ_n = [λ_n - ρ_n u_n] within the bounds and λ_t = P(λ_t - ρ_t u_t), P
    onto the disc of radius mu λ_n; ρ is one over the block's own diagonal, one number for both tangents, for
    a disc must stay a disc. Beyond a bound the normal force is known (take-off is the bound zero), else u_n =
    0 is asked. Where the tangents' point lies within the disc u_t = 0 is asked. Beyond it, along e, the force
    is put onto the cone and follows the normal force, so that (mu e, 1) is its column; Coulomb's row is u_n
    alone, the convex law's n . u with n = (mu e, 1) too, which keeps the matrix symmetric. Across e the
    disc's projection turns a point by ratio = radius / length as far, and the point has no part there: λ_t =
    ρ_t u_t across e.

    Forces and velocities are flat, (3n,); `local` is (n, WIDTH), mu and the bounds are (n,). Filled: rows and
    columns (n, 3, 3), jump, weight and target (n, 3), count (n,).
    """
    for k in range(mu.size):
        i = 3 * k
        W00, W11, W22 = local[k, 0], local[k, 3], local[k, 5]
        # a proximal term pulls the step, not the force, towards zero: it
        # vanishes with the step and moves no solution
        small = proximal * (W00 + W11 + W22)
        jump[k, 0] = jump[k, 1] = jump[k, 2] = 0.0
        if low[k] == -np.inf:  # bilateral: any force, u = 0
            _stick(k, 3, small, rows, columns, weight, target)
            count[k] = 3
            continue
        x, y, z = forces[i], forces[i + 1], forces[i + 2]
        p, q, r = velocities[i], velocities[i + 1], velocities[i + 2]
        # the natural map's point λ - u / w tells the mode (Alart and Curnier 1991)
        step_t, step_n = 1.0 / max(W00, W11), 1.0 / W22
        wx, wy = x - step_t * p, y - step_t * q
        length = math.sqrt(wx * wx + wy * wy)
        lifted = z - step_n * r
        if convex and mu[k] > 0.0 and length > mu[k] * min(max(lifted, low[k]), high[k]):
            # where the contact slides, the convex law adds mu ||u_t|| to its normal velocity
            lifted = z - step_n * (r - mu[k] * math.sqrt(p * p + q * q))
        held = lifted <= low[k] or lifted >= high[k]
        normal = min(max(lifted, low[k]), high[k])
        radius = mu[k] * normal
        if held:  # at a bound the normal force is known
            jump[k, 2] = normal - z
        if radius == 0.0 and (held or mu[k] == 0.0):  # no tangential force at all
            jump[k, 0], jump[k, 1] = -x, -y
            count[k] = 0
            if not held:
                _only_normal(k, small, rows, columns, weight, target)
                count[k] = 1
            continue
        if length <= radius:  # it sticks: the velocity of every free direction vanishes
            count[k] = 2 if held else 3
            _stick(k, count[k], small, rows, columns, weight, target)
            continue
        ex, ey = wx / length, wy / length  # it slides along e
        ratio = radius / length
        # on the cone: the part along e follows the normal force, the part across it turns
        change = mu[k] * (normal if held else z) - (x * ex + y * ey)
        jump[k, 0], jump[k, 1] = change * ex, change * ey
        c = 0
        if not held:
            _only_normal(k, small, rows, columns, weight, target)
            columns[k, 0, 0], columns[k, 0, 1] = mu[k] * ex, mu[k] * ey
            if convex:
                rows[k, 0, 0], rows[k, 0, 1] = mu[k] * ex, mu[k] * ey
            c = 1
        # across e the projection's slope is the ratio, so that (1 - ratio) w y + ratio du = -u there
        columns[k, c, 0], columns[k, c, 1], columns[k, c, 2] = -ey, ex, 0.0
        rows[k, c, 0], rows[k, c, 1], rows[k, c, 2] = -ratio * ey, ratio * ex, 0.0
        target[k, c] = (ratio - 1.0) * (q * ex - p * ey)
        weight[k, c] = (1.0 - ratio) / step_t + small
        count[k] = c + 1


@inline_kernel
def _assemble(
    G: FloatArray, velocities: FloatArray, rows: FloatArray, columns: FloatArray, weight: FloatArray,
    jump: FloatArray, target: FloatArray, count: IntArray, moved: FloatArray, A: FloatArray, b: FloatArray,
) -> int:  # fmt: skip
    """Fill the reduced matrix and right-hand side of the linearised equations; return their size."""
    n = count.size
    for j in range(moved.size):
        moved[j] = velocities[j]  # u after the known part of the step
    for k in range(n):
        # the known part (take-off, forces onto the cone or a bound) moves
        # every velocity; most contacts have none
        x, y, z = jump[k, 0], jump[k, 1], jump[k, 2]
        if x != 0.0 or y != 0.0 or z != 0.0:
            for j in range(moved.size):
                moved[j] += G[3 * k, j] * x + G[3 * k + 1, j] * y + G[3 * k + 2, j] * z
    i = 0
    for k in range(n):
        for c in range(count[k]):
            x, y, z = rows[k, c, 0], rows[k, c, 1], rows[k, c, 2]
            at = 0
            for h in range(n):
                few = count[h]
                # a contact that takes off has no unknown, hence neither row nor column: the
                # system shrinks to what is in contact
                if few == 0:
                    continue
                j = 3 * h
                if count[k] == 3:  # three unknowns are the three components, here and below
                    p, q, r = G[3 * k + c, j], G[3 * k + c, j + 1], G[3 * k + c, j + 2]
                else:
                    p = x * G[3 * k, j] + y * G[3 * k + 1, j] + z * G[3 * k + 2, j]
                    q = x * G[3 * k, j + 1] + y * G[3 * k + 1, j + 1] + z * G[3 * k + 2, j + 1]
                    r = x * G[3 * k, j + 2] + y * G[3 * k + 1, j + 2] + z * G[3 * k + 2, j + 2]
                if few == 3:
                    A[i, at], A[i, at + 1], A[i, at + 2] = p, q, r
                    at += 3
                    continue
                for d in range(few):
                    A[i, at] = p * columns[h, d, 0] + q * columns[h, d, 1] + r * columns[h, d, 2]
                    at += 1
            A[i, i] += weight[k, c]
            b[i] = target[k, c] - (moved[3 * k] * x + moved[3 * k + 1] * y + moved[3 * k + 2] * z)
            i += 1
    return i


@inline_kernel
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


@inline_kernel
def newton_dense(
    G: FloatArray, g: FloatArray, mu: FloatArray, low: FloatArray, high: FloatArray, convex: bool,
    tol: float, limit: int, share: float, local: FloatArray, forces: FloatArray, velocities: FloatArray,
) -> tuple[int, float]:  # fmt: skip
    """Take Newton steps while the velocity error falls well; return the steps and the error reached.

    Forces and velocities (flat, consistent) are updated in place and never get worse.
    """
    n = mu.size
    m = 3 * n
    A, kinds = np.empty((m, m)), np.empty(n, dtype=np.int64)
    directions, known, vectors = np.empty((2, n, 3, 3)), np.empty((3, n, 3)), np.empty((5, m))
    # few allocations and no reshaping: both take as long as a step
    rows, columns = directions[0], directions[1]
    weight, jump, target = known[0], known[1], known[2]
    moved, b, step, best_forces, best_velocities = vectors[0], vectors[1], vectors[2], vectors[3], vectors[4]
    relative = velocity_error(forces, velocities, mu, low, high, local, convex)
    best = relative
    for j in range(m):
        best_forces[j], best_velocities[j] = forces[j], velocities[j]
    done = since = 0
    while done < limit and best > tol and since < PATIENCE:
        done += 1
        # the proximal term shrinks with the error: damped far away, Newton's own step near the solution
        classify(
            forces, velocities, local, mu, low, high, convex, rows, columns, weight, jump, target,
            max(PROXIMAL, min(PROXIMAL_FAR, share * relative)), kinds,
        )  # fmt: skip
        m = _assemble(G, velocities, rows, columns, weight, jump, target, kinds, moved, A, b)
        plain = True  # all of them stick, or carry nothing: G itself, symmetric
        for k in range(n):
            plain = plain and (kinds[k] == 3 or kinds[k] == 0)
        if not (symmetric_solve(A, b, m) if plain else lu_solve(A, b, m)):
            break
        spread(columns, jump, kinds, b, step)
        # a full step, however bad the error after it: who slides is found by going there
        for j in range(step.size):
            forces[j] += step[j]
        # from the forces anew: updated velocities would drift
        refresh_dense(G, g, forces, velocities)
        relative = velocity_error(forces, velocities, mu, low, high, local, convex)
        since += 1
        if relative < best:
            # progress by less than a tenth counts as none
            if relative < 0.9 * best:
                since = 0
            best = relative
            if best <= tol:
                return done, best
            for j in range(step.size):
                best_forces[j], best_velocities[j] = forces[j], velocities[j]
    # steps are not monotone: what is handed back is the best point on the way
    for j in range(step.size):
        forces[j], velocities[j] = best_forces[j], best_velocities[j]
    return done, best


@inline_kernel
def _root_power(base: float, halves: int) -> float:
    """Return base to the power of halves / 2; `pow` would take as long as half a sweep."""
    out = math.sqrt(base) if halves % 2 else 1.0
    for _ in range(halves // 2):
        out *= base
    return out


@inline_kernel
def run_dense(
    G: FloatArray, g: FloatArray, mu: FloatArray, low: FloatArray, high: FloatArray, convex: bool,
    local: FloatArray, tol: float, first: int, last_round: int, burst: int, most: int, forces: FloatArray,
    velocities: FloatArray,
) -> tuple[int, float]:  # fmt: skip
    """Alternate Gauss-Seidel sweeps with Newton steps, at most so many; return their number and the error.

    G is (3n, 3n); mu and the bounds are (n,), g, forces and velocities (3n,); `local` (n, WIDTH) is what
    `nsgs.fill_dense` filled. The rounds are those from `first` on, up to but without `last_round`.
    """
    refresh_dense(G, g, forces, velocities)
    done = 0
    relative = last = np.inf
    relax = 1.0
    patience = 2 * WORTH + mu.size
    for attempt in range(first, last_round):
        count, before = 0, np.inf
        while done < most:
            sweep_dense(G, local, mu, low, high, convex, relax, forces, velocities)
            done += 1
            count += 1
            relative = velocity_error(forces, velocities, mu, low, high, local, convex)
            # swept velocities are sums of changes: whether it is solved is asked again of G λ + g itself
            if relative <= tol:
                refresh_dense(G, g, forces, velocities)
                relative = velocity_error(forces, velocities, mu, low, high, local, convex)
            # linear convergence: the error falls by this factor a sweep
            rate, before = relative / before, relative
            if relative <= tol:
                break
            # a Newton step costs as much as so many sweeps: go on where these will do
            if count >= burst and not tol > relative * _root_power(rate, patience):
                break
            if count >= burst + 30:
                break
        if relative <= tol or done >= most:
            break
        refresh_dense(G, g, forces, velocities)
        # a round that does not halve the error: sweeps that go in circles are relaxed
        if relative > 0.5 * last and burst > 20:
            relax = max(0.6 * relax, 0.1)
        last = relative
        # another proximal term each round: what one misses, the next may find
        share = PROXIMAL_SHARES[attempt % 3]
        used, relative = newton_dense(
            G, g, mu, low, high, convex, tol, min(20, most - done), share, local, forces, velocities
        )  # fmt: skip
        done += used
        if relative <= tol:
            break
        burst = min(2 * burst, 200)
    return done, relative
