"""LU factors that are kept, and the factors of a tree's inertia, against NumPy."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.base.kernels import kernel
from surefoot.base.numerics.lu_factors import apply_lu, eliminate_last, factor_lu
from surefoot.base.numerics.tree_factor import factor_tree, half_solve_tree, solve_tree


@pytest.mark.parametrize("n", [1, 5, 24, 37])
def test_lu_factors_serve_many_right_sides(n: int) -> None:
    """A x = b for several b from one elimination; a singular matrix is refused."""
    rng = np.random.default_rng(n)
    A = rng.normal(size=(n, n))
    kept, order = A.copy(), np.zeros((3, n), np.int64)
    assert factor_lu(kept, order)
    for _ in range(3):
        b = rng.normal(size=n)
        x = b.copy()
        apply_lu(kept, order, x)
        np.testing.assert_allclose(A @ x, b, atol=1e-9)
    assert not factor_lu(np.zeros((n, n)), order)


@pytest.mark.parametrize("band", [1, 3])
def test_lu_factors_of_blocks_and_bands_are_as_wide_as_they_are(band: int) -> None:
    """With rows exchanged, too: what is passed over is zero."""
    rng, n = np.random.default_rng(band), 18
    apart = np.abs(np.subtract.outer(np.arange(n), np.arange(n)))
    for _ in range(20):
        A = np.where(apart <= band, rng.normal(size=(n, n)), 0.0)
        A[9:, :9] = A[:9, 9:] = 0.0
        kept, order, b = A.copy(), np.zeros((3, n), np.int64), rng.normal(size=n)
        assert factor_lu(kept, order)
        for k in range(n):
            assert (kept[: order[1, k], k] == 0.0).all()
            assert (kept[order[2, k] + 1 :, k] == 0.0).all()
        assert order[2, :9].max() < 9 <= order[1, 9:].min()
        x = b.copy()
        apply_lu(kept, order, x)
        np.testing.assert_allclose(x, np.linalg.solve(A, b), rtol=1e-7, atol=1e-9 * np.abs(x).max())


@pytest.mark.parametrize("kept", [0, 3, 9])
def test_elimination_of_the_last_columns_leaves_their_schur_complement(kept: int) -> None:
    """Inertias, not symmetric ones too; what it would have to exchange rows for is refused."""
    rng, n = np.random.default_rng(kept), 9
    root = rng.normal(size=(n, n))
    A = root @ root.T + np.eye(n) + 0.1 * rng.normal(size=(n, n))
    done = A.copy()
    assert eliminate_last(done, kept)
    inner = A[kept:, kept:]
    schur = A[:kept, :kept] - A[:kept, kept:] @ np.linalg.solve(inner, A[kept:, :kept])
    np.testing.assert_allclose(done[:kept, :kept], schur, atol=1e-10)
    for bad in (0.0, 1e-6, np.nan):
        broken = A.copy()
        broken[n - 1, n - 1] = bad
        assert eliminate_last(broken, kept) == (kept == n)


def test_lu_factors_of_a_tree_fill_no_zero() -> None:
    """Parents first, as MuJoCo and Pinocchio number joints: every branch is done before the trunk."""
    rng = np.random.default_rng(3)
    A = np.zeros((18, 18))
    for leg in range(4):
        chain = np.concatenate([np.arange(6), 6 + 3 * leg + np.arange(3)])
        root = rng.normal(size=(9, 9))
        A[np.ix_(chain, chain)] += root @ root.T + np.eye(9)
    kept, order, b = A.copy(), np.zeros((3, 18), np.int64), rng.normal(size=18)
    x = b.copy()
    assert factor_lu(kept, order)
    assert (kept[A == 0.0] == 0.0).all()
    assert (order[0] == np.arange(18)).all()
    apply_lu(kept, order, x)
    np.testing.assert_allclose(x, np.linalg.solve(A, b), rtol=1e-9)


def test_lu_factors_exchange_rows_where_the_diagonal_is_nothing() -> None:
    """Entries of the diagonal that are too small to divide by do not spoil the solution."""
    rng = np.random.default_rng(4)
    A = rng.normal(size=(12, 12))
    np.fill_diagonal(A, np.where(np.arange(12) % 2, 1e-13, 0.0))
    kept, order, b = A.copy(), np.zeros((3, 12), np.int64), rng.normal(size=12)
    x = b.copy()
    assert factor_lu(kept, order)
    apply_lu(kept, order, x)
    np.testing.assert_allclose(x, np.linalg.solve(A, b), rtol=1e-9)


@kernel
def _solve(
    values: np.ndarray,
    count: np.ndarray,
    start: np.ndarray,
    column: np.ndarray,
    x: np.ndarray,
    half: np.ndarray,
) -> bool:
    if not factor_tree(values, count, start, column):
        return False
    half_solve_tree(values, count, start, column, half)
    for i in range(half.size):
        half[i] *= half[i] / values[start[i] + count[i] - 1]
    solve_tree(values, count, start, column, x)
    return True


def test_the_factors_of_a_tree_solve_and_weigh() -> None:
    """M⁻¹ x and x · M⁻¹ x of a branching tree; a matrix that is not definite is refused."""
    parents = np.array([-1, 0, 1, 1, 3, 0, 5])
    n, rng = len(parents), np.random.default_rng(1)
    chains = []
    for i in range(n):
        chain, at = [i], i
        while parents[at] >= 0:
            at = int(parents[at])
            chain.append(at)
        chains.append(sorted(chain))
    lower = np.eye(n)
    for i, chain in enumerate(chains):
        lower[i, chain[:-1]] = rng.normal(size=len(chain) - 1)
    M = lower.T @ np.diag(rng.uniform(1.0, 2.0, n)) @ lower
    count = np.array([len(c) for c in chains])
    start = np.concatenate([[0], np.cumsum(count)[:-1]])
    column = np.concatenate(chains)
    values = np.concatenate([M[i, c] for i, c in enumerate(chains)])
    b = rng.normal(size=n)
    x, half = b.copy(), b.copy()
    assert _solve(values, count, start, column, x, half)
    np.testing.assert_allclose(M @ x, b, atol=1e-12)
    assert half.sum() == pytest.approx(b @ np.linalg.solve(M, b), rel=1e-12)
    assert not _solve(-np.ones(len(column)), count, start, column, x, half)
