"""Elimination inside kernels against NumPy."""

from __future__ import annotations

import numpy as np

from surefoot.numerics import elimination


def test_lu_is_numpy_solve() -> None:
    rng = np.random.default_rng(0)
    for m in (1, 2, 7, 30):
        A, b = rng.normal(size=(m, m)), rng.normal(size=m)
        expected = np.linalg.solve(A, b)
        assert elimination.lu_solve(A.copy(), b, m)
        assert np.allclose(b, expected, rtol=1e-8)
    assert not elimination.lu_solve(np.zeros((2, 2)), np.ones(2), 2)


def test_elimination_of_many_right_hand_sides_is_numpy_solve() -> None:
    rng = np.random.default_rng(2)
    for m, columns in ((1, 3), (4, 1), (12, 16), (30, 5)):
        A, B = rng.normal(size=(m, m)), rng.normal(size=(m, columns))
        expected = np.linalg.solve(A, B)
        assert elimination.lu_solve_many(A.copy(), B, m)
        assert np.allclose(B, expected, rtol=1e-8)
    assert not elimination.lu_solve_many(np.zeros((2, 2)), np.ones((2, 3)), 2)


def test_symmetric_elimination_is_numpy_solve() -> None:
    rng = np.random.default_rng(1)
    for m in (1, 2, 7, 30):
        root, b = rng.normal(size=(m, m)), rng.normal(size=m)
        A = root @ root.T + 0.1 * np.eye(m)
        expected = np.linalg.solve(A, b)
        assert elimination.symmetric_solve(A.copy(), b, m)
        assert np.allclose(b, expected, rtol=1e-8)
    assert not elimination.symmetric_solve(-np.eye(2), np.ones(2), 2)


def test_inverse_is_numpy_inverse() -> None:
    rng = np.random.default_rng(2)
    for m in (1, 3, 12, 45):
        root = rng.normal(size=(m, m))
        G, out = root @ root.T, np.empty((m, m))
        elimination.invert_shifted(G, 0.3, out)
        assert np.allclose(out @ (G + 0.3 * np.eye(m)), np.eye(m), atol=1e-9)
