"""Lengths in the plane, against NumPy's."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.base.numerics.vectors import planar_lengths


@pytest.mark.parametrize("size", [1e-320, 1e-200, 1e-150, 1e-10, 1.0, 1e150, 1e200, 1e308])
def test_a_length_is_right_at_any_size(size: float) -> None:
    vectors = size * np.random.default_rng(0).uniform(-1.0, 1.0, (20, 4, 3))
    expected = np.hypot(vectors[..., 0], vectors[..., 1])
    np.testing.assert_allclose(planar_lengths(vectors), expected, rtol=4e-16, atol=1e-323)
    np.testing.assert_array_equal(planar_lengths(vectors[::2, :, :2]), planar_lengths(vectors)[::2])


def test_zero_infinite_and_unknown_vectors() -> None:
    vectors = np.array([[[0.0, -0.0, 1.0], [np.inf, 1.0, 0.0], [-3.0, np.nan, 0.0], [-3.0, 4.0, np.nan]]])
    np.testing.assert_array_equal(planar_lengths(vectors), [[0.0, np.inf, np.nan, 5.0]])
