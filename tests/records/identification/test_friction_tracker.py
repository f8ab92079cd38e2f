"""The tracker of friction: what feet tell it, and answers in worlds whose friction is known."""

from __future__ import annotations

import numpy as np
import pytest

import surefoot as sf
from benchmarks.slippery_walks import friction_answers
from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError


def _row(use: float, speed: float = 0.0, normal: float = 100.0) -> tuple[FloatArray, FloatArray]:
    return np.array([[use * normal, 0.0, normal]]), np.array([[-speed, 0.0, 0.0]])


def _feed(tracker: sf.FrictionTracker, count: int, *row: float):  # type: ignore[no-untyped-def]
    for _ in range(count):
        known = tracker.update(*_row(*row))
    return known


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


@pytest.mark.parametrize("way", [[0.3, 0.0, 0.0], [0.0, 0.3, 0.0], [-0.2, 0.2, 0.0]])
def test_feet_that_only_an_estimate_moves_do_not_slide(way: list[float]) -> None:
    """Friction of a sliding foot is against its way; that of a standing one is anywhere."""
    tracker = sf.FrictionTracker(1, 0.001, least=5.0)
    for _ in range(60):
        known = tracker.update([[10.0, 0.0, 100.0]], [way])
    assert not known.sliding[0]
    assert known.high[0] == np.inf
    assert known.low[0] == pytest.approx(0.1)


def test_grounds_change() -> None:
    tracker = sf.FrictionTracker(1, 0.001, least=5.0, memory=1.0)
    _feed(tracker, 20, 0.5)
    known = _feed(tracker, 40, 0.1, 0.4)  # onto ice
    assert (known.low[0], known.high[0]) == (pytest.approx(0.1), pytest.approx(0.1))
    known = _feed(tracker, 20, 0.5)  # and off it
    assert (known.low[0], known.high[0]) == (pytest.approx(0.5), np.inf)
    assert _feed(tracker, 1100, 0.0).low[0] == 0.0  # forgotten


@pytest.mark.parametrize("world", ["rigid", "mujoco"])
@pytest.mark.long
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
