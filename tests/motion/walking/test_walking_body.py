"""The wanted motion: commands from files, ramps, the leash, and the ground under the feet."""

import math
from pathlib import Path

import numpy as np
import pytest

from surefoot.base.errors import ProblemError
from surefoot.motion.walking.body_settings import BODY_MOTION
from surefoot.motion.walking.walking_body import BodyPlan, VelocityCommand, limit_command
from surefoot.motion.walking.walking_kernels import advance_body, body_rise

FEET = np.array([[0.2, 0.15, 0.0], [0.2, -0.15, 0.0], [-0.2, 0.15, 0.0], [-0.2, -0.15, 0.0]])


def run(plan: BodyPlan, command: tuple[float, float, float], duration: float, dt: float = 1e-3) -> None:
    for _ in range(round(duration / dt)):
        plan.advance(np.array(command), plan.position.copy(), dt)


def test_a_command_is_read_from_a_file(tmp_path: Path) -> None:
    file = tmp_path / "v.csv"
    file.write_text("time, vx, vy, wz\n0, 0.5, 0, 0\n\n2.5 0.2 -0.1 0.3 # slower\n")
    command = VelocityCommand.read(file)
    assert command.at(2.49).tolist() == [0.5, 0.0, 0.0]
    assert command.at(2.5).tolist() == [0.2, -0.1, 0.3]
    assert command.at(99.0).tolist() == [0.2, -0.1, 0.3]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("0 0.5 0 0\n1 fast 0 0\n", r"line 2: expected four numbers"),
        ("0 0.5 0\n", r"line 1: expected time vx vy yaw_rate"),
        ("# nothing\n", r"holds no line"),
        ("1 0.5 0 0\n", r"command times must rise from 0"),
        ("0 0.5 0 0\n0 0.5 0 0\n", r"command times must rise from 0"),
        ("0 nan 0 0\n", r"is NaN"),
        ("0 inf 0 0\n", r"is infinite"),
    ],
)
def test_wrong_files_are_told(text: str, message: str, tmp_path: Path) -> None:
    file = tmp_path / "v.txt"
    file.write_text(text)
    with pytest.raises(ProblemError, match=message):
        VelocityCommand.read(file)


def test_a_missing_file_is_told(tmp_path: Path) -> None:
    with pytest.raises(ProblemError, match="cannot read the velocity file"):
        VelocityCommand.read(tmp_path / "none.txt")


def test_an_impossible_speed_is_slowed_and_said() -> None:
    command = VelocityCommand(np.array([0.0, 1.0]), np.array([[0.5, 0.0, 0.0], [9.0, 0.0, 3.0]]))
    slowed, notes = limit_command(command, 0.15, 0.25, 0.3, 0.25)
    assert slowed.values[0].tolist() == [0.5, 0.0, 0.0]
    assert np.linalg.norm(slowed.values[1, :2]) + 0.25 * slowed.values[1, 2] == pytest.approx(1.2)
    assert slowed.values[1, 0] / slowed.values[1, 2] == pytest.approx(3.0)
    assert len(notes) == 1
    assert "from 1 s on is more than this gait can do: slowed to" in notes[0]


def test_the_velocity_is_ramped_and_integrated() -> None:
    plan = BodyPlan(0.3, np.array([0.0, 0.0, 0.3]), 0.0)
    run(plan, (0.6, 0.0, 0.0), 0.1)
    assert plan.velocity[0] == pytest.approx(BODY_MOTION.acceleration * 9.81 * 0.1)
    run(plan, (0.6, 0.0, 0.0), 2.9)
    assert plan.velocity.tolist() == pytest.approx([0.6, 0.0, 0.0])
    ramp = 0.6 / (BODY_MOTION.acceleration * 9.81)
    assert plan.position[0] == pytest.approx(0.6 * (3.0 - 0.5 * ramp), rel=1e-3)


def test_a_turning_plan_walks_a_circle() -> None:
    plan = BodyPlan(0.3, np.array([0.0, 0.0, 0.3]), 0.0, velocity=np.array([0.5, 0.0, 0.5]))
    run(plan, (0.5, 0.0, 0.5), 2.0 * np.pi / 0.5)
    assert plan.position[:2] == pytest.approx([0.0, 0.0], abs=2e-3)
    assert plan.yaw == pytest.approx(2.0 * np.pi, abs=1e-3)


def test_the_plan_does_not_run_away_from_the_body() -> None:
    plan = BodyPlan(0.3, np.array([0.0, 0.0, 0.3]), 0.0)
    for _ in range(5000):
        plan.advance(np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 0.3]), 1e-3)
    assert 0.0 < plan.position[0] < 0.2


def test_the_predicted_places_are_those_that_come() -> None:
    plan = BodyPlan(0.3, np.array([0.0, 0.0, 0.3]), 0.2, velocity=np.array([0.5, 0.1, 0.4]))
    yaw, places, _ = plan.places(np.array([0.3]))
    run(plan, (0.5, 0.1, 0.4), 0.3)
    assert yaw[0] == pytest.approx(plan.yaw)
    assert places[0] == pytest.approx(plan.position, abs=1e-3)


