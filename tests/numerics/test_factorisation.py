"""Factors inside kernels, against NumPy."""

import numpy as np
import pytest

from surefoot.numerics.factorisation import factor, solve_factored


@pytest.mark.parametrize("size", [1, 2, 3, 4, 5, 6, 7, 24, 60, 61, 62, 63])
def test_the_factorisation_solves(size):
    rng = np.random.default_rng(size)
    root = rng.normal(size=(size, size))
    A = root @ root.T + np.eye(size)
    b = rng.normal(size=size)
    U, x = np.triu(A), b.copy()
    factor(U)
    solve_factored(U, x)
    assert np.allclose(x, np.linalg.solve(A, b), rtol=0, atol=1e-11 * np.linalg.norm(b))
