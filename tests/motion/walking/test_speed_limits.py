"""What hurry, slopes and stairs leave of a walk's speed, by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from surefoot.mechanics.terrain import FlatTerrain, SlopeTerrain, StairsTerrain
from surefoot.motion.gaits.adaptive_gait import Pace
from surefoot.motion.walking.command_limits import (
    FRACTIONS,
    HURRIES,
    LeggedBody,
    Limited,
    Limits,
    ground_left,
    hurried,
    slope_speed,
    step_speed,
    use_of,
)
from surefoot.motion.walking.walking_body import VelocityCommand
from tests.robots import go2

HEIGHT = 0.3
FROUDE = math.sqrt(9.81 * HEIGHT)
PACE = Pace(0.4, 0.56, 0.1)


@pytest.mark.parametrize(
    ("share", "least", "period", "duty", "clearance"),
    [
        (0.0, 0.36, 0.4, 0.56, 0.1), (-1.0, 0.36, 0.4, 0.56, 0.1), (1.0, 0.36, 0.28, 0.36, 0.04),
        (0.5, 0.36, 0.37, 0.46, 0.07), (0.5, 0.5, 0.37, 0.53, 0.07), (0.5, 0.9, 0.37, 0.56, 0.07),
    ],
)  # fmt: skip
def test_a_hurried_gait_gives_up_clearance_and_stance_first_and_then_its_period(
    share: float, least: float, period: float, duty: float, clearance: float
) -> None:
    """At the most 0.7 of the period, by the square of the hurry, 0.4 of the clearance and a least duty."""
    pace = hurried(PACE, share, least)
    assert (pace.period, pace.duty, pace.clearance) == pytest.approx((period, duty, clearance))


def test_hurries_and_parts_are_tried_in_even_steps() -> None:
    np.testing.assert_allclose(HURRIES, 0.05 * np.arange(21), atol=1e-12)
    np.testing.assert_allclose(FRACTIONS, 0.1 * np.arange(1, 11), atol=1e-12)


def test_shares_of_limits_are_none_of_the_unknown_and_endless_beyond_reach() -> None:
    shares = use_of(np.array([3.0, 2.0, math.inf, math.nan]), np.array([4.0, math.inf, 9.0, 1.0]))
    np.testing.assert_allclose(shares, [0.75, 0.0, math.inf, math.inf])


@pytest.mark.parametrize(
    ("steepness", "mu", "speed"),
    [
        (0.2, 0.5, 0.75 * FROUDE * 1.5),
        (0.5, 0.5, 0.0),
        (0.6, 0.5, 0.0),
        (0.0, 0.5, math.inf),
        (0.2, 0.0, 0.0),
    ],
)
def test_a_slope_leaves_the_friction_beyond_its_own(steepness: float, mu: float, speed: float) -> None:
    assert slope_speed(steepness, mu, HEIGHT) == pytest.approx(speed)


def test_level_ground_leaves_everything() -> None:
    ground = ground_left(FlatTerrain(), 0.5, HEIGHT)
    assert (ground.up.tolist(), ground.fastest, ground.reason) == ([0.0, 0.0, 1.0], math.inf, "")


def test_a_slope_tells_the_vertical_along_it_and_the_friction_that_is_left() -> None:
    """Of 20 degrees, tan 0.364, with a friction of 0.5: 27 %."""
    angle = math.radians(20.0)
    ground = ground_left(SlopeTerrain(20.0), 0.5, HEIGHT)
    np.testing.assert_allclose(ground.up, [math.sin(angle), 0.0, math.cos(angle)], atol=1e-12)
    assert ground.fastest == pytest.approx(0.75 * FROUDE * (0.5 / math.tan(angle) - 1.0))
    assert "slope of 0.36 leaves 27 % of the friction 0.50" in ground.reason
    for mu in (0.0, 0.3):
        none = ground_left(SlopeTerrain(20.0), mu, HEIGHT)
        assert none.fastest == 0.0
        assert f"leaves 0 % of the friction {mu:.2f}" in none.reason


@pytest.mark.parametrize(
    ("tread", "share", "reason"),
    [
        (0.3, 1.0, "steps of 120 mm are taken at up to 0.39 m/s"),
        (0.2401, 1.0, "steps of 120 mm are taken at up to 0.39 m/s"),
        (0.12 / 0.515, 0.5, "stairs of steepness 0.52 are too steep (up to 0.5 is well)"),
        (0.2, 0.0, "stairs of steepness 0.60 are too steep (up to 0.5 is well)"),
    ],
)
def test_stairs_are_slower_the_higher_their_steps_and_end_where_they_are_steep(
    tread: float, share: float, reason: str
) -> None:
    """0.142 h sqrt(g / rise), all of it up to a steepness of 0.5 and nothing from 0.53 on."""
    stairs = StairsTerrain(0.12, tread)
    fastest = share * 0.142 * HEIGHT * math.sqrt(9.81 / 0.12)
    ground = ground_left(stairs, 0.5, HEIGHT)
    assert step_speed(stairs, HEIGHT) == pytest.approx(fastest, rel=1e-9)
    assert ground.fastest == pytest.approx(fastest, rel=1e-9)
    assert ground.up.tolist() == [0.0, 0.0, 1.0]
    assert ground.reason == reason


def test_a_velocity_is_as_large_as_its_feet_go() -> None:
    """3-4-5, and a turn at the farthest foot from their middle."""
    limits = Limits(LeggedBody(go2(), HEIGHT, 0.07, FlatTerrain(), 0.5), PACE, True)
    feet = go2().foot_positions(go2().nominal)[:, :2]
    radius = max(math.dist(foot, feet.mean(axis=0)) for foot in feet)
    assert limits.radius == pytest.approx(radius)
    assert limits.size_of(np.array([0.3, -0.4, -2.0])) == pytest.approx(0.5 + 2.0 * radius)
    assert len(limits.hurries) == 21
    assert len(Limits(LeggedBody(go2(), HEIGHT, 0.07, FlatTerrain(), 0.5), PACE, False).hurries) == 1
    assert limits.hurried(1.0).duty == pytest.approx(0.36)


def test_a_gait_stays_ready_for_three_commands() -> None:
    limits = Limits(LeggedBody(go2(), HEIGHT, 0.07, FlatTerrain(), 0.5), PACE, True)
    limits.slowed(VelocityCommand.constant(1.5))
    hurried_pace = limits.pace_at(np.array([1.5, 0.0, 0.0]))
    assert hurried_pace.period < PACE.period
    for _ in range(2):
        limits.slowed(VelocityCommand.constant(0.1))
        assert limits.pace_at(np.array([1.5, 0.0, 0.0])) == hurried_pace
    limits.slowed(VelocityCommand.constant(0.1))
    assert limits.pace_at(np.array([1.5, 0.0, 0.0])).period > hurried_pace.period + 0.01


def test_a_gait_on_a_plane_is_brisk_from_a_third_of_the_froude_speed_on() -> None:
    """Nothing up to 0.35 sqrt(g h), 0.26 from 0.55 on, by a straight line between."""
    strong = Limits(LeggedBody(go2(), HEIGHT, 0.07, FlatTerrain(), 0.5), Pace(0.2, 0.5, 0.02), True)
    found = strong.limit(VelocityCommand.constant(0.6 * FROUDE))
    assert found.notes == []
    for speed in (0.3, 0.36, 0.42, 0.48, 0.54, 0.6):
        expected = 0.26 * min(max((speed - 0.35) / 0.2, 0.0), 1.0)
        assert found.hurry_at(speed * FROUDE) == pytest.approx(expected, abs=1e-9)
    stairs = Limits(
        LeggedBody(go2(), HEIGHT, 0.07, StairsTerrain(0.04, 1.5), 0.5), Pace(0.2, 0.5, 0.02), True
    )
    assert stairs.limit(VelocityCommand.constant(0.6 * FROUDE)).hurry.max() == 0.0


def test_a_hurry_between_two_speeds_is_on_a_line_between_theirs() -> None:
    limited = Limited(VelocityCommand.constant(0.0), [], np.array([0.0, 1.0]), np.array([0.2, 0.6]))
    assert [limited.hurry_at(size) for size in (-1.0, 0.25, 2.0)] == pytest.approx([0.2, 0.3, 0.6])
