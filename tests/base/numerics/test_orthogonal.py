"""Orthonormal rows and reflections against NumPy."""

import numpy as np
import pytest

from surefoot.base.numerics import orthogonal


def test_what_lies_along_earlier_rows_is_removed():
    rng = np.random.default_rng(0)
    Q = np.ascontiguousarray(np.linalg.qr(rng.normal(size=(9, 5)))[0].T)
    new = 1e-6 * rng.normal(size=9) + rng.normal(size=4) @ Q[:4]  # almost dependent
    Q[4], shares = new, np.ones(5)
    left = orthogonal.remove_rows(Q, 4, shares)
    expected = new - Q[:4].T @ (Q[:4] @ new)
    assert left == pytest.approx(np.linalg.norm(expected), rel=1e-8)
    np.testing.assert_allclose(shares[:4] - 1.0, Q[:4] @ new, rtol=1e-12)
    assert shares[4] == 1.0
    np.testing.assert_allclose(Q[:4] @ Q[4], 0.0, atol=1e-20 + 1e-14 * left)
    orthogonal.scale_row(Q, 4, left)
    np.testing.assert_allclose(Q @ Q.T, np.eye(5), atol=1e-13)


@pytest.mark.parametrize("rank", [1, 3, 5, 6])
def test_reduction_finds_the_rank_and_factors(rank):
    rng = np.random.default_rng(rank)
    A = rng.normal(size=(6, rank)) @ rng.normal(size=(rank, 12))
    Q, T, pivots = np.empty((6, 12)), np.empty((6, 6)), np.empty(6, dtype=np.int64)
    assert orthogonal.orthonormal_rows(A, Q, T, pivots) == rank
    np.testing.assert_allclose(Q[:rank] @ Q[:rank].T, np.eye(rank), atol=1e-12)
    np.testing.assert_allclose(T[:, :rank] @ Q[:rank], A, atol=1e-10)
    w, out = A @ rng.normal(size=12), np.empty(6)
    assert orthogonal.coordinates(T, pivots, rank, w, out) < 1e-9
    np.testing.assert_allclose(T[:, :rank] @ out[:rank], w, atol=1e-9)
    y, u = rng.normal(size=rank), np.empty(6)
    orthogonal.pull_back(T, pivots, rank, y, u)
    np.testing.assert_allclose(A.T @ u, Q[:rank].T @ y, atol=1e-8)


def test_turning_the_first_row():
    rng = np.random.default_rng(2)
    Q = np.ascontiguousarray(np.linalg.qr(rng.normal(size=(12, 6)))[0].T)
    a, b, h = rng.normal(size=6), rng.normal(size=6), np.zeros(6)
    before, right = Q.copy(), b.copy()
    length = orthogonal.turn_first_row(Q, 6, a, h, b)
    assert length == pytest.approx(np.linalg.norm(a))
    np.testing.assert_allclose(Q[0], a @ before / length, atol=1e-12)
    np.testing.assert_allclose(Q @ Q.T, np.eye(6), atol=1e-12)
    np.testing.assert_allclose(Q.T @ b, before.T @ right, atol=1e-12)
    orthogonal.reflect(h, 6, right)
    np.testing.assert_allclose(right, b, atol=1e-14)
    np.testing.assert_allclose(b, (np.eye(6) - 2.0 * np.outer(h, h)) @ (before @ Q.T @ b), atol=1e-12)


def test_a_row_without_length_turns_nothing():
    Q, b, h = np.random.default_rng(3).normal(size=(4, 6)), np.arange(4.0), np.full(4, 7.0)
    kept = Q.copy(), b.copy()
    assert orthogonal.turn_first_row(Q, 4, np.zeros(4), h, b) == 0.0
    assert h.tolist() == [0.0] * 4
    np.testing.assert_array_equal(Q, kept[0])
    np.testing.assert_array_equal(b, kept[1])
    assert orthogonal.turn_first_row(Q, 4, np.array([2.0, 0.0, 0.0, 0.0]), np.full(4, 7.0), b) == 2.0
    np.testing.assert_array_equal(Q, kept[0])
