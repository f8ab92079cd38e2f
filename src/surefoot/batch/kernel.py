"""One contact problem and its gradient as compiled functions, for loops over many and for a caller's own.

`solve_contacts`, `contact_vjp` and `contact_jvp` may be called from any function under `numba.njit`; they
hold no state, allocate their own scratch, and release nothing. Up to 45 contacts on exact cones.

The derivative is that of `contact.derivative`, at the forces as they are solved (not polished): its error is
that of the solution times the condition. At a kink it belongs to the mode that the natural map is on.
"""

from __future__ import annotations

import numpy as np

from surefoot.arrays import FloatArray, IntArray
from surefoot.contact.blocks import checked_mirror
from surefoot.contact.derivative_system import RANK
from surefoot.contact.problem import ASYMMETRY
from surefoot.kernels import inline_kernel, kernel
from surefoot.solvers.auto import solve_compiled
from surefoot.solvers.elimination import lu_solve
from surefoot.solvers.newton import classify

NOT_NUMBERS, DOUBTFUL = -(1 << 40), -(1 << 40) - 1
"""What `solve_contacts` returns for a G or g that is not finite, and for a G that is not symmetric positive
semidefinite as far as it looks."""
SINGULAR = 1e-10
"""Pivots below this share of the matrix are looked at again, by singular values."""


