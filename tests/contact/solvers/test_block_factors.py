"""Factors of small dense blocks solve what LAPACK's solve, where weights are far apart, too."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.contact.solvers.block_factors import factorise_blocks, solve_blocks
from surefoot.contact.solvers.elimination import SIZE, Elimination, find_elimination, find_places


def matrix_of(count: int, seed: int) -> tuple[Elimination, np.ndarray, np.ndarray]:
    """Return an elimination, a matrix that has blocks where it begins with some, and these blocks."""
    rng = np.random.default_rng(seed)
    one, two = rng.integers(0, count, size=(2, 2 * count))
    pattern = np.eye(count, dtype=bool)
    pattern[one, two] = pattern[two, one] = True
    found = find_elimination(pattern, np.inf)
    assert found is not None
    row, column = pattern.nonzero()
    values = rng.normal(size=(row.size, SIZE, SIZE))
    values[row == column] += 4.0 * SIZE * np.eye(SIZE)[rng.permutation(SIZE)]
    A = np.zeros((SIZE * count, SIZE * count))
    for i, j, block in zip(row, column, values, strict=True):
        A[SIZE * i : SIZE * i + SIZE, SIZE * j : SIZE * j + SIZE] = block
    blocks = np.zeros((count + 2 * found.below.size, SIZE, SIZE))
    blocks[find_places(found.starts, found.below)[row, column]] = values
    return found, A, blocks


@pytest.mark.parametrize("seed", range(6))
def test_they_solve_what_lapack_solves(seed: int) -> None:
    found, A, blocks = matrix_of(15, seed)
    pivots = np.empty(len(A), dtype=np.int64)
    sign = factorise_blocks(found, blocks, pivots)
    right = np.random.default_rng(seed).normal(size=len(A))
    x = right.copy()
    solve_blocks(found.starts, found.below, blocks, pivots, x)
    np.testing.assert_allclose(A @ x, right, atol=1e-11)
    assert sign == np.linalg.slogdet(A)[0]


@pytest.mark.parametrize("seed", range(8))
def test_weights_far_apart_leave_a_backward_error_of_rounding(seed: int) -> None:
    """I + Bᵀ W B with weights over sixteen decades, as near the border of the cones."""
    rng = np.random.default_rng(seed)
    count = 8
    full = find_elimination(np.ones((count, count), dtype=bool), np.inf)
    assert full is not None
    m = SIZE * count
    B, W = rng.normal(size=(m // 2, m)), 10.0 ** rng.uniform(-8.0, 8.0, size=m // 2)
    M = np.eye(m) + B.T @ (W[:, None] * B)
    row, column = (one.ravel() for one in np.indices((count, count)))
    blocks = np.zeros((count + 2 * full.below.size, SIZE, SIZE))
    parts = M.reshape(count, SIZE, count, SIZE).transpose(0, 2, 1, 3)
    blocks[find_places(full.starts, full.below)[row, column]] = parts.reshape(-1, SIZE, SIZE)
    pivots = np.empty(m, dtype=np.int64)
    assert factorise_blocks(full, blocks, pivots) == 1.0
    right = M @ rng.normal(size=m)
    x = right.copy()
    solve_blocks(full.starts, full.below, blocks, pivots, x)
    assert np.abs(M @ x - right).max() <= 1e-13 * (np.abs(M) @ np.abs(x) + np.abs(right)).max()


def test_a_singular_block_has_no_factors() -> None:
    found, _, blocks = matrix_of(3, 0)
    blocks[found.starts.size - 2] = 0.0
    blocks[found.starts.size - 1 :] = 0.0
    assert factorise_blocks(found, blocks, np.empty(3 * SIZE, dtype=np.int64)) == 0.0
    blocks[0, 0, 0] = np.nan
    assert factorise_blocks(found, blocks, np.empty(3 * SIZE, dtype=np.int64)) == 0.0
