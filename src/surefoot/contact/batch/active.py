"""The active system of a contact problem, compiled: modes, matrix, and what is singular.

The modes and their equations are those of `contact.derivative.modes`, which is their NumPy twin; a sliding
force without radius has no unknown of its own here.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.base.numerics.vectors import Three
from surefoot.contact.derivative.active_system import RANK

SINGULAR = 1e-10
"""Pivots below this share of the matrix are looked at again, by singular values."""
STICK, SLIDE, BARE = 1.0, 2.0, 0.0
"""What the tangential force of a contact does: free, on the cone, or nothing (no friction, no load)."""
FREE, HELD, AT_LOW, AT_HIGH = 0.0, 1.0, 2.0, 3.0
"""What its normal force does, the bounds last; a bilateral contact is held."""
WEIGHT, COLUMN, ROW, FIRST = 0, 1, 4, 8
"""Columns of the unknowns: W, and three numbers each of C and R; of the modes: a contact's first unknown."""


@inline_kernel
def read_modes(G: FloatArray, laws: FloatArray, convex: bool, buffer: FloatArray, mode: FloatArray) -> None:
    """Fill mode (n, 9): normal, tangent, e, ratio, weight, ||u_t|| and λ_n, and room for `list_unknowns`.

    G is (3n, 3n), the laws (3, n) mu and bounds, the buffer (2n + 3, 3) forces and velocities. The modes and
    their equations are those of `contact.derivative.modes`; a sliding force without radius has no unknown of
    its own.
    """
    n = laws.shape[1]
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
            continue
        weight, own = max(G[i, i], G[i + 1, i + 1]), G[i + 2, i + 2]
        weight, own = weight if weight > 0.0 else 1.0, own if own > 0.0 else 1.0
        # the natural map's point λ - u / w; w here the diagonal of the block, sign and order are what counts
        lifted = z - (r - (mu * slip if convex else 0.0)) / own
        normal = FREE
        if lifted <= low:
            # the disc's radius is that of the height that the natural map
            # projects to, not of the force at hand
            normal, z = AT_LOW, low
        elif lifted >= high:
            normal, z = AT_HIGH, high
        radius = mu * z
        a, b = x - p / weight, y - q / weight
        length = math.sqrt(a * a + b * b)
        mode[k, 0], mode[k, 1] = normal, STICK
        # inside its disc: it sticks
        if length <= radius and radius > 0.0:
            continue
        if length > 0.0:
            mode[k, 2], mode[k, 3] = a / length, b / length
        # a disc without radius has no direction to turn in
        mode[k, 1] = BARE
        if radius > 0.0:
            # on the cone: ratio of radii, and (1 - ratio) w against turning
            mode[k, 1], mode[k, 4] = SLIDE, radius / length
            mode[k, 5] = (1.0 - mode[k, 4]) * weight


@inline_kernel
def _note(unknown: FloatArray, i: int, weight: float, column: Three, row: Three) -> None:
    unknown[i, WEIGHT] = weight
    unknown[i, COLUMN], unknown[i, COLUMN + 1], unknown[i, COLUMN + 2] = column
    unknown[i, ROW], unknown[i, ROW + 1], unknown[i, ROW + 2] = row


