"""Windows that slide along rows, against sums of slices."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.base.numerics.windows import sliding_mean, sliding_sum


@pytest.mark.parametrize("rows", [1, 2, 3, 8, 40, 41, 100])
@pytest.mark.parametrize("shape", [(40,), (40, 3), (40, 2, 3), (1, 4), (0, 2)])
def test_sums_and_means_are_those_of_slices(shape: tuple[int, ...], rows: int) -> None:
    values = np.random.default_rng(rows).normal(size=shape)
    found, means = sliding_sum(values, rows), sliding_mean(values, rows)
    assert found.shape == means.shape == shape
    for t in range(len(values)):
        window = values[max(t - (rows - 1) // 2, 0) : t + rows // 2 + 1]
        np.testing.assert_allclose(found[t], window.sum(axis=0), atol=1e-12)
        np.testing.assert_allclose(means[t], window.mean(axis=0), atol=1e-12)


def test_arrays_of_any_layout_and_kind_are_summed() -> None:
    values = np.arange(60.0).reshape(3, 20).T
    np.testing.assert_array_equal(sliding_sum(values, 5), sliding_sum(values.copy(), 5))
    np.testing.assert_array_equal(sliding_sum(values[:, ::2], 5), sliding_sum(values, 5)[:, ::2])
    np.testing.assert_array_equal(sliding_sum(values > 30.0, 3)[1:-1, 2], 3.0)


def test_a_mean_needs_half_of_its_window() -> None:
    values = np.arange(10.0)
    values[3:7] = np.nan
    found = sliding_mean(values, 4)
    np.testing.assert_allclose(found[2], 1.5)  # of rows 1 to 4 the first two
    assert np.isnan(found[3:6]).all()
    assert np.isfinite(found[6:]).all()
