"""Whether a walk followed its command: by half at least, along the ground and turning each."""

from __future__ import annotations

import pytest

from surefoot.records.audit.limits import LIMITS
from surefoot.records.audit.summary.walk_summary import AxisTracking, VelocityTracking


def tracking(forward: tuple[float, float], left: tuple[float, float], turn: tuple[float, float]) -> bool:
    """Return whether (commanded, measured) velocities count as followed."""
    axes = [AxisTracking(c, m, m - c, True) for c, m in (forward, left, turn)]
    return VelocityTracking(axes[0], axes[1], axes[2], True).followed


def test_half_of_the_way_is_followed_and_less_is_not() -> None:
    assert LIMITS.walk.followed_share == 0.5
    assert tracking((1.0, 0.51), (0.0, 0.0), (0.0, 0.0))
    assert not tracking((1.0, 0.49), (0.0, 0.0), (0.0, 0.0))
    assert not tracking((1.0, 1.51), (0.0, 0.0), (0.0, 0.0))  # too fast by more than half
    assert not tracking((-1.0, 1.0), (0.0, 0.0), (0.0, 0.0))


def test_the_error_along_the_ground_is_one_vector() -> None:
    """Of 0.5 m/s to the front left an error of 0.25 m/s, in whatever direction."""
    for miss, good in ((0.24, True), (0.26, False)):
        assert tracking((0.4, 0.4 - 0.6 * miss), (0.3, 0.3 + 0.8 * miss), (0.0, 0.0)) == good
    # a turn is judged by itself: no speed along the ground makes up for it
    assert not tracking((1.0, 1.0), (0.0, 0.0), (1.0, 0.4))
    assert tracking((1.0, 1.0), (0.0, 0.0), (1.0, 0.6))


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_who_is_told_to_stand_may_drift_a_little(axis: int) -> None:
    floor = LIMITS.walk.followed_floor
    for share, good in ((0.99, True), (1.01, False)):
        axes = [(0.0, share * floor if k == axis else 0.0) for k in range(3)]
        assert tracking(axes[0], axes[1], axes[2]) == good
