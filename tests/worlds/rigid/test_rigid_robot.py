"""Robots in the rigid world with the standing controller."""

from __future__ import annotations

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics.dynamics.arithmetic import turned
from surefoot.mechanics.terrain import rough_ground
from surefoot.motion.control.controller import RobotState
from surefoot.motion.standing.standing_controller import StandingController
from surefoot.motion.standing.standing_plan import StandingPlan
from surefoot.motion.walking.walkers import walking_controller
from surefoot.worlds.rigid.rigid_world import RigidWorld


def dropped(name, height, seconds, terrain=None, **settings):
    """Run the drop; return the world and per-step readings."""
    ground = sf.FlatTerrain() if terrain is None else terrain
    robot = sf.load_robot(name)
    q = sf.place(robot, ground)
    controller = StandingController(robot, StandingPlan(robot, ground, q), ground, q)
    world = RigidWorld(robot, ground, **settings)
    start = q.copy()
    start[2] += height
    world.reset(start)
    rows = {"normal": [], "gap": [], "excess": [], "work": [], "speed": []}
    given, begin = 0.0, world.energy()
    for k in range(round(seconds / world.dt)):
        q, v = world.q_v()
        torques = controller.step(RobotState(q, v, k * world.dt)).torques
        world.step(torques)
        reading, (moved, after) = world.contacts(), world.q_v()
        given += torques @ (moved - q)[7:]
        rows["normal"].append(reading.forces[:, 2].sum())
        rows["gap"].append(reading.gaps.min())
        rows["excess"].append(world.energy() - begin - given)
        rows["work"].append(world.contact_work())
        rows["speed"].append(np.abs(after).max())
    return world, {key: np.array(values) for key, values in rows.items()}


@pytest.mark.parametrize(
    ("name", "height", "seconds", "last", "tolerance", "excess", "work", "speed"),
    [
        # energy beyond what the motors gave: never
        pytest.param("go2", 0.3, 4.0, 500, 5e-3, 0.0, 1e-10, 0.02, id="go2 from 30 cm"),
        pytest.param("g1", 0.02, 1.0, 100, 0.05, 1e-6, 1e-9, np.inf, id="g1 on eight corners"),
    ],
)
def test_a_dropped_robot_comes_to_rest(name, height, seconds, last, tolerance, excess, work, speed):
    world, rows = dropped(name, height, seconds)
    weight = world.robot.mass * GRAVITY
    assert np.abs(rows["normal"][-last:] / weight - 1.0).max() < tolerance
    assert rows["gap"].min() > -5e-4
    assert rows["excess"].max() <= excess
    assert rows["work"].max() < work
    assert rows["speed"][-1] < speed
    assert world.unsolved == 0


@pytest.mark.parametrize(
    "terrain", [rough_ground(1, 0.1), sf.StairsTerrain(0.05, 0.2, 5)], ids=["rough", "stairs"]
)
def test_go2_stands_on_uneven_ground(terrain):
    world, rows = dropped("go2", 0.0, 0.5, terrain)
    reading = world.contacts()
    frames = np.array([terrain.frame(p[:2]) for p in reading.positions])
    total = np.einsum("nij,nj->i", frames, reading.forces)
    assert total == pytest.approx([0, 0, world.robot.mass * GRAVITY], abs=3.0)
    assert rows["gap"].min() > -5e-5
    assert rows["speed"][-1] < 0.05
    assert world.unsolved == 0


def test_applied_torques_are_what_the_motors_give():
    """A motor at rest gives its peak torque at the most: what is asked beyond it is cut there."""
    robot = sf.load_robot("go2")
    world = RigidWorld(robot, actuators="real")
    asked = np.zeros(robot.joints)
    asked[:2] = 5.0, -1000.0
    world.step(asked)
    assert world.applied[0] == pytest.approx(5.0)
    assert -1000.0 < world.applied[1] < -5.0
    assert np.abs(world.applied[1]) <= robot.effort_limits[1] * (1.0 + 1e-12)
    np.testing.assert_allclose(world.applied[2:], 0.0)


def test_corners_of_a_sole_that_turns_stay_in_its_plane() -> None:
    """One is pressed and has a swerve, the sole has it: laws of a plane hold for all its corners at once."""
    frames = np.tile(np.eye(3), (5, 1, 1))
    leaving, foot = np.zeros((5, 3)), np.array([0, 0, 0, 0, 1])
    arriving = np.tile([0.0, 0.0, -1e-4], (5, 1))
    impulses = np.zeros((5, 3))
    impulses[1, 2] = 1.0
    _, swerve = turned(arriving, leaving, impulses, foot, frames, 0.0)
    np.testing.assert_allclose(swerve[:4], 0.5 * arriving[:4], rtol=1e-12)
    assert not swerve[4].any()  # nothing presses the other foot


@pytest.mark.long
@pytest.mark.parametrize(("name", "most"), [("talos", 0.05), ("g1", 0.05), ("icub", 0.08)])
def test_corners_share_the_load_alike_from_step_to_step(name: str, most: float) -> None:
    """By one diagonal now and by the other one in the next step: in 16, 36 and 56 % of the steps once."""
    robot = sf.load_robot(name)
    speed = 0.3 * np.sqrt(GRAVITY * robot.nominal[2])
    walker = walking_controller(robot, sf.VelocityCommand.constant(round(float(speed), 2)))
    log = sf.run(RigidWorld(robot), walker, sf.Scenario(2.0, 0.6))
    normal = np.asarray(log["forces"])[..., 2]
    jumps = np.abs(np.diff(normal, axis=0)).max(axis=1) > 0.1 * normal[1:].sum(axis=1)
    assert jumps.mean() < most
    assert not [one for one in sf.audit_log(log).symptoms if str(one).startswith("chatter: all")]
