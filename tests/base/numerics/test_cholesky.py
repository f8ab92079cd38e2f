"""Cholesky's factor and triangular solves against NumPy and SciPy."""

import numpy as np
import pytest
from scipy.linalg import solve_triangular

from surefoot.base.numerics import cholesky as dense


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


def test_product():
    rng = np.random.default_rng(0)
    A, B = rng.normal(size=(4, 7)), rng.normal(size=(7, 3))
    A[1] = 0.0
    out = np.full((4, 3), np.nan)
    dense.product(A, B, out)
    np.testing.assert_allclose(out, A @ B, rtol=1e-12, atol=1e-14)