@inline_kernel
def list_unknowns(laws: FloatArray, mode: FloatArray, convex: bool, unknown: FloatArray) -> int:
    """Fill unknown (3n, 7) with the active system's unknowns, contact by contact; return their number.

    An unknown moves its contact's force along a column of C; its equation is a row of R and a weight W. The
    laws are (3, n), mode (n + 1, 9) from `read_modes`; its last column gets each contact's first unknown.
    """
    size = 0
    for k in range(laws.shape[1]):
        normal, tangent, mu, ratio = mode[k, 0], mode[k, 1], laws[0, k], mode[k, 4]
        ex, ey = mode[k, 2], mode[k, 3]
        mode[k, FIRST] = size
        if tangent == STICK:
            _note(unknown, size, 0.0, (1.0, 0.0, 0.0), (1.0, 0.0, 0.0))
            _note(unknown, size + 1, 0.0, (0.0, 1.0, 0.0), (0.0, 1.0, 0.0))
            size += 2
        if normal < AT_LOW:
            # the normal drags the sliding force along; its equation leans alike under the convex law
            lean = mu if tangent == SLIDE else 0.0
            own = lean if convex else 0.0
            _note(unknown, size, 0.0, (lean * ex, lean * ey, 1.0), (own * ex, own * ey, 1.0))
            size += 1
        if tangent == SLIDE:
            # across e, the equation shrunk by the ratio
            _note(unknown, size, mode[k, 5], (-ey, ex, 0.0), (-ratio * ey, ratio * ex, 0.0))
            size += 1
    mode[laws.shape[1], FIRST] = size
    return size


@inline_kernel
def fill(
    G: FloatArray, mode: FloatArray, unknown: FloatArray, left: int, right: int, row: FloatArray,
    A: FloatArray,
) -> None:  # fmt: skip
    """Fill the active matrix R G C + W in the first rows and columns of A, or its transpose.

    G is (3n, 3n); mode and unknown are what `list_unknowns` filled; `left` and `right` are ROW and COLUMN, or
    COLUMN and ROW for the transpose; row (3n,) is scratch memory.
    """
    for k in range(mode.shape[0] - 1):
        h = 3 * k
        for i in range(int(mode[k, FIRST]), int(mode[k + 1, FIRST])):
            x, y, z = unknown[i, left], unknown[i, left + 1], unknown[i, left + 2]
            for j in range(row.size):
                row[j] = x * G[h, j] + y * G[h + 1, j] + z * G[h + 2, j]
            gather(mode, unknown, right, row, A[i])
            A[i, i] += unknown[i, WEIGHT]


@inline_kernel
def gather(mode: FloatArray, unknown: FloatArray, side: int, x: FloatArray, b: FloatArray) -> None:
    """Fill b (k,) with Cᵀ x (side COLUMN), or with R x (ROW), for x (3n,); see `fill`."""
    for k in range(mode.shape[0] - 1):
        p, q, r = x[3 * k], x[3 * k + 1], x[3 * k + 2]
        for i in range(int(mode[k, FIRST]), int(mode[k + 1, FIRST])):
            b[i] = unknown[i, side] * p + unknown[i, side + 1] * q + unknown[i, side + 2] * r


@inline_kernel
def scatter(mode: FloatArray, unknown: FloatArray, side: int, b: FloatArray, x: FloatArray) -> None:
    """Fill x (3n,) with C b (side COLUMN), or with Rᵀ b (ROW), for b (k,); see `fill`."""
    for k in range(mode.shape[0] - 1):
        p = q = r = 0.0
        for i in range(int(mode[k, FIRST]), int(mode[k + 1, FIRST])):
            p += unknown[i, side] * b[i]
            q += unknown[i, side + 1] * b[i]
            r += unknown[i, side + 2] * b[i]
        x[3 * k], x[3 * k + 1], x[3 * k + 2] = p, q, r


@inline_kernel
def unscale(unknown: FloatArray, size: int, x: FloatArray) -> None:
    """Divide x (k,) by the squares of the equations' rows: R Rᵀ, which is diagonal."""
    for i in range(size):
        x[i] /= unknown[i, ROW] ** 2 + unknown[i, ROW + 1] ** 2 + unknown[i, ROW + 2] ** 2


@inline_kernel
def regular_pivots(A: FloatArray, m: int) -> bool:
    """Tell whether the m pivots that an elimination left on A's diagonal (at least (m, m)) clear rounding."""
    # cheap, and no proof: pivots bound no singular value, so that the doubtful go to the SVD
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
        # singular directions: redundant contacts, whose forces are of least norm, or what no force reaches
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
