"""Elimination inside kernels against NumPy."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from surefoot.base.numerics import elimination


@pytest.mark.parametrize(
    ("solve", "shapes", "symmetric"),
    [
        (elimination.lu_solve, [(1,), (2,), (7,), (30,)], False),
        (elimination.lu_solve_many, [(1, 3), (4, 1), (12, 16), (30, 5)], False),
        (elimination.symmetric_solve, [(1,), (2,), (7,), (30,)], True),
    ],
)
def test_elimination_is_numpy_solve(solve: Any, shapes: list[tuple[int, ...]], symmetric: bool) -> None:
    rng = np.random.default_rng(0)
    for shape in shapes:
        m = shape[0]
        A, b = rng.normal(size=(m, m)), rng.normal(size=shape)
        A = A @ A.T + 0.1 * np.eye(m) if symmetric else A
        expected = np.linalg.solve(A, b)
        assert solve(A.copy(), b, m)
        assert np.allclose(b, expected, rtol=1e-8)
    bad = -np.eye(2) if symmetric else np.zeros((2, 2))
    assert not solve(bad, np.ones((2, *shapes[0][1:])), 2)


def test_inverse_is_numpy_inverse() -> None:
    rng = np.random.default_rng(2)
    for m in (1, 3, 12, 45):
        root = rng.normal(size=(m, m))
        G, out = root @ root.T, np.empty((m, m))
        elimination.invert_shifted(G, 0.3, out)
        assert np.allclose(out @ (G + 0.3 * np.eye(m)), np.eye(m), atol=1e-9)
