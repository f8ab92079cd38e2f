"""How much a frame of a toss counts: what is measured of tosses, and what it makes of their deviations."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.records.identification.frame_weights import (
    FEWEST,
    error_growth,
    frame_weights,
    frames_since,
)

BEFORE, AFTER, TOSSES, LONGER = 3, 12, 11, 2
"""Frames of a toss before and after its first touch, how many there are, and those of them that last twice as
long."""


@pytest.fixture
def since() -> np.ndarray:
    frames = np.full(TOSSES, BEFORE + AFTER)
    frames[:LONGER] += AFTER
    return frames_since(frames, np.full(TOSSES, BEFORE))


def growing(since: np.ndarray, seed: int = 0) -> np.ndarray:
    """Return deviations whose places grow as the square of the time, and turns with it."""
    random, time = np.random.default_rng(seed), np.maximum(since, 0) + 1.0
    ways = random.normal(size=(len(since), 7))
    return ways * np.where(np.arange(7) < 3, 1e-2 * time[:, None] ** 2, 2e-2 * time[:, None])


def test_growth_is_the_median_toss_and_never_falls(since: np.ndarray) -> None:
    rows = growing(since)
    growth = error_growth(rows, since)
    assert growth.shape == (2 * AFTER, 2)
    assert np.all(np.diff(growth, axis=0) >= 0.0)
    for time in (5, AFTER - 1):
        here = rows[since == time]
        places, turns = np.linalg.norm(here[:, :3], axis=1), np.linalg.norm(here[:, 3:], axis=1)
        assert growth[time, 0] >= np.median(places)
        assert growth[time, 1] >= np.median(turns)
    # what fewer tosses last tells nothing of the median one
    assert FEWEST > LONGER
    np.testing.assert_array_equal(growth[AFTER:], np.tile(growth[AFTER - 1], (AFTER, 1)))


def test_tosses_that_are_lost_leave_the_median_a_number(since: np.ndarray) -> None:
    rows = growing(since)
    rows[::5] = np.nan
    assert np.isfinite(error_growth(rows, since)).all()


def test_weights_keep_the_unit_and_take_half_of_the_growth_away(since: np.ndarray) -> None:
    rows = growing(since)
    growth = error_growth(rows, since)
    weights = frame_weights(growth, since, rows.shape[1])
    np.testing.assert_allclose(np.exp(np.log(weights).mean(axis=0)), 1.0)
    early, late = weights[since == 0][0], weights[since == AFTER - 1][0]
    for column, kind in ((0, 0), (2, 0), (3, 1), (6, 1)):
        assert (early / late)[column] ** 2 == pytest.approx(growth[AFTER - 1, kind] / growth[0, kind])
    np.testing.assert_array_equal(weights[since < 0], np.tile(early, (BEFORE * TOSSES, 1)))


def test_tosses_that_fit_to_noise_are_weighed_alike(since: np.ndarray) -> None:
    rows = 1e-5 * np.random.default_rng(1).normal(size=(len(since), 6))
    weights = frame_weights(error_growth(rows, since), since, 6)
    np.testing.assert_allclose(weights, 1.0, rtol=1e-12)