@kernel
def solve_contacts(
    G: FloatArray, g: FloatArray, laws: FloatArray, convex: bool, tol: float, most: int, warm: bool,
    buffer: FloatArray,
) -> int:  # fmt: skip
    """Solve one contact problem; return the iterations, bit by bit turned (negative) if it is not solved.

    Parameters
    ----------
    G, g
        (3n, 3n) Delassus operator with its compliance, and (3n,) free velocity, C-contiguous.
    laws
        (3, n): mu, normal_min (-inf for a bilateral contact) and normal_max.
    convex
        Whether the law is convex; else Coulomb's.
    tol, most
        Wanted velocity error, and the bound on iterations (-1 for the methods' own).
    warm
        Whether the buffer holds forces to start from.
    buffer
        (2n + 3, 3) to be filled: forces, velocities, and the seven numbers of `Residuals`.
    """
    m = g.size
    packed = np.empty((m + 3, m))
    total = 0.0
    for i in range(m):
        for j in range(m):
            packed[i, j] = G[i, j]
        packed[m, i] = g[i]
        total += g[i]
    for a in range(3):
        for k in range(m // 3):
            packed[m + 1, a * (m // 3) + k] = laws[a, k]
    packed[m + 2, 0] = 1.0 if convex else 0.0
    scale, gap, _, _ = checked_mirror(packed[:m], ASYMMETRY)
    if not abs(total) + scale < np.inf:
        return NOT_NUMBERS
    if gap < 0.0 or gap > ASYMMETRY * scale:
        return DOUBTFUL
    return solve_compiled(packed, tol, most, 0, warm, buffer)


@inline_kernel
def _linearise(
    G: FloatArray, laws: FloatArray, convex: bool, buffer: FloatArray, flat: FloatArray, rows: FloatArray,
    columns: FloatArray, known: FloatArray, count: IntArray,
) -> int:  # fmt: skip
    """Fill the modes' rows (n, c, 3), columns (n, c, 3) and weights; return the number of unknowns."""
    n = laws.shape[1]
    local = np.empty((n, 6))
    for k in range(n):
        i = 3 * k
        local[k, 0], local[k, 3], local[k, 5] = G[i, i], G[i + 1, i + 1], G[i + 2, i + 2]
        for a in (0, 3, 5):
            local[k, a] = local[k, a] if local[k, a] > 0.0 else 1.0
        for a in range(3):
            flat[0, i + a], flat[1, i + a] = buffer[k, a], buffer[n + k, a]
    classify(
        flat[0], flat[1], local, laws[0], laws[1], laws[2], convex, rows, columns, known[0], known[1],
        known[2], 0.0, count,
    )  # fmt: skip
    size = 0
    for k in range(n):
        size += count[k]
    return size


@inline_kernel
def _fill(
    G: FloatArray, rows: FloatArray, columns: FloatArray, weight: FloatArray, count: IntArray,
    transposed: bool, A: FloatArray,
) -> None:  # fmt: skip
    """Fill the active matrix R G C + W, or its transpose."""
    n, i = count.size, 0
    for k in range(n):
        for c in range(count[k]):
            x, y, z = rows[k, c, 0], rows[k, c, 1], rows[k, c, 2]
            at, b = 0, 3 * k
            for h in range(n):
                if count[h] == 0:
                    continue
                j = 3 * h
                p = x * G[b, j] + y * G[b + 1, j] + z * G[b + 2, j]
                q = x * G[b, j + 1] + y * G[b + 1, j + 1] + z * G[b + 2, j + 1]
                r = x * G[b, j + 2] + y * G[b + 1, j + 2] + z * G[b + 2, j + 2]
                for d in range(count[h]):
                    value = p * columns[h, d, 0] + q * columns[h, d, 1] + r * columns[h, d, 2]
                    if transposed:
                        A[at, i] = value
                    else:
                        A[i, at] = value
                    at += 1
            A[i, i] += weight[k, c]
            i += 1


@inline_kernel
def _regular(A: FloatArray, m: int) -> bool:
    """Tell whether the pivots that an elimination left on A's diagonal are all clear of rounding."""
    most, least = 0.0, np.inf
    for i in range(m):
        most, least = max(most, abs(A[i, i])), min(least, abs(A[i, i]))
    return least > SINGULAR * most


@kernel
def _least_squares(A: FloatArray, b: FloatArray, m: int, extra: FloatArray) -> None:
    """Replace b by A⁺ b, plus the part of `extra` that Aᵀ sends to zero; put in extra what A cannot reach of b.

    For redundant contacts: A is singular.
    """
    left, values, right = np.linalg.svd(A[:m, :m].copy())
    out, rest = np.zeros(m), b[:m].copy()
    added = extra[:m].copy()
    for k in range(m):
        if not values[k] > RANK * values[0]:
            continue
        along = over = 0.0
        for i in range(m):
            along += left[i, k] * b[i]
            over += right[k, i] * extra[i]
        for i in range(m):
            out[i] += right[k, i] * along / values[k]
            rest[i] -= left[i, k] * along
            added[i] -= right[k, i] * over
    for i in range(m):
        b[i], extra[i] = out[i] + added[i], rest[i]


@inline_kernel
def _along_jump(
    k: int, laws: FloatArray, columns: FloatArray, forces: FloatArray, velocities: FloatArray, count: IntArray,
    convex: bool, changes: FloatArray,
) -> None:  # fmt: skip
    """Fill changes (4, 3): the step of contact k's force per mu, normal_min, normal_max; a target per mu."""
    for i in range(4):
        for a in range(3):
            changes[i, a] = 0.0
    mu, low, high = laws[0, k], laws[1, k], laws[2, k]
    if low == -np.inf:
        return
    z, few = forces[3 * k + 2], count[k]
    # a free normal force is the third component of the first unknown, or of the third where it sticks
    free = few == 3 or (few > 0 and columns[k, 0, 2] != 0.0)
    sticks = few == 3 or (few == 2 and not free)
    ux, uy = velocities[3 * k], velocities[3 * k + 1]
    ex, ey = 0.0, 0.0
    if not sticks:
        x, y = forces[3 * k], forces[3 * k + 1]
        size = np.sqrt(x * x + y * y)
        if mu * z > 0.0 and size > 0.0:
            ex, ey = x / size, y / size
        else:
            size = np.sqrt(ux * ux + uy * uy)
            ex, ey = (-ux / size, -uy / size) if size > 0.0 else (0.0, 0.0)
    changes[0, 0], changes[0, 1] = z * ex, z * ey
    if free:
        changes[3, 0] = -(ex * ux + ey * uy) if convex and not sticks else 0.0
    else:
        lift = velocities[3 * k + 2] - (mu * np.sqrt(ux * ux + uy * uy) if convex else 0.0)
        at = 1 if lift > 0.0 or (lift == 0.0 and z <= low) else 2
        at = 2 if low < high and z >= high else at
        changes[at, 0], changes[at, 1], changes[at, 2] = mu * ex, mu * ey, 1.0


@kernel
def contact_vjp(
    G: FloatArray, laws: FloatArray, convex: bool, buffer: FloatArray, weights: FloatArray, out: FloatArray
) -> bool:
    """Fill the gradient of a number whose gradient with respect to forces and velocities is given.

    Parameters
    ----------
    G, laws, convex, buffer
        As `solve_contacts` took and filled them.
    weights
        (2n, 3): of the forces, then of the velocities.
    out
        (2n, 3) to be filled: rows 0 to n - 1 with respect to g; row n + k with respect to contact k's mu,
        normal_min and normal_max. That with respect to G is the symmetric part of out_g λᵀ, and with respect
        to a compliance out_g λ, entry by entry.

    Returns
    -------
    bool
        Whether the active system is regular; for redundant contacts the gradient is along perturbations
        that they can follow.
    """
    n = laws.shape[1]
    m = 3 * n
    directions, known, flat = np.empty((2, n, 3, 3)), np.empty((3, n, 3)), np.empty((6, m))
    count = np.empty(n, dtype=np.int64)
    rows, columns, weight = directions[0], directions[1], known[0]
    size = _linearise(G, laws, convex, buffer, flat, rows, columns, known, count)
    p, b, back, extra = flat[2], flat[3], flat[4], flat[5]
    for i in range(m):
        p[i] = weights[i // 3, i % 3]
    for i in range(m):
        x = weights[n + i // 3, i % 3]
        if x != 0.0:
            for j in range(m):
                p[j] += G[i, j] * x
    A = np.empty((m, m))
    _fill(G, rows, columns, weight, count, True, A)
    i = 0
    for k in range(n):
        for c in range(count[k]):
            x, y, z = columns[k, c, 0], columns[k, c, 1], columns[k, c, 2]
            b[i] = x * p[3 * k] + y * p[3 * k + 1] + z * p[3 * k + 2]
            i += 1
    regular = size == 0 or (lu_solve(A, b, size) and _regular(A, size))
    if not regular:
        _fill(G, rows, columns, weight, count, True, A)
        i = 0
        for k in range(n):
            for c in range(count[k]):
                x, y, z = columns[k, c, 0], columns[k, c, 1], columns[k, c, 2]
                b[i] = x * p[3 * k] + y * p[3 * k + 1] + z * p[3 * k + 2]
                x, y, z = rows[k, c, 0], rows[k, c, 1], rows[k, c, 2]
                square = x * x + y * y + z * z
                share = 1.0 / square if square > 0.0 else 0.0
                x, y, z = share * x, share * y, share * z
                extra[i] = x * weights[n + k, 0] + y * weights[n + k, 1] + z * weights[n + k, 2]
                i += 1
        _least_squares(A, b, size, extra)
    i = 0
    for k in range(n):
        x = y = z = 0.0
        for c in range(count[k]):
            x += rows[k, c, 0] * b[i]
            y += rows[k, c, 1] * b[i]
            z += rows[k, c, 2] * b[i]
            i += 1
        back[3 * k], back[3 * k + 1], back[3 * k + 2] = x, y, z
    for i in range(m):
        x = back[i]
        out[i // 3, i % 3] = weights[n + i // 3, i % 3] - x
        if x != 0.0:
            for j in range(m):
                p[j] -= G[i, j] * x
    changes, i = np.empty((4, 3)), 0
    for k in range(n):
        _along_jump(k, laws, columns, flat[0], flat[1], count, convex, changes)
        for a in range(3):
            out[n + k, a] = (
                changes[a, 0] * p[3 * k] + changes[a, 1] * p[3 * k + 1] + changes[a, 2] * p[3 * k + 2]
            )
        if changes[3, 0] != 0.0:
            out[n + k, 0] += changes[3, 0] * b[i]
        i += count[k]
    return regular


@kernel
def contact_jvp(
    G: FloatArray, laws: FloatArray, convex: bool, buffer: FloatArray, rates: FloatArray, out: FloatArray
) -> bool:
    """Fill the rates of forces and velocities.

    Parameters
    ----------
    G, laws, convex, buffer
        As `solve_contacts` took and filled them.
    rates
        (2n, 3): rows 0 to n - 1 the rate of u at fixed forces, G' λ + g'; row n + k the rates of contact k's
        mu, normal_min and normal_max.
    out
        (2n, 3) to be filled: the rates of the forces, then of the velocities.

    Returns
    -------
    bool
        Whether the active system is regular, see `contact_vjp`.
    """
    n = laws.shape[1]
    m = 3 * n
    directions, known, flat = np.empty((2, n, 3, 3)), np.empty((3, n, 3)), np.empty((6, m))
    count = np.empty(n, dtype=np.int64)
    rows, columns, weight = directions[0], directions[1], known[0]
    size = _linearise(G, laws, convex, buffer, flat, rows, columns, known, count)
    v, jump, b, extra = flat[2], flat[3], flat[4], flat[5]
    changes, targets = np.empty((4, 3)), np.zeros(n)
    for i in range(m):
        v[i] = rates[i // 3, i % 3]
    for k in range(n):
        _along_jump(k, laws, columns, flat[0], flat[1], count, convex, changes)
        targets[k] = changes[3, 0] * rates[n + k, 0]
        for a in range(3):
            x = 0.0
            for i in range(3):
                x += changes[i, a] * rates[n + k, i] if changes[i, a] != 0.0 else 0.0
            jump[3 * k + a] = x
            if x != 0.0:
                for j in range(m):
                    v[j] += G[3 * k + a, j] * x
    A, tries = np.empty((m, m)), 0
    regular = False
    while not regular and tries < 2:
        _fill(G, rows, columns, weight, count, False, A)
        i = 0
        for k in range(n):
            for c in range(count[k]):
                x, y, z = rows[k, c, 0], rows[k, c, 1], rows[k, c, 2]
                b[i] = (targets[k] if c == 0 else 0.0) - (x * v[3 * k] + y * v[3 * k + 1] + z * v[3 * k + 2])
                extra[i] = 0.0
                i += 1
        tries += 1
        if tries == 2:
            _least_squares(A, b, size, extra)
        else:
            regular = size == 0 or (lu_solve(A, b, size) and _regular(A, size))
    i = 0
    for k in range(n):
        for a in range(3):
            out[n + k, a] = rates[k, a]
        x, y, z = jump[3 * k], jump[3 * k + 1], jump[3 * k + 2]
        for c in range(count[k]):
            x += columns[k, c, 0] * b[i]
            y += columns[k, c, 1] * b[i]
            z += columns[k, c, 2] * b[i]
            if not regular:
                p, q, r = rows[k, c, 0], rows[k, c, 1], rows[k, c, 2]
                square = p * p + q * q + r * r
                share = extra[i] / square if square > 0.0 else 0.0
                out[n + k, 0] += share * p
                out[n + k, 1] += share * q
                out[n + k, 2] += share * r
            i += 1
        out[k, 0], out[k, 1], out[k, 2] = x, y, z
    for i in range(m):
        x = out[i // 3, i % 3]
        if x != 0.0:
            for j in range(m):
                out[n + j // 3, j % 3] += G[i, j] * x
    return regular