def test_the_reference_follows_the_ground_under_the_feet() -> None:
    feet = FEET.copy()
    feet[:, 2] = 0.2 * feet[:, 0] + 0.1
    plan = BodyPlan(0.3, np.array([0.0, 0.0, 0.3]), 0.0, velocity=np.array([0.5, 0.0, 0.0]))
    plan.fit_ground(feet, np.inf)
    reference = plan.reference(4, 0.05)
    # a damped fit: the slope is a little less than that of the feet
    assert plan.slope == pytest.approx([0.2, 0.0], abs=1e-3)
    rise = 0.1 + 0.3 * np.hypot(1.0, plan.slope[0])
    assert reference.position[:, 2] - rise == pytest.approx(plan.slope[0] * 0.025 * np.arange(5), abs=1e-6)
    normal = np.array([-plan.slope[0], 0.0, 1.0]) / np.hypot(1.0, plan.slope[0])
    assert reference.rotation[0][:, 2] == pytest.approx(normal)
    assert reference.linear_velocity[0] == pytest.approx([0.5, 0.0, 0.5 * plan.slope[0]])


@pytest.mark.parametrize("yaw", [0.0, 1.0, 2.5])
def test_the_body_is_lower_uphill_and_stands_along_the_normal_downhill(yaw: float) -> None:
    """The same point of the same slope, from two sides: heights at a right angle to it are h cos² and h."""
    up = np.array([np.cos(yaw), np.sin(yaw)])
    heights = []
    for sense in (1.0, -1.0, 0.0):
        plan = BodyPlan(0.3, np.array([0.0, 0.0, 0.3]), yaw, lowered=1.0)
        across = np.array([-up[1], up[0]])
        plan.follow_plane(0.0, 0.4 * (sense * up + (1.0 - abs(sense)) * across), np.inf)
        heights.append(plan.position[2] / np.hypot(1.0, 0.4))
    square = 1.0 / (1.0 + 0.4**2)
    assert heights == pytest.approx([0.3 * square, 0.3, 0.3 * np.sqrt(square)], rel=1e-12)


def test_the_body_comes_down_without_a_jump() -> None:
    plan = BodyPlan(0.3, np.array([0.0, 0.0, 0.3]), 0.0)
    plan.follow_plane(0.0, np.array([0.4, 0.0]), np.inf)
    heights = [plan.position[2]]
    assert heights[0] == pytest.approx(0.3 * np.hypot(1.0, 0.4))
    for _ in range(3000):
        plan.advance(np.zeros(3), np.zeros(3), 1e-3)
        heights.append(plan.position[2])
    assert heights[-1] == pytest.approx(0.3 / np.hypot(1.0, 0.4), rel=1e-4)
    assert np.abs(np.diff(heights)).max() < 0.2e-3  # less than 0.2 m/s


@pytest.mark.parametrize("speed_over", [1.0, 4.0])
@pytest.mark.parametrize("seed", range(3))
def test_a_body_goes_where_it_should(seed: int, speed_over: float) -> None:
    rng = np.random.default_rng(seed)
    position, velocity, slope = rng.normal(size=3), rng.normal(size=3), 0.3 * rng.normal(size=2)
    velocity *= speed_over
    com, command, dt, height = position + 0.2 * rng.normal(size=3), rng.normal(size=3), 0.01, 0.3
    yaw, ground, lowered, most, dip, lead, lowering = 0.4, 0.1, 0.3, 5.0, 0.2, 0.05, 0.3
    place, speed = position.copy(), velocity.copy()
    found = advance_body(
        place, speed, slope, command, com, dt, height, yaw, ground, lowered, most, dip, lead, lowering
    )
    limits = np.array([most, most, most / height]) * dt
    wanted = velocity + np.clip(command - velocity, -limits, limits)
    turned = yaw + wanted[2] * dt
    R = np.array([[math.cos(turned), -math.sin(turned)], [math.sin(turned), math.cos(turned)]])
    flow = R @ wanted[:2]
    ahead = position[:2] + dt * flow - com[:2]
    reach = lead * max(math.sqrt(9.81 * height), float(np.linalg.norm(flow)))
    ahead *= min(1.0, reach / np.linalg.norm(ahead))
    level, low = ground + slope @ flow * dt, lowered + (1.0 - lowered) * dt / lowering
    np.testing.assert_allclose(speed, wanted, atol=1e-13)
    np.testing.assert_allclose(found, (turned, level, low), atol=1e-13)
    np.testing.assert_allclose(place[:2], com[:2] + ahead, atol=1e-12)
    rise = body_rise(slope, turned, height, dip, low)
    assert place[2] == pytest.approx(level + rise, abs=1e-13)
    steep = float(np.linalg.norm(slope))
    climb = float(slope @ R[:, 0])
    sink = dip * min(max(-climb, 0.0), 0.4) * low
    power = 0.5 - 0.5 * low * (1.0 + climb / steep)
    assert rise == pytest.approx(height * (1.0 - sink) * (1.0 + steep**2) ** power)
    assert body_rise(np.zeros(2), yaw, height, dip, low) == height
