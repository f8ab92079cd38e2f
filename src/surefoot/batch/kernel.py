"""One contact problem and its gradient as compiled functions, for loops over many and for a caller's own.

`solve_contacts`, `contact_vjp` and `contact_jvp` may be called from any function under `numba.njit`; they
hold no state, allocate their own scratch, and release nothing. Up to 45 contacts on exact cones.

The derivative is that of `contact.derivative`, at the forces as they are solved (not polished): its error is
that of the solution times the condition. At a kink it belongs to the mode that the natural map is on.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.contact.blocks import checked_mirror
from surefoot.contact.derivative_system import RANK
from surefoot.kernels import inline_kernel, kernel
from surefoot.solvers.auto import solve_compiled
from surefoot.solvers.elimination import lu_solve

NOT_NUMBERS, DOUBTFUL = -(1 << 40), -(1 << 40) - 1
"""What `solve_contacts` returns for a G or g that is not finite, and for a G that is not symmetric positive
semidefinite as far as it looks."""
SINGULAR = 1e-10
"""Pivots below this share of the matrix are looked at again, by singular values."""


@kernel
def solve_contacts(
    G: FloatArray, g: FloatArray, laws: FloatArray, convex: bool, asymmetry: float, tol: float, most: int,
    warm: bool, buffer: FloatArray,
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
    asymmetry
        Largest |G - Gᵀ| over largest |G| that is taken for rounding (1e-8; 1e-5 for single precision).
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
    scale, gap, _, _ = checked_mirror(packed[:m], asymmetry)
    if not abs(total) + scale < np.inf:
        return NOT_NUMBERS
    if gap < 0.0 or gap > asymmetry * scale:
        return DOUBTFUL
    return solve_compiled(packed, tol, most, 0, warm, buffer)


STICK, SLIDE, BARE = 1.0, 2.0, 0.0
"""What the tangential force of a contact does: free, on the cone, or nothing (no friction, no load)."""
FREE, AT_LOW, AT_HIGH, HELD = 0.0, 1.0, 2.0, 3.0
"""What its normal force does; a bilateral contact is held."""


@inline_kernel
def read_modes(G: FloatArray, laws: FloatArray, convex: bool, buffer: FloatArray, mode: FloatArray) -> int:
    """Fill mode (n, 8): normal, tangent, e, ratio, weight, ||u_t|| and λ_n; return the number of unknowns.

    The modes and their equations are those of `contact.derivative_modes`; a sliding force without radius has
    no unknown of its own.
    """
    n, size = laws.shape[1], 0
    for k in range(n):
        i = 3 * k
        mu, low, high = laws[0, k], laws[1, k], laws[2, k]
        x, y, z = buffer[k, 0], buffer[k, 1], buffer[k, 2]
        p, q, r = buffer[n + k, 0], buffer[n + k, 1], buffer[n + k, 2]
        slip = math.sqrt(p * p + q * q)
        mode[k, 6], mode[k, 7] = slip, z
        mode[k, 2] = mode[k, 3] = mode[k, 4] = mode[k, 5] = 0.0
        if low == -np.inf:
            mode[k, 0], mode[k, 1] = HELD, STICK
            size += 3
            continue
        weight, own = max(G[i, i], G[i + 1, i + 1]), G[i + 2, i + 2]
        weight, own = weight if weight > 0.0 else 1.0, own if own > 0.0 else 1.0
        lifted = z - (r - (mu * slip if convex else 0.0)) / own
        normal = FREE
        if lifted <= low:
            normal, z = AT_LOW, low
        elif lifted >= high:
            normal, z = AT_HIGH, high
        size += 1 if normal == FREE else 0
        radius = mu * z
        a, b = x - p / weight, y - q / weight
        length = math.sqrt(a * a + b * b)
        mode[k, 0], mode[k, 1] = normal, STICK
        if length <= radius and radius > 0.0:
            size += 2
            continue
        if length > 0.0:
            mode[k, 2], mode[k, 3] = a / length, b / length
        mode[k, 1] = BARE
        if radius > 0.0:
            mode[k, 1], mode[k, 4] = SLIDE, radius / length
            mode[k, 5] = (1.0 - mode[k, 4]) * weight
            size += 1
    return size


@inline_kernel
def _fill(
    G: FloatArray, laws: FloatArray, mode: FloatArray, rows_lean: bool, columns_lean: bool, transposed: bool,
    A: FloatArray,
) -> None:  # fmt: skip
    """Fill the active matrix R G C + W in the first rows of A, or its transpose.

    A row that leans is mu e, 1 where a contact slides, as the columns are (and the convex law's equations); else
    it is 0, 0, 1. First the rows times G, then, in place, that times the columns.
    """
    n, m, i = laws.shape[1], G.shape[0], 0
    for k in range(n):
        b = 3 * k
        normal, tangent, mu = mode[k, 0], mode[k, 1], laws[0, k]
        ex, ey = mode[k, 2], mode[k, 3]
        if tangent == STICK:
            for a in range(3 if normal == FREE or normal == HELD else 2):
                for j in range(m):
                    A[i, j] = G[b + a, j]
                i += 1
            continue
        if normal == FREE:
            p, q = (mu * ex, mu * ey) if rows_lean and tangent == SLIDE else (0.0, 0.0)
            for j in range(m):
                A[i, j] = p * G[b, j] + q * G[b + 1, j] + G[b + 2, j]
            i += 1
        if tangent == SLIDE:
            share = 1.0 if transposed else mode[k, 4]
            p, q = -share * ey, share * ex
            for j in range(m):
                A[i, j] = p * G[b, j] + q * G[b + 1, j]
            i += 1
    for r in range(i):
        at = 0
        for k in range(n):
            b = 3 * k
            normal, tangent, mu = mode[k, 0], mode[k, 1], laws[0, k]
            x, y, z = A[r, b], A[r, b + 1], A[r, b + 2]
            if tangent == STICK:
                A[r, at], A[r, at + 1] = x, y
                at += 2
                if normal == FREE or normal == HELD:
                    A[r, at] = z
                    at += 1
                continue
            ex, ey = mode[k, 2], mode[k, 3]
            if normal == FREE:
                A[r, at] = mu * (ex * x + ey * y) + z if columns_lean and tangent == SLIDE else z
                at += 1
            if tangent == SLIDE:
                A[r, at] = (mode[k, 4] if transposed else 1.0) * (ex * y - ey * x)
                if at == r:
                    A[r, at] += mode[k, 5]
                at += 1


@inline_kernel
def _gather(
    laws: FloatArray, mode: FloatArray, lean: bool, rows: bool, x: FloatArray, b: FloatArray
) -> None:
    """Fill b with Cᵀ x, or with R x."""
    i = 0
    for k in range(laws.shape[1]):
        h = 3 * k
        normal, tangent = mode[k, 0], mode[k, 1]
        if tangent == STICK:
            b[i], b[i + 1] = x[h], x[h + 1]
            i += 2
            if normal == FREE or normal == HELD:
                b[i] = x[h + 2]
                i += 1
            continue
        ex, ey = mode[k, 2], mode[k, 3]
        if normal == FREE:
            b[i] = x[h + 2]
            if lean and tangent == SLIDE:
                b[i] += laws[0, k] * (ex * x[h] + ey * x[h + 1])
            i += 1
        if tangent == SLIDE:
            b[i] = (mode[k, 4] if rows else 1.0) * (ex * x[h + 1] - ey * x[h])
            i += 1


@inline_kernel
def _scatter(
    laws: FloatArray, mode: FloatArray, lean: bool, rows: bool, b: FloatArray, x: FloatArray
) -> None:
    """Fill x with C b, or with Rᵀ b."""
    i = 0
    for k in range(laws.shape[1]):
        h = 3 * k
        normal, tangent = mode[k, 0], mode[k, 1]
        x[h] = x[h + 1] = x[h + 2] = 0.0
        if tangent == STICK:
            x[h], x[h + 1] = b[i], b[i + 1]
            i += 2
            if normal == FREE or normal == HELD:
                x[h + 2] = b[i]
                i += 1
            continue
        ex, ey = mode[k, 2], mode[k, 3]
        if normal == FREE:
            x[h + 2] = b[i]
            if lean and tangent == SLIDE:
                x[h], x[h + 1] = laws[0, k] * ex * b[i], laws[0, k] * ey * b[i]
            i += 1
        if tangent == SLIDE:
            share = (mode[k, 4] if rows else 1.0) * b[i]
            x[h] -= share * ey
            x[h + 1] += share * ex
            i += 1


@inline_kernel
def _unscale(laws: FloatArray, mode: FloatArray, lean: bool, x: FloatArray) -> None:
    """Divide by the squares of the equations' rows: R Rᵀ, which is diagonal."""
    i = 0
    for k in range(laws.shape[1]):
        normal, tangent = mode[k, 0], mode[k, 1]
        if tangent == STICK:
            i += 3 if normal == FREE or normal == HELD else 2
            continue
        if normal == FREE:
            x[i] /= 1.0 + laws[0, k] ** 2 if lean and tangent == SLIDE else 1.0
            i += 1
        if tangent == SLIDE:
            x[i] /= mode[k, 4] ** 2
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
    """Replace b by A⁺ b, plus the part of `extra` that A sends to zero; leave in extra what A misses of b.

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
def _add_product(G: FloatArray, x: FloatArray, sign: float, out: FloatArray) -> None:
    """Add sign · G x to out; G is symmetric."""
    for i in range(x.size):
        a = sign * x[i]
        if a != 0.0:
            for j in range(x.size):
                out[j] += a * G[i, j]


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
    mode, work = np.empty((n, 8)), np.empty((m + 4, m))
    p, b, back = work[m], work[m + 1], work[m + 2]
    size = read_modes(G, laws, convex, buffer, mode)
    for k in range(n):
        for a in range(3):
            p[3 * k + a], back[3 * k + a] = weights[k, a], weights[n + k, a]
    _add_product(G, back, 1.0, p)
    _fill(G, laws, mode, True, convex, True, work)
    _gather(laws, mode, True, False, p, b)
    regular = size == 0 or (lu_solve(work, b, size) and _regular(work, size))
    if not regular:
        extra = work[m + 3]
        _fill(G, laws, mode, True, convex, True, work)
        _gather(laws, mode, True, False, p, b)
        _gather(laws, mode, convex, True, back, extra)
        _unscale(laws, mode, convex, extra)
        _least_squares(work, b, size, extra)
    _scatter(laws, mode, convex, True, b, back)
    _add_product(G, back, -1.0, p)
    i = 0
    for k in range(n):
        h = 3 * k
        out[k, 0], out[k, 1] = weights[n + k, 0] - back[h], weights[n + k, 1] - back[h + 1]
        out[k, 2] = weights[n + k, 2] - back[h + 2]
        normal, tangent, e_p = mode[k, 0], mode[k, 1], mode[k, 2] * p[h] + mode[k, 3] * p[h + 1]
        own = mode[k, 7] * e_p if normal != HELD else 0.0
        if convex and normal == FREE and tangent == SLIDE:
            own += mode[k, 6] * b[i]
        along = p[h + 2] + laws[0, k] * e_p
        out[n + k, 0] = own
        out[n + k, 1], out[n + k, 2] = along if normal == AT_LOW else 0.0, along if normal == AT_HIGH else 0.0
        i += _unknowns(normal, tangent)
    return regular


@inline_kernel
def _unknowns(normal: float, tangent: float) -> int:
    """Return the number of unknowns of a mode."""
    return (1 if normal == FREE or normal == HELD else 0) + (
        2 if tangent == STICK else (1 if tangent == SLIDE else 0)
    )


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
    mode, work = np.empty((n, 8)), np.empty((m + 5, m))
    v, b, jump, extra, moved = work[m], work[m + 1], work[m + 2], work[m + 3], work[m + 4]
    size = read_modes(G, laws, convex, buffer, mode)
    for k in range(n):
        h, mu, normal = 3 * k, laws[0, k], mode[k, 0]
        bound = rates[n + k, 1] if normal == AT_LOW else (rates[n + k, 2] if normal == AT_HIGH else 0.0)
        radius = mode[k, 7] * rates[n + k, 0] + mu * bound if normal != HELD else 0.0
        jump[h], jump[h + 1], jump[h + 2] = radius * mode[k, 2], radius * mode[k, 3], bound
        for a in range(3):
            v[h + a] = rates[k, a]
    _add_product(G, jump, 1.0, v)
    regular = size == 0
    for attempt in range(2):
        if regular:
            break
        _fill(G, laws, mode, convex, True, False, work)
        _gather(laws, mode, convex, True, v, b)
        i = 0
        for k in range(n):
            if convex and mode[k, 0] == FREE and mode[k, 1] == SLIDE:
                b[i] -= mode[k, 6] * rates[n + k, 0]
            i += _unknowns(mode[k, 0], mode[k, 1])
        if attempt == 0:
            regular = lu_solve(work, b, size) and _regular(work, size)
        else:
            for i in range(size):
                extra[i] = 0.0
            _least_squares(work, b, size, extra)
            _unscale(laws, mode, convex, extra)
    _scatter(laws, mode, True, False, b, moved)
    if not regular:
        _scatter(laws, mode, convex, True, extra, v)
    for i in range(m):
        jump[i] -= moved[i]
        out[i // 3, i % 3] = jump[i]
        b[i] = rates[i // 3, i % 3]
        if not regular:
            b[i] -= v[i]
    _add_product(G, jump, 1.0, b)
    for i in range(m):
        out[n + i // 3, i % 3] = b[i]
    return regular
