"""The group SE_k(3): exponential, logarithm, product, inverse and adjoint against matrices and SciPy."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.linalg import expm

from surefoot.base.arrays import FloatArray
from surefoot.base.spatial import skew
from surefoot.motion.estimation.extended_poses import gammas
from tests.motion.estimation.poses import exponential

ALGEBRA = arrays(np.float64, 12, elements=st.floats(-3.0, 3.0))
"""ξ of SE_3(3): a rotation vector and three more."""


def algebra_matrix(xi: FloatArray) -> FloatArray:
    """Return the (3 + k, 3 + k) matrix of a vector of the algebra."""
    k = len(xi) // 3 - 1
    out = np.zeros((3 + k, 3 + k))
    out[:3, :3], out[:3, 3:] = skew(xi[:3]), xi[3:].reshape(k, 3).T
    return out


def whole(X: FloatArray) -> FloatArray:
    """Return the whole matrix of an element."""
    k = X.shape[1] - 3
    return np.vstack([X, np.hstack([np.zeros((k, 3)), np.eye(k)])])


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-6, 1e-2, 0.999999, 1.000001, 3.14159, 6.0])
def test_gammas_on_both_sides_of_the_series(angle: float) -> None:
    found, axis = np.empty((3, 3, 3)), np.array([1.0, -2.0, 2.0]) / 3.0
    gammas(angle * axis, found)
    whole_matrix = np.zeros((9, 9))  # exp of this block matrix holds the integrals
    whole_matrix[:3, :3] = skew(angle * axis)
    whole_matrix[:3, 3:6] = whole_matrix[3:6, 6:] = np.eye(3)
    top = expm(whole_matrix)[:3]
    for m in range(3):
        np.testing.assert_allclose(
            found[m], top[:, 3 * m : 3 * m + 3], rtol=0.0, atol=5e-15 * (1 + angle) ** 3
        )


@settings(max_examples=100, deadline=None)
@given(ALGEBRA)
def test_the_exponential_is_that_of_the_matrix(xi: FloatArray) -> None:
    np.testing.assert_allclose(whole(exponential(xi)), expm(algebra_matrix(xi)), rtol=0.0, atol=1e-11)
