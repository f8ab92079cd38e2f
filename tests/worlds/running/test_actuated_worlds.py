"""Rotors, friction and motors in the worlds that have them, against closed forms of one joint."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.errors import ProblemError
from surefoot.mechanics.robot.actuators import Actuators
from surefoot.mechanics.robot.motor_limits import MotorLimits
from surefoot.worlds.interface.world_names import make_world
from tests.moving import advance, lifted

LINK = """<link name="{0}"><inertial><mass value="1"/>
<inertia ixx="0.02" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial>
<collision><geometry><sphere radius="0.02"/></geometry></collision></link>
<joint name="{0} axle" type="revolute"><parent link="base"/><child link="{0}"/><axis xyz="0 0 1"/>
<origin xyz="0 {1} 1"/><limit effort="5" velocity="20" lower="-1000" upper="1000"/></joint>"""
URDF = '<robot name="discs"><link name="base"/>' + LINK.format("one", 0) + LINK.format("two", 1) + "</robot>"
INERTIA, ROTOR = 0.02, 0.03
WORLDS = ["mujoco", "rigid"]


@pytest.fixture(scope="module")
def disc(tmp_path_factory: pytest.TempPathFactory) -> sf.Robot:
    """Two discs on vertical axles: gravity does nothing, and the second stays where it is."""
    path = Path(tmp_path_factory.mktemp("discs")) / "discs.urdf"
    path.write_text(URDF, encoding="utf-8")
    return sf.load_robot(path, feet=["one"], fixed_base=True)


def motors(damping: float = 0.0, friction: float = 0.0, knee: float = 0.5) -> Actuators:
    limits = MotorLimits(np.full(2, 5.0), np.full(2, 20.0), knee, 0.8)
    return Actuators(np.full(2, ROTOR), np.full(2, damping), np.full(2, friction), limits)


def spin(
    world: str, disc: sf.Robot, actuators: Actuators | str, torque: float, v: float, time: float
) -> float:
    """Return the speed of the axle [rad/s] after a time under a torque."""
    there = make_world(world, disc, actuators=actuators)
    there.reset(np.zeros(2), np.array([v, 0.0]))
    advance(there, round(time / there.dt), np.array([torque, 0.0]))
    return float(there.q_v()[1][0])


@pytest.mark.parametrize("world", WORLDS)
def test_a_rotor_adds_to_the_inertia(disc: sf.Robot, world: str) -> None:
    assert spin(world, disc, motors(), 1.0, 0.0, 0.1) == pytest.approx(0.1 / (INERTIA + ROTOR), rel=1e-9)
    assert spin(world, disc, "ideal", 1.0, 0.0, 0.1) == pytest.approx(0.1 / INERTIA, rel=1e-9)


@pytest.mark.parametrize("world", WORLDS)
def test_damping_slows_exponentially(disc: sf.Robot, world: str) -> None:
    left = spin(world, disc, motors(damping=0.1), 0.0, 5.0, 0.5)
    assert left == pytest.approx(5.0 * math.exp(-0.1 * 0.5 / (INERTIA + ROTOR)), rel=3e-3)


@pytest.mark.parametrize("world", WORLDS)
def test_dry_friction_takes_its_torque_and_holds(disc: sf.Robot, world: str) -> None:
    rubbed = motors(friction=0.5)
    slowed = spin(world, disc, rubbed, 0.0, 5.0, 0.3)
    assert slowed == pytest.approx(5.0 - 0.5 * 0.3 / (INERTIA + ROTOR), rel=2e-3)
    assert abs(spin(world, disc, rubbed, 0.0, 5.0, 0.7)) < 1e-3  # stopped after 0.5 s
    assert abs(spin(world, disc, rubbed, 0.4, 0.0, 0.5)) < 0.05  # below the friction it only creeps
    driven = spin(world, disc, rubbed, 0.9, 0.0, 0.3)
    assert driven == pytest.approx(0.4 * 0.3 / (INERTIA + ROTOR), rel=0.02)


@pytest.mark.parametrize("world", WORLDS)
def test_a_motor_drives_up_to_its_no_load_speed(disc: sf.Robot, world: str) -> None:
    """Below half of 20 rad/s it gives 0.8 of 5 N m, and from there linearly less."""
    wanted = motors()
    below = spin(world, disc, wanted, 100.0, 1e-9, 0.1)
    assert below == pytest.approx(4.0 * 0.1 / (INERTIA + ROTOR), rel=1e-9)
    late = spin(world, disc, wanted, 100.0, 10.0, 0.2)
    rate = 4.0 / 10.0 / (INERTIA + ROTOR)
    assert late == pytest.approx(20.0 - 10.0 * math.exp(-rate * 0.2), rel=2e-3)
    assert spin(world, disc, wanted, -100.0, 25.0, 0.1) == pytest.approx(25.0 - 5.0 * 0.1 / 0.05, rel=1e-9)


@pytest.mark.parametrize("world", WORLDS)
def test_what_was_given_is_told(disc: sf.Robot, world: str) -> None:
    there = make_world(world, disc, actuators=motors())
    there.reset(np.zeros(2), np.array([15.0, 0.0]))
    there.step(np.array([9.0, 0.0]))
    assert there.applied == pytest.approx([2.0, 0.0])


def test_steps_with_friction_are_not_differentiated(disc: sf.Robot) -> None:
    world = sf.RigidWorld(disc, actuators=motors())
    world.step(np.zeros(2))
    with pytest.raises(ProblemError, match="ideal"):
        world.derivative()


def test_both_worlds_drop_a_braked_robot_alike() -> None:
    """A Go2 that hangs in the air, its motors holding against the fall of its legs: one motion in both."""
    robot = sf.load_robot("go2")
    q = lifted(robot.nominal, 1.0)
    ends = []
    for name in WORLDS:
        world = make_world(name, robot, actuators="real", dt=2e-4)
        world.reset(q)
        for k in range(1000):
            _, v = world.q_v()
            world.step(np.full(12, 5.0 * math.sin(0.02 * k)) - 0.1 * v[6:])
        ends.append(world.q_v())
    np.testing.assert_allclose(ends[0][0], ends[1][0], atol=5e-3)
    assert np.abs(ends[0][0][7:] - q[7:]).max() > 0.1
