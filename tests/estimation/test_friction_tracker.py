"""The tracker of friction: its kernel against plain Python, and answers in worlds whose friction is known."""

from __future__ import annotations

from collections import deque

import numpy as np
import pytest

import surefoot as sf
from benchmarks.contact_detection import friction_answers
from surefoot.arrays import FloatArray
from surefoot.errors import ProblemError
from surefoot.estimation.friction import AGREE, follow_friction


def _row(use: float, speed: float = 0.0, normal: float = 100.0) -> tuple[FloatArray, FloatArray]:
    return np.array([[use * normal, 0.0, normal]]), np.array([[speed, 0.0, 0.0]])


def _feed(tracker: sf.FrictionTracker, count: int, *row: float):  # type: ignore[no-untyped-def]
    for _ in range(count):
        known = tracker.update(*_row(*row))
    return known


def test_kernel_against_plain_python() -> None:
    random = np.random.default_rng(0)
    p, rows, settling, slide, gap, least, limit = 3, 5, 4, 6, 7, 10.0, 0.1
    ring, state = np.zeros((p, rows)), np.zeros((p, 5))
    lows, highs, sliding = np.zeros((p, 2)), np.full((p, 2), np.inf), np.zeros(p, dtype=bool)
    recent: list[deque[float]] = [deque(maxlen=rows) for _ in range(p)]
    idle, slid, total = [0] * p, [0] * p, [0.0] * p
    low, high = np.zeros((p, 2)), np.full((p, 2), np.inf)
    normal, speed = np.full(p, 50.0), np.zeros(p)
    for step in range(600):
        bucket = step // 300
        if step % 9 == 0:
            normal, speed = random.choice([0.0, 50.0, 80.0], p), random.choice([0.0, 0.3, 0.4], p)
        forces = np.column_stack([normal * random.uniform(0.1, 0.5, p), np.zeros(p), normal])
        velocities = np.column_stack([np.zeros(p), speed, np.zeros(p)])
        follow_friction(
            ring, state, lows, highs, bucket, forces, velocities, least, limit, settling, slide, gap, sliding
        )
        for k in range(p):
            if normal[k] < least:
                idle[k] += 1
                recent[k].clear()
                if idle[k] >= gap:
                    slid[k], total[k] = 0, 0.0
                assert not sliding[k]
                continue
            idle[k] = 0
            use = forces[k, 0] / normal[k]
            recent[k].append(use)
            assert sliding[k] == (speed[k] > limit)
            if speed[k] <= limit:
                slid[k], total[k] = 0, 0.0
                if len(recent[k]) == rows:
                    lasted = min(recent[k])
                    low[k, bucket] = max(low[k, bucket], lasted)
                    high[k, lasted > AGREE * high[k]] = np.inf
                continue
            slid[k] += 1
            if slid[k] > settling:
                total[k] += use
            if slid[k] >= settling + slide:
                high[k, bucket] = total[k] / (slid[k] - settling)
                low[k] = np.minimum(low[k], high[k, bucket])
            if slid[k] >= settling + 2 * slide:
                slid[k], total[k] = settling + slide, total[k] / 2
        np.testing.assert_allclose(lows, low, atol=1e-12)
        np.testing.assert_allclose(highs, high, atol=1e-12)
    assert np.isfinite(highs).any()
    assert (lows > 0.0).any()


def test_sticking_bounds_below_and_sliding_tells() -> None:
    tracker = sf.FrictionTracker(1, 0.001, least=5.0)
    assert _feed(tracker, 9, 0.4).low == 0.0  # too short to count
    known = _feed(tracker, 1, 0.4)
    assert (known.low[0], known.high[0]) == (pytest.approx(0.4), np.inf)
    _feed(tracker, 1, 0.9)  # one reading proves nothing
    assert _feed(tracker, 9, 0.1).low[0] == pytest.approx(0.4)
    known = _feed(tracker, 19, 0.5, 0.2)
    assert known.sliding[0]
    assert known.high[0] == np.inf
    assert _feed(tracker, 1, 0.5, 0.2).high[0] == pytest.approx(0.5)
    assert tracker.believed(0.6)[0] == pytest.approx(0.45)
    assert tracker.believed(0.2)[0] == pytest.approx(0.4)


def test_a_landing_foot_tells_nothing_from_above() -> None:
    tracker = sf.FrictionTracker(1, 0.001, least=5.0)
    for _ in range(20):
        _feed(tracker, 40, 0.0, 0.0, 0.0)
        known = _feed(tracker, 8, 0.1, 0.3)
        known = _feed(tracker, 30, 0.2)
    assert known.high[0] == np.inf


def test_chatter_on_ice_is_one_slide() -> None:
    tracker = sf.FrictionTracker(1, 0.001, least=5.0)
    for _ in range(8):
        _feed(tracker, 4, 0.1, 0.5)
        known = _feed(tracker, 6, 0.0, 0.5, 0.0)
    assert known.high[0] == pytest.approx(0.1)


def test_grounds_change() -> None:
    tracker = sf.FrictionTracker(1, 0.001, least=5.0, memory=1.0)
    _feed(tracker, 20, 0.5)
    known = _feed(tracker, 40, 0.1, 0.4)  # onto ice
    assert (known.low[0], known.high[0]) == (pytest.approx(0.1), pytest.approx(0.1))
    known = _feed(tracker, 20, 0.5)  # and off it
    assert (known.low[0], known.high[0]) == (pytest.approx(0.5), np.inf)
    assert _feed(tracker, 1100, 0.0).low[0] == 0.0  # forgotten


@pytest.mark.parametrize("world", ["rigid", "mujoco"])
def test_slippery_ground_is_known_soon_after_the_first_slip(world: str) -> None:
    wait, answers, low = friction_answers(world, 0.25)
    assert wait <= 0.06
    assert 0.18 < answers.min() <= answers.max() < 0.32
    assert low < 0.28


def test_wrong_input_is_named_and_changes_nothing() -> None:
    with pytest.raises(ProblemError, match="contacts"):
        sf.FrictionTracker(0, 0.001, least=1.0)
    with pytest.raises(ProblemError, match="dt"):
        sf.FrictionTracker(1, 0.02, least=1.0)
    tracker = sf.FrictionTracker(1, 0.001, least=5.0)
    _feed(tracker, 20, 0.4)
    with pytest.raises(ProblemError, match="forces"):
        tracker.update([[np.nan, 0.0, 1.0]], [[0.0, 0.0, 0.0]])
    with pytest.raises(ProblemError, match="velocities must have shape"):
        tracker.update([[0.0, 0.0, 1.0]], [[0.0, 0.0]])
    assert tracker.believed(0.0)[0] == pytest.approx(0.4)
    with pytest.raises(ProblemError, match="margin"):
        tracker.believed(0.5, margin=1.0)
    tracker.reset()
    assert tracker.believed(0.1)[0] == 0.1
