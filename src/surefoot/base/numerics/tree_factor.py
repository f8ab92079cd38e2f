"""The factors of a joint-space inertia on a kinematic tree, M = Lᵀ D L, as sparse as the tree.

Row i has an entry for every degree of freedom between i and the root, in ascending order, itself the last;
so the row of an ancestor is the beginning of the row of what hangs on it.

Source: R. Featherstone, "Rigid Body Dynamics Algorithms", 2008, section 6.5.
"""

from __future__ import annotations

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import inline_kernel


@inline_kernel
def factor_tree(values: FloatArray, count: IntArray, start: IntArray, column: IntArray) -> bool:
    """Replace the rows of M (n of them, behind each other) by those of L, with D on the diagonal.

    Return whether M is positive definite.
    """
    for i in range(count.size - 1, -1, -1):
        first, few = start[i], count[i] - 1
        pivot = values[first + few]
        if not pivot > 0.0:
            return False
        for a in range(few - 1, -1, -1):
            share = values[first + a] / pivot
            other = start[column[first + a]]
            # M_jk -= L_ij M_ik for the ancestors j, k <= j of i
            for b in range(a + 1):
                values[other + b] -= share * values[first + b]
            values[first + a] = share
    return True


@inline_kernel
def solve_tree(values: FloatArray, count: IntArray, start: IntArray, column: IntArray, x: FloatArray) -> None:
    """Replace x (n,) by M⁻¹ x, with the factors of `factor_tree`."""
    half_solve_tree(values, count, start, column, x)
    for i in range(x.size):
        x[i] /= values[start[i] + count[i] - 1]
    for i in range(x.size):
        for a in range(start[i], start[i] + count[i] - 1):
            x[i] -= values[a] * x[column[a]]


@inline_kernel
def half_solve_tree(
    values: FloatArray, count: IntArray, start: IntArray, column: IntArray, x: FloatArray
) -> None:
    """Replace x (n,) by y = L⁻ᵀ x; then x · M⁻¹ x = Σ y_i² / D_i."""
    for i in range(x.size - 1, -1, -1):
        y = x[i]
        if y != 0.0:
            for a in range(start[i], start[i] + count[i] - 1):
                x[column[a]] -= values[a] * y
