"""The loss of tosses and its derivatives, against their definitions and differences."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.base.arrays import FloatArray
from surefoot.records.identification.toss_loss import (
    curvature,
    measure_rows,
    robust_deviations,
    robust_slopes,
    slopes_of_rows,
)

FRAMES, STEP = np.array([3, 5, 1, 4]), 1e-6


def differences(of: object, x: FloatArray) -> FloatArray:
    """Return the derivatives of a function by its last argument, the new axis last."""
    assert callable(of)
    ways = STEP * np.eye(len(x))
    return np.stack([(of(x + way) - of(x - way)) / (2.0 * STEP) for way in ways], axis=-1)


@pytest.mark.parametrize("columns", [2, 3, 7])
def test_derivatives_are_those_of_differences(columns: int) -> None:
    random = np.random.default_rng(columns)
    shape = (int(FRAMES.sum()), columns)
    A, first, x = random.normal(size=(*shape, 3)), random.normal(size=shape), random.normal(size=3)
    here = measure_rows(first + A @ x, FRAMES, None)
    slopes = slopes_of_rows(here, A)

    def at(x: FloatArray) -> FloatArray:
        return measure_rows(first + A @ x, FRAMES, here.scale).robust

    def gradients(x: FloatArray) -> FloatArray:
        return slopes_of_rows(measure_rows(first + A @ x, FRAMES, here.scale), A).gradients

    def scaled(x: FloatArray) -> FloatArray:
        return robust_deviations(measure_rows(first + A @ x, FRAMES, here.scale))

    np.testing.assert_allclose(slopes.gradients, differences(at, x), atol=1e-8)
    np.testing.assert_allclose(curvature(here, slopes), differences(gradients, x), atol=1e-8)
    np.testing.assert_allclose(robust_slopes(here, slopes), differences(scaled, x), atol=1e-8)
    assert 0.5 * np.sum(scaled(x) ** 2) == pytest.approx(here.scale[0] * here.robust.sum(), rel=1e-12)


def test_places_count_as_much_as_turns_however_far_turns_are_off() -> None:
    """In one error of both, a place that is off by a tenth more would hardly raise the loss."""
    random = np.random.default_rng(0)
    rows = random.normal(size=(40, 6)) * [0.1, 0.1, 0.1, 5.0, 5.0, 5.0]
    here = measure_rows(rows, np.full(10, 4), None)

    def raised(*columns: float) -> float:
        return measure_rows(rows * columns, np.full(10, 4), here.scale).loss / here.loss - 1.0

    place, turn = raised(1.1, 1.1, 1.1, 1.0, 1.0, 1.0), raised(1.0, 1.0, 1.0, 1.1, 1.1, 1.1)
    assert place == pytest.approx(turn, rel=0.2)


def test_a_toss_that_is_lost_raises_the_loss_by_its_distance_alone() -> None:
    rows, one = np.full((4, 6), 1e-2), np.full(4, 1)
    scale, lost = measure_rows(rows, one, None).scale, np.zeros((4, 6))
    lost[0, 0] = 10.0
    near, far = (measure_rows(rows + factor * lost, one, scale).loss for factor in (1.0, 2.0))
    assert 4.0 * (far - near) == pytest.approx(10.0, rel=1e-2)
