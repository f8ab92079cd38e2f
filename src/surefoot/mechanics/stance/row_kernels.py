"""Rows of a stance's contacts written into a matrix that exists, dense or sparse."""

from __future__ import annotations

from surefoot.base.arrays import BoolArray, FloatArray, IntArray
from surefoot.base.kernels import kernel


@kernel
def write_rows(
    rows: FloatArray, scaled: BoolArray, foot: IntArray, wide: IntArray, places: IntArray, mu: FloatArray,
    rotations: FloatArray, turned: bool, out: FloatArray,
) -> None:  # fmt: skip
    """Write rows into flat out, at places (m, 6): friction mu (n,), frames rotations (n, 3, 3) where turned.

    A row c of forces R^T f in the contact frame is R c of forces in world axes, force and moment alike.
    """
    for i in range(rows.shape[0]):
        k = foot[i]
        m = mu[k] if scaled[i] else 1.0
        for part in range(0, wide[i], 3):
            a, b, c = rows[i, part], rows[i, part + 1], rows[i, part + 2]
            if part == 0:
                c *= m
            else:
                a, b = a * m, b * m
            if turned:
                for j in range(3):
                    R = rotations
                    out[places[i, part + j]] = R[k, j, 0] * a + R[k, j, 1] * b + R[k, j, 2] * c
            else:
                out[places[i, part]], out[places[i, part + 1]], out[places[i, part + 2]] = a, b, c
