"""The active system of a contact problem, compiled: modes, matrix, and what is singular.

The modes and their equations are those of `contact.derivative_modes`, which is their NumPy twin; a sliding
force without radius has no unknown of its own here.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.contact.derivative_system import RANK
from surefoot.kernels import inline_kernel, kernel

SINGULAR = 1e-10
"""Pivots below this share of the matrix are looked at again, by singular values."""
STICK, SLIDE, BARE = 1.0, 2.0, 0.0
"""What the tangential force of a contact does: free, on the cone, or nothing (no friction, no load)."""
FREE, HELD, AT_LOW, AT_HIGH = 0.0, 1.0, 2.0, 3.0
"""What its normal force does, the bounds last; a bilateral contact is held."""


@inline_kernel
def read_modes(G: FloatArray, laws: FloatArray, convex: bool, buffer: FloatArray, mode: FloatArray) -> int:
    """Fill mode (n, 8): normal, tangent, e, ratio, weight, ||u_t|| and λ_n; return the number of unknowns.

    G is (3n, 3n), the laws (3, n) mu and bounds, the buffer (2n + 3, 3) forces and velocities. The modes and
    their equations are those of `contact.derivative_modes`; a sliding force without radius has no unknown of
    its own.
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
        # bilateral: three free directions
        if low == -np.inf:
            mode[k, 0], mode[k, 1] = HELD, STICK
            size += 3
            continue
        weight, own = max(G[i, i], G[i + 1, i + 1]), G[i + 2, i + 2]
        weight, own = weight if weight > 0.0 else 1.0, own if own > 0.0 else 1.0
        # the natural map's point λ - u / w; w here the diagonal of the block, sign and order are what counts
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
        # inside its disc: it sticks
        if length <= radius and radius > 0.0:
            size += 2
            continue
        if length > 0.0:
            mode[k, 2], mode[k, 3] = a / length, b / length
        # a disc without radius has no direction to turn in
        mode[k, 1] = BARE
        if radius > 0.0:
            # on the cone: ratio of radii, and (1 - ratio) w against turning
            mode[k, 1], mode[k, 4] = SLIDE, radius / length
            mode[k, 5] = (1.0 - mode[k, 4]) * weight
            size += 1
    return size


@inline_kernel
def fill(
    G: FloatArray, laws: FloatArray, mode: FloatArray, rows_lean: bool, columns_lean: bool, transposed: bool,
    A: FloatArray,
) -> None:  # fmt: skip
    """Fill the active matrix R G C + W in the first rows of A, or its transpose.

    G is (3n, 3n), laws (3, n), mode (n, 8) from `read_modes`; A has at least a row for each of the k unknowns
    and 3n columns, of which the first k are left in the end. A row that leans is mu e, 1 where a contact
    slides, as the columns are (and the convex law's equations); else it is 0, 0, 1. First the rows times G,
    then, in place, that times the columns.
    """
    n, m, i = laws.shape[1], G.shape[0], 0
    for k in range(n):
        b = 3 * k
        normal, tangent, mu = mode[k, 0], mode[k, 1], laws[0, k]
        ex, ey = mode[k, 2], mode[k, 3]
        if tangent == STICK:
            for a in range(3 if normal < AT_LOW else 2):
                for j in range(m):
                    A[i, j] = G[b + a, j]
                i += 1
            continue
        if normal == FREE:
            # the row of the normal: with the sliding force it drags along, R or C as asked
            p, q = (mu * ex, mu * ey) if rows_lean and tangent == SLIDE else (0.0, 0.0)
            for j in range(m):
                A[i, j] = p * G[b, j] + q * G[b + 1, j] + G[b + 2, j]
            i += 1
        if tangent == SLIDE:
            # the row across e, shrunk by the ratio
            share = 1.0 if transposed else mode[k, 4]
            p, q = -share * ey, share * ex
            for j in range(m):
                A[i, j] = p * G[b, j] + q * G[b + 1, j]
            i += 1
    # the columns in place: a contact's unknowns never outnumber its rows
    for r in range(i):
        at = 0
        for k in range(n):
            b = 3 * k
            normal, tangent, mu = mode[k, 0], mode[k, 1], laws[0, k]
            x, y, z = A[r, b], A[r, b + 1], A[r, b + 2]
            if tangent == STICK:
                A[r, at], A[r, at + 1] = x, y
                at += 2
                if normal < AT_LOW:
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
def gather(laws: FloatArray, mode: FloatArray, lean: bool, rows: bool, x: FloatArray, b: FloatArray) -> None:
    """Fill b (k,) with Cᵀ x, or with R x, for x (3n,)."""
    i = 0
    for k in range(laws.shape[1]):
        h = 3 * k
        normal, tangent = mode[k, 0], mode[k, 1]
        if tangent == STICK:
            b[i], b[i + 1] = x[h], x[h + 1]
            i += 2
            if normal < AT_LOW:
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
def scatter(laws: FloatArray, mode: FloatArray, lean: bool, rows: bool, b: FloatArray, x: FloatArray) -> None:
    """Fill x (3n,) with C b, or with Rᵀ b, for b (k,)."""
    i = 0
    for k in range(laws.shape[1]):
        h = 3 * k
        normal, tangent = mode[k, 0], mode[k, 1]
        x[h] = x[h + 1] = x[h + 2] = 0.0
        if tangent == STICK:
            x[h], x[h + 1] = b[i], b[i + 1]
            i += 2
            if normal < AT_LOW:
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
def unscale(laws: FloatArray, mode: FloatArray, lean: bool, x: FloatArray) -> None:
    """Divide x (k,) by the squares of the equations' rows: R Rᵀ, which is diagonal."""
    i = 0
    for k in range(laws.shape[1]):
        normal, tangent = mode[k, 0], mode[k, 1]
        if tangent == STICK:
            i += 3 if normal < AT_LOW else 2
            continue
        if normal == FREE:
            x[i] /= 1.0 + laws[0, k] ** 2 if lean and tangent == SLIDE else 1.0
            i += 1
        if tangent == SLIDE:
            x[i] /= mode[k, 4] ** 2
            i += 1


@inline_kernel
def regular_pivots(A: FloatArray, m: int) -> bool:
    """Tell whether the m pivots that an elimination left on A's diagonal (at least (m, m)) clear rounding."""
    most, least = 0.0, np.inf
    for i in range(m):
        most, least = max(most, abs(A[i, i])), min(least, abs(A[i, i]))
    return least > SINGULAR * most


@kernel
def least_squares(A: FloatArray, b: FloatArray, m: int, extra: FloatArray) -> None:
    """Replace b by A⁺ b, plus the part of `extra` that A sends to zero; leave in extra what A misses of b.

    For redundant contacts: A, the first (m, m) of its memory, is singular; b and extra are (m,) of theirs.
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
def add_product(G: FloatArray, x: FloatArray, sign: float, out: FloatArray) -> None:
    """Add sign · G x to out (m,) for x (m,); G (m, m) is symmetric."""
    for i in range(x.size):
        a = sign * x[i]
        if a != 0.0:
            for j in range(x.size):
                out[j] += a * G[i, j]


@inline_kernel
def unknowns(normal: float, tangent: float) -> int:
    """Return the number of unknowns of a mode."""
    return (1 if normal < AT_LOW else 0) + (2 if tangent == STICK else (1 if tangent == SLIDE else 0))
