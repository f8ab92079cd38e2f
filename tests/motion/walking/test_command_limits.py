"""Commands within what joints, friction and stairs allow, and the reasons that are given."""

from __future__ import annotations

import math

import numpy as np
import pytest

from surefoot.base.errors import ProblemError
from surefoot.mechanics.terrain import FlatTerrain, SlopeTerrain, StairsTerrain, Terrain
from surefoot.motion.gaits.adaptive_gait import AdaptiveGait, Pace
from surefoot.motion.gaits.gait import Gait
from surefoot.motion.gaits.library import named_gait
from surefoot.motion.walking.command_limits import LeggedBody, Limits, ground_left, hurried
from surefoot.motion.walking.gait_choice import GaitChoice, choose_gait
from surefoot.motion.walking.leg_demand import LegDemand
from surefoot.motion.walking.pace_settings import SPEED_LIMITS
from surefoot.motion.walking.walking_body import VelocityCommand
from tests.robots import go2

HEIGHT = 0.316
PACE = Pace(0.41, 0.55, 0.07)


def limits(terrain: Terrain | None = None, adaptable: bool = True, mu: float = 0.54) -> Limits:
    return Limits(LeggedBody(go2(), HEIGHT, 0.07, terrain or FlatTerrain(), mu), PACE, adaptable)


def chosen(velocity: tuple[float, float, float], gait: str = "trot") -> GaitChoice:
    body = LeggedBody(go2(), HEIGHT, 0.07, FlatTerrain(), 0.54)
    return choose_gait(body, VelocityCommand.constant(*velocity), gait)


def test_a_slow_command_stays_and_the_gait_keeps_its_time() -> None:
    out = limits().limit(VelocityCommand.constant(0.5, 0.1, 0.3))
    assert out.command.values.tolist() == [[0.5, 0.1, 0.3]]
    assert out.notes == []
    assert out.hurry.max() == 0.0


@pytest.mark.parametrize("velocity", [(9.0, 0.0, 0.0), (0.0, 9.0, 0.0), (-9.0, 0.0, 3.0)])
def test_an_impossible_command_is_slowed_to_the_edge_of_the_possible(
    velocity: tuple[float, float, float],
) -> None:
    bound = limits()
    out = bound.limit(VelocityCommand(np.array([0.0, 1.0]), np.array([[0.3, 0.0, 0.0], velocity])))
    assert out.command.values[0].tolist() == [0.3, 0.0, 0.0]
    slowed = out.command.values[1]
    share = float(np.linalg.norm(slowed) / np.linalg.norm(velocity))
    assert slowed == pytest.approx(share * np.array(velocity))
    assert 0.1 < share < 0.9
    assert len(out.notes) == 1
    assert "from 1 s on is more than this gait can do: slowed to" in out.notes[0]
    assert "limit" in out.notes[0] or "allowed" in out.notes[0] or "reach" in out.notes[0]
    table = LegDemand(go2(), np.array(velocity), HEIGHT)
    pace = hurried(PACE, out.hurry_at(bound.size_of(slowed)))
    assert bound.use(table, pace, share)[0] <= SPEED_LIMITS.most_speed + 1e-3
    faster = [bound.use(table, hurried(PACE, s), 1.02 * share) for s in np.linspace(0.0, 1.0, 21)]
    assert all(speed > SPEED_LIMITS.most_speed or torque > 1.0 for speed, torque, _ in faster)


def test_the_gait_hurries_no_more_than_the_joints_need() -> None:
    bound = limits()
    out = bound.limit(VelocityCommand.constant(2.0))
    assert (np.diff(out.hurry) >= 0.0).all()
    assert 0.3 < out.hurry_at(2.0) < 1.0
    assert out.hurry_at(0.6) == 0.0
    table = LegDemand(go2(), np.array([2.0, 0.0, 0.0]), HEIGHT)
    assert bound.use(table, hurried(PACE, out.hurry_at(2.0)), 1.0)[0] <= SPEED_LIMITS.timing_speed
    assert bound.use(table, hurried(PACE, out.hurry_at(2.0) - 0.1), 1.0)[0] > SPEED_LIMITS.timing_speed


def test_a_gait_with_given_times_keeps_them_and_is_slowed_earlier() -> None:
    fixed = limits(adaptable=False).limit(VelocityCommand.constant(2.4))
    free = limits().limit(VelocityCommand.constant(2.4))
    assert free.command.values[0, 0] == pytest.approx(2.4)
    assert 1.0 < fixed.command.values[0, 0] < 1.8
    assert fixed.hurry.max() == 0.0


