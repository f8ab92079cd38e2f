"""L D Lᵀ of definite systems of five or six unknowns, written out: those of a wrench."""

from __future__ import annotations

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import inline_kernel

VANISHED = 1e-15
"""A pivot below this share of its diagonal entry counts as zero [-], and its unknown stays zero: rounding."""


@inline_kernel
def _inverse(pivot: float, entry: float) -> float:
    return 1.0 / pivot if pivot > VANISHED * entry else 0.0


@inline_kernel
def factor(H: FloatArray, n: int) -> None:
    """Replace the lower triangle of H (n, n) by L of L D Lᵀ, the diagonal by 1 / D; n is 5 or 6.

    Written out: in loops of five the processor waits for its own stores.
    """
    i0 = _inverse(H[0, 0], H[0, 0])
    c1, c2, c3, c4 = H[1, 0], H[2, 0], H[3, 0], H[4, 0]
    l10, l20, l30, l40 = c1 * i0, c2 * i0, c3 * i0, c4 * i0
    i1 = _inverse(H[1, 1] - l10 * c1, H[1, 1])
    e2, e3, e4 = H[2, 1] - l20 * c1, H[3, 1] - l30 * c1, H[4, 1] - l40 * c1
    l21, l31, l41 = e2 * i1, e3 * i1, e4 * i1
    i2 = _inverse(H[2, 2] - l20 * c2 - l21 * e2, H[2, 2])
    f3, f4 = H[3, 2] - l30 * c2 - l31 * e2, H[4, 2] - l40 * c2 - l41 * e2
    l32, l42 = f3 * i2, f4 * i2
    i3 = _inverse(H[3, 3] - l30 * c3 - l31 * e3 - l32 * f3, H[3, 3])
    g4 = H[4, 3] - l40 * c3 - l41 * e3 - l42 * f3
    l43 = g4 * i3
    i4 = _inverse(H[4, 4] - l40 * c4 - l41 * e4 - l42 * f4 - l43 * g4, H[4, 4])
    H[0, 0], H[1, 1], H[2, 2], H[3, 3], H[4, 4] = i0, i1, i2, i3, i4
    H[1, 0], H[2, 0], H[3, 0], H[4, 0] = l10, l20, l30, l40
    H[2, 1], H[3, 1], H[4, 1], H[3, 2], H[4, 2], H[4, 3] = l21, l31, l41, l32, l42, l43
    if n == 6:
        last = H[5, 5]
        for j in range(5):
            t = H[5, j]
            for k in range(j):
                t -= H[5, k] * H[j, k]
            H[5, j] = t
        pivot = last
        for j in range(5):
            t = H[5, j]
            H[5, j] = t * H[j, j]
            pivot -= t * H[5, j]
        H[5, 5] = _inverse(pivot, last)


@inline_kernel
def solve_factored(H: FloatArray, n: int, y: FloatArray) -> None:
    """Replace y (n,) by the solution of the factored system."""
    y0 = y[0]
    y1 = y[1] - H[1, 0] * y0
    y2 = y[2] - H[2, 0] * y0 - H[2, 1] * y1
    y3 = y[3] - H[3, 0] * y0 - H[3, 1] * y1 - H[3, 2] * y2
    y4 = y[4] - H[4, 0] * y0 - H[4, 1] * y1 - H[4, 2] * y2 - H[4, 3] * y3
    y5 = 0.0
    if n == 6:
        y5 = y[5] - H[5, 0] * y0 - H[5, 1] * y1 - H[5, 2] * y2 - H[5, 3] * y3 - H[5, 4] * y4
        y5 *= H[5, 5]
        y4 = y4 * H[4, 4] - H[5, 4] * y5
        y3 = y3 * H[3, 3] - H[4, 3] * y4 - H[5, 3] * y5
        y2 = y2 * H[2, 2] - H[3, 2] * y3 - H[4, 2] * y4 - H[5, 2] * y5
        y1 = y1 * H[1, 1] - H[2, 1] * y2 - H[3, 1] * y3 - H[4, 1] * y4 - H[5, 1] * y5
        y0 = y0 * H[0, 0] - H[1, 0] * y1 - H[2, 0] * y2 - H[3, 0] * y3 - H[4, 0] * y4 - H[5, 0] * y5
    else:
        y4 *= H[4, 4]
        y3 = y3 * H[3, 3] - H[4, 3] * y4
        y2 = y2 * H[2, 2] - H[3, 2] * y3 - H[4, 2] * y4
        y1 = y1 * H[1, 1] - H[2, 1] * y2 - H[3, 1] * y3 - H[4, 1] * y4
        y0 = y0 * H[0, 0] - H[1, 0] * y1 - H[2, 0] * y2 - H[3, 0] * y3 - H[4, 0] * y4
    y[0], y[1], y[2], y[3], y[4], y[5] = y0, y1, y2, y3, y4, y5
