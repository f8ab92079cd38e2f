"""Cholesky's factor and triangular solves against NumPy and SciPy."""

import numpy as np
import pytest
from scipy.linalg import solve_triangular

from surefoot.numerics import cholesky as dense


def definite(n, seed):
    root = np.random.default_rng(seed).normal(size=(n, n))
    return root @ root.T + 0.1 * np.eye(n)


@pytest.mark.parametrize("n", [1, 2, 6, 18, 35])
def test_factor_and_solves(n):
    A, rng = definite(n, n), np.random.default_rng(n)
    L, x, B = A.copy(), rng.normal(size=n), rng.normal(size=(n, 4))
    assert dense.cholesky(L)
    expected = np.linalg.cholesky(A)
    np.testing.assert_allclose(np.tril(L), expected, rtol=1e-10, atol=1e-12)
    assert np.array_equal(np.triu(L, 1), np.triu(A, 1))
    lower, upper, columns = x.copy(), x.copy(), B.copy()
    dense.solve_lower(L, lower)
    dense.solve_upper(L, upper)
    dense.solve_columns(L, columns)
    half, inverse = np.empty((n, n)), np.empty((n, n))
    dense.invert(L, half, inverse)
    np.testing.assert_allclose(half, np.linalg.inv(expected), rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(inverse, np.linalg.inv(A), rtol=1e-8, atol=1e-8)
    np.testing.assert_allclose(lower, solve_triangular(expected, x, lower=True), rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(upper, solve_triangular(expected.T, x), rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(columns, np.linalg.solve(A, B), rtol=1e-8, atol=1e-8)


def test_what_is_not_definite_is_refused():
    for A in (np.diag([1.0, -1.0]), np.zeros((1, 1)), np.array([[np.nan]]), np.array([[np.inf]])):
        bad = A.copy()
        assert not dense.cholesky(bad) or not np.isfinite(bad).all()


@pytest.mark.parametrize("rank", [1, 3, 5])
def test_vanishing_pivots_give_zero_unknowns(rank):
    """The guarded factor solves a consistent system of deficient rank on the rows that count."""
    rng = np.random.default_rng(rank)
    root = rng.normal(size=(5, rank))
    A = root @ root.T
    M, x = A.copy(), A @ rng.normal(size=5)
    b = x.copy()
    kept = dense.guarded_cholesky(M)
    assert (kept < 1e-10) == (rank < 5)
    dense.solve_lower(M, x)
    dense.solve_upper(M, x)
    np.testing.assert_allclose(A @ x, b, atol=1e-6)
    assert np.count_nonzero(np.abs(x) > 1e-50) == rank


def test_the_guarded_factor_is_the_plain_one_and_tells_its_least_pivot():
    A = definite(6, 9)
    plain, guarded = A.copy(), A.copy()
    assert dense.cholesky(plain)
    kept = dense.guarded_cholesky(guarded)
    np.testing.assert_allclose(np.tril(guarded), np.tril(plain), rtol=1e-14)
    assert kept == pytest.approx((np.diag(np.linalg.cholesky(A)) ** 2 / np.diag(A)).min())
    assert np.isnan(dense.guarded_cholesky(np.full((2, 2), np.nan)))


def test_product():
    rng = np.random.default_rng(0)
    A, B = rng.normal(size=(4, 7)), rng.normal(size=(7, 3))
    A[1] = 0.0
    out = np.full((4, 3), np.nan)
    dense.product(A, B, out)
    np.testing.assert_allclose(out, A @ B, rtol=1e-12, atol=1e-14)