@pytest.mark.parametrize(("degrees", "most"), [(25.0, 0.3), (20.0, 0.8), (-20.0, 0.8), (10.0, 5.0)])
def test_a_slope_leaves_less_the_steeper_it_is(degrees: float, most: float) -> None:
    ground = ground_left(SlopeTerrain(degrees), 0.54, HEIGHT)
    assert 0.5 * most < ground.fastest < most
    assert np.linalg.norm(ground.up) == pytest.approx(1.0)
    assert ground.up[2] == pytest.approx(math.cos(math.radians(degrees)))
    out = limits(SlopeTerrain(degrees)).limit(VelocityCommand.constant(0.4))
    assert (len(out.notes) == 1) is (most < 0.4)
    assert not out.notes or "leaves 14 % of the friction 0.54" in out.notes[0]


def test_slopes_of_a_ground_of_ones_own_bound_speed_as_a_plane_does() -> None:
    class Ramp(Terrain):
        steepness = math.tan(math.radians(25.0))  # type: ignore[assignment]

        def height(self, xy: np.ndarray) -> np.ndarray:  # type: ignore[override]
            return np.maximum(self.steepness * (np.asarray(xy)[..., 0] - 1.0), 0.0)

    command = VelocityCommand.constant(0.4)
    out, plane = limits(Ramp()).limit(command), limits(SlopeTerrain(25.0)).limit(command)
    assert out.notes == plane.notes


def test_too_little_friction_stops_it() -> None:
    outs = [limits(SlopeTerrain(20.0), mu=mu).limit(VelocityCommand.constant(0.4)) for mu in (0.3, 0.0)]
    assert not any(out.command.values.any() for out in outs)


def test_high_steps_are_taken_slowly_and_steep_stairs_not_at_all() -> None:
    fastest = [ground_left(StairsTerrain(rise, 0.4), 0.54, HEIGHT).fastest for rise in (0.05, 0.12, 0.15)]
    assert fastest == pytest.approx([0.629, 0.406, 0.363], abs=0.005)
    assert ground_left(StairsTerrain(-0.12, 0.3), 0.54, HEIGHT).fastest == pytest.approx(fastest[1])
    steep = [ground_left(StairsTerrain(0.12, tread), 0.54, HEIGHT).fastest for tread in (0.24, 0.233, 0.22)]
    assert steep[0] == pytest.approx(fastest[1])
    assert 0.0 < steep[1] < 0.7 * fastest[1]
    assert steep[2] == 0.0
    out = limits(StairsTerrain(0.12, 0.25)).limit(VelocityCommand.constant(0.5))
    assert "steps of 120 mm are taken at up to 0.41 m/s" in out.notes[0]
    out = limits(StairsTerrain(0.12, 0.22)).limit(VelocityCommand.constant(0.5))
    assert "steepness 0.55" in out.notes[0]
    assert not out.command.values.any()


def test_a_name_stays_a_plain_gait_until_it_must_hurry() -> None:
    slow, fast = chosen((0.5, 0.0, 0.0)), chosen((2.0, 0.0, 0.0))
    assert isinstance(slow.schedule, Gait)
    assert isinstance(fast.schedule, AdaptiveGait)
    assert fast.schedule.name == "trot"
    fast.schedule.follow(0.0, np.array([2.0, 0.0, 0.0]))
    fast.schedule.horizon(0.0, 0.1, 40)
    assert fast.schedule.pace.duty < 0.45
    assert fast.shortest < slow.shortest


def test_auto_stands_walks_and_trots() -> None:
    def kinds(speed: float) -> tuple[str, bool]:
        schedule = chosen((2.0, 0.0, 0.0), "auto").schedule
        assert isinstance(schedule, AdaptiveGait)
        schedule.reset()
        schedule.follow(0.0, np.array([speed, 0.0, 0.0]))
        return schedule.wanted.name, schedule.wanted.moving

    assert kinds(0.0)[1] is False
    assert kinds(0.15) == ("walk", True)
    assert kinds(0.5) == kinds(1.8) == ("trot", True)


def test_wrong_names_and_feet_are_told() -> None:
    with pytest.raises(ProblemError, match="auto"):
        chosen((0.5, 0.0, 0.0), "gallop")
    body = LeggedBody(go2(), HEIGHT, 0.07, FlatTerrain(), 0.54)
    with pytest.raises(ProblemError, match="the gait is for 2 feet"):
        choose_gait(body, VelocityCommand.constant(0.5), named_gait("walk", 2))
