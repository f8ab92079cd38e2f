"""Scalar algebra in six dimensions for compiled kernels: vectors and symmetric matrices as tuples.

Tuples of scalars become registers; small arrays would cost an allocation each.
"""

from __future__ import annotations

from surefoot.base.kernels import inline_kernel

Six = tuple[float, float, float, float, float, float]
Lower = tuple[
    float, float, float, float, float, float, float, float, float, float, float,
    float, float, float, float, float, float, float, float, float, float,
]  # fmt: skip
"""Lower triangle of a symmetric 6x6 matrix, row by row."""


@inline_kernel
def scaled_identity(s: float) -> Lower:
    """Return s I."""
    return (
        s, 0.0, s, 0.0, 0.0, s, 0.0, 0.0, 0.0, s, 0.0,
        0.0, 0.0, 0.0, s, 0.0, 0.0, 0.0, 0.0, 0.0, s,
    )  # fmt: skip


@inline_kernel
def add_outer(H: Lower, a: Six) -> Lower:
    """Return H + a aᵀ (lower triangle, row by row)."""
    return (
        H[0] + a[0] * a[0],
        H[1] + a[1] * a[0], H[2] + a[1] * a[1],
        H[3] + a[2] * a[0], H[4] + a[2] * a[1], H[5] + a[2] * a[2],
        H[6] + a[3] * a[0], H[7] + a[3] * a[1], H[8] + a[3] * a[2], H[9] + a[3] * a[3],
        H[10] + a[4] * a[0], H[11] + a[4] * a[1], H[12] + a[4] * a[2], H[13] + a[4] * a[3],
        H[14] + a[4] * a[4],
        H[15] + a[5] * a[0], H[16] + a[5] * a[1], H[17] + a[5] * a[2], H[18] + a[5] * a[3],
        H[19] + a[5] * a[4], H[20] + a[5] * a[5],
    )  # fmt: skip


@inline_kernel
def solve_six(H: Lower, F: Six) -> Six:
    """Return -H⁻¹ F by an LDLᵀ factorisation; H is positive definite."""
    # L D Lᵀ without roots, entry by entry in registers; a_ij are the
    # entries before the division by their pivot
    d0 = 1.0 / H[0]
    l10, l20, l30, l40, l50 = H[1] * d0, H[3] * d0, H[6] * d0, H[10] * d0, H[15] * d0
    a11 = H[2] - l10 * H[1]
    a21, a31, a41, a51 = H[4] - l20 * H[1], H[7] - l30 * H[1], H[11] - l40 * H[1], H[16] - l50 * H[1]
    d1 = 1.0 / a11
    l21, l31, l41, l51 = a21 * d1, a31 * d1, a41 * d1, a51 * d1
    a22 = H[5] - l20 * H[3] - l21 * a21
    a32 = H[8] - l30 * H[3] - l31 * a21
    a42 = H[12] - l40 * H[3] - l41 * a21
    a52 = H[17] - l50 * H[3] - l51 * a21
    d2 = 1.0 / a22
    l32, l42, l52 = a32 * d2, a42 * d2, a52 * d2
    a33 = H[9] - l30 * H[6] - l31 * a31 - l32 * a32
    a43 = H[13] - l40 * H[6] - l41 * a31 - l42 * a32
    a53 = H[18] - l50 * H[6] - l51 * a31 - l52 * a32
    d3 = 1.0 / a33
    l43, l53 = a43 * d3, a53 * d3
    a44 = H[14] - l40 * H[10] - l41 * a41 - l42 * a42 - l43 * a43
    a54 = H[19] - l50 * H[10] - l51 * a41 - l52 * a42 - l53 * a43
    d4 = 1.0 / a44
    l54 = a54 * d4
    a55 = H[20] - l50 * H[15] - l51 * a51 - l52 * a52 - l53 * a53 - l54 * a54
    # L z = -F, then Lᵀ x = D⁻¹ z
    x0 = -F[0]
    x1 = -F[1] - l10 * x0
    x2 = -F[2] - l20 * x0 - l21 * x1
    x3 = -F[3] - l30 * x0 - l31 * x1 - l32 * x2
    x4 = -F[4] - l40 * x0 - l41 * x1 - l42 * x2 - l43 * x3
    x5 = -F[5] - l50 * x0 - l51 * x1 - l52 * x2 - l53 * x3 - l54 * x4
    x5 = x5 / a55
    x4 = x4 * d4 - l54 * x5
    x3 = x3 * d3 - l43 * x4 - l53 * x5
    x2 = x2 * d2 - l32 * x3 - l42 * x4 - l52 * x5
    x1 = x1 * d1 - l21 * x2 - l31 * x3 - l41 * x4 - l51 * x5
    x0 = x0 * d0 - l10 * x1 - l20 * x2 - l30 * x3 - l40 * x4 - l50 * x5
    return x0, x1, x2, x3, x4, x5


@inline_kernel
def dot(a: Six, b: Six) -> float:
    """Return a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] + a[4] * b[4] + a[5] * b[5]


@inline_kernel
def mix(a: Six, s: float, b: Six) -> Six:
    """Return a + s b."""
    return (
        a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2],
        a[3] + s * b[3], a[4] + s * b[4], a[5] + s * b[5],
    )  # fmt: skip


@inline_kernel
def scale(s: float, a: Six) -> Six:
    """Return s a."""
    return s * a[0], s * a[1], s * a[2], s * a[3], s * a[4], s * a[5]


@inline_kernel
def times(H: Lower, a: Six) -> Six:
    """Return H a."""
    return (
        H[0] * a[0] + H[1] * a[1] + H[3] * a[2] + H[6] * a[3] + H[10] * a[4] + H[15] * a[5],
        H[1] * a[0] + H[2] * a[1] + H[4] * a[2] + H[7] * a[3] + H[11] * a[4] + H[16] * a[5],
        H[3] * a[0] + H[4] * a[1] + H[5] * a[2] + H[8] * a[3] + H[12] * a[4] + H[17] * a[5],
        H[6] * a[0] + H[7] * a[1] + H[8] * a[2] + H[9] * a[3] + H[13] * a[4] + H[18] * a[5],
        H[10] * a[0] + H[11] * a[1] + H[12] * a[2] + H[13] * a[3] + H[14] * a[4] + H[19] * a[5],
        H[15] * a[0] + H[16] * a[1] + H[17] * a[2] + H[18] * a[3] + H[19] * a[4] + H[20] * a[5],
    )
