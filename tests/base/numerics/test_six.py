"""Algebra in six dimensions against NumPy."""

import numpy as np
import pytest

from surefoot.base.kernels import kernel
from surefoot.base.numerics import six

LOWER = np.tril_indices(6)


@kernel
def run_six(H, a, b, s):
    return (
        six.solve_six(H, a),
        six.times(H, a),
        six.add_outer(H, a),
        six.mix(a, s, b),
        six.dot(a, b),
        six.scale(s, a),
    )


def full(lower):
    H = np.zeros((6, 6))
    H[LOWER] = lower
    return H + np.tril(H, -1).T


def test_six_dimensional_algebra():
    rng = np.random.default_rng(0)
    for _ in range(50):
        M = rng.normal(size=(6, 6)) * 10.0 ** rng.uniform(-3, 3, (6, 1))
        H, a, b, s = M @ M.T + 1e-3 * np.eye(6), *rng.normal(size=(2, 6)), rng.normal()
        x, product, outer, mixed, inner, scaled = run_six(tuple(H[LOWER]), tuple(a), tuple(b), s)
        np.testing.assert_allclose(H @ x, -a, atol=1e-7 * np.linalg.cond(H) ** 0.5)
        np.testing.assert_allclose(product, H @ a, rtol=1e-9, atol=1e-9 * np.abs(H).max())
        np.testing.assert_allclose(full(outer), H + np.outer(a, a), rtol=1e-12)
        np.testing.assert_allclose(mixed, a + s * b, rtol=1e-12, atol=1e-15)
        np.testing.assert_allclose(scaled, s * a, rtol=1e-12)
        assert inner == pytest.approx(a @ b)
    assert np.array_equal(full(six.scaled_identity(2.5)), 2.5 * np.eye(6))
