"""Rows that reach a part of the columns alone: the same motion as by all of the inertia."""

from __future__ import annotations

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.arrays import FloatArray, IntArray
from surefoot.contact import CONE_ROWS, ROW_PENALTY, solve_rows
from tests.contact.rows.reached import columns_of


def _points(
    rng: np.random.Generator, reached: IntArray, n: int
) -> tuple[FloatArray, FloatArray, FloatArray, IntArray, FloatArray]:
    """Return M, v, J, table and numbers of two point contacts over some of the columns."""
    root = rng.normal(size=(n, n))
    M, v = root @ root.T + 0.5 * np.eye(n), rng.normal(size=n)
    J = np.zeros((6, n))
    J[:, reached] = rng.normal(size=(6, len(reached)))
    G = J @ np.linalg.solve(M, J.T)
    table = np.array([[CONE_ROWS, 3, 0, 0], [CONE_ROWS, 3, 3, 0]])
    stiffness = [[ROW_PENALTY / G[k, k], ROW_PENALTY / max(G[k + 1, k + 1], G[k + 2, k + 2])] for k in (0, 3)]
    numbers = [[0.5, 0.0, np.diagonal(G)[k : k + 3].sum(), *stiffness[k // 3], 0.0] for k in (0, 3)]
    return M, v, J, table, np.array(numbers)


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e4])
def test_what_no_row_reaches_moves_along(scale: float) -> None:
    """Impulses are those of the solver of forces, and all velocities v + M⁻¹ Jᵀ λ of the whole inertia."""
    rng, moved = np.random.default_rng(5), 0
    for _ in range(40):
        n = int(rng.integers(8, 20))
        reached = np.sort(rng.choice(n, size=int(rng.integers(6, n + 1)), replace=False))
        M, v, J, table, numbers = _points(rng, reached, n)
        numbers[:, [2]] /= scale
        numbers[:, [3, 4]] *= scale
        after, x = v.copy(), np.zeros(6)
        _, error, _ = solve_rows(
            scale * M, after, J, np.zeros(6), columns_of(J, table), table, numbers, 1e-10, x
        )
        assert error <= 1e-9
        np.testing.assert_allclose(after, v + np.linalg.solve(scale * M, J.T @ x), atol=1e-9)
        order = [1, 2, 0, 4, 5, 3]
        G = J @ np.linalg.solve(scale * M, J.T)
        problem = sf.ContactProblem(0.5 * (G + G.T)[np.ix_(order, order)], (J @ v)[order], np.full(2, 0.5))
        assert sf.residuals(problem, x[order].reshape(-1, 3)).velocity_error < 1e-7
        moved += bool(x.any())
    assert moved > 30


def test_an_inertia_that_cannot_be_condensed_is_taken_whole() -> None:
    """A matrix that needs rows exchanged, and a velocity that is no number: not to pass for solved."""
    rng = np.random.default_rng(6)
    M, v, J, table, numbers = _points(rng, np.arange(8), 10)
    odd = M.copy()
    odd[8:] = odd[:, 8:] = 0.0
    odd[8, 9], odd[9, 8] = 2.0, 3.0  # a rotation by masses: no pivot on the diagonal
    after, x = v.copy(), np.zeros(6)
    _, error, _ = solve_rows(odd, after, J, np.zeros(6), columns_of(J, table), table, numbers, 1e-10, x)
    assert error <= 1e-9
    np.testing.assert_allclose(after, v + np.linalg.solve(odd, J.T @ x), atol=1e-9)
    v[9] = np.nan
    _, error, _ = solve_rows(M, v, J, np.zeros(6), columns_of(J, table), table, numbers, 1e-10, x)
    assert not error <= 1e-6
