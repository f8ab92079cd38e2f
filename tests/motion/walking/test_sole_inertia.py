"""What soles weigh to those who move them, against forward dynamics; and who is refused or slowed by it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio
import pytest

from surefoot.base.errors import ModelError
from surefoot.mechanics import Robot, actuators_of, load_robot, with_rotors
from surefoot.motion.walking.biped.sole_inertia import check_rotors, sole_inertias, turning_share
from surefoot.motion.walking.walkers import walking_controller
from surefoot.motion.walking.walking_body import VelocityCommand


def _turned_by(robot: Robot, foot: int, axis: int) -> float:
    """Return the angular acceleration of a sole per moment on it about an axis of the world [1/(kg m²)]."""
    model, q, v = robot.model, robot.nominal, np.zeros(robot.model.nv)
    accelerations = []
    for size in (0.0, 1.0):
        data = model.createData()
        pinocchio.framesForwardKinematics(model, data, q)
        frame = model.frames[robot.feet[foot].frame]
        joint = int(frame.parentJoint)
        moment = data.oMi[joint].rotation.T @ (size * np.eye(3)[axis])
        outside = [pinocchio.Force.Zero() for _ in range(model.njoints)]
        outside[joint] = pinocchio.Force(np.zeros(3), moment)
        a = pinocchio.aba(model, data, q, v, np.zeros(model.nv), outside)
        pinocchio.forwardKinematics(model, data, q, v, a)
        accelerations.append(data.oMi[joint].rotation @ data.a[joint].angular)
    return float((accelerations[1] - accelerations[0])[axis])


def test_moments_of_inertia_are_those_of_forward_dynamics() -> None:
    robot = load_robot("g1")
    found = sole_inertias(robot)
    for foot in range(2):
        for axis in range(2):
            assert 1.0 / found[foot, 1 + axis] == pytest.approx(_turned_by(robot, foot, axis), rel=1e-8)


def test_rotors_make_soles_heavy() -> None:
    robot = load_robot("g1")
    motors = actuators_of(robot, "real")
    assert motors is not None
    bare, real = sole_inertias(robot), sole_inertias(robot, motors)
    assert (real > bare).all()
    np.testing.assert_allclose(real, sole_inertias(with_rotors(robot, motors.armature)))


def test_legs_heavier_to_move_than_the_robot_are_refused() -> None:
    robot = load_robot("g1")
    motors = actuators_of(robot, "real")
    assert motors is not None
    heavy = replace(motors, armature=np.full(robot.joints, 5.0))
    with pytest.raises(ModelError, match=r"ankle_roll_link is as heavy to lift as .* kg, .* times the robot"):
        walking_controller(robot, VelocityCommand.constant(0.0), actuators=heavy)
    check_rotors(robot, sole_inertias(robot, motors))


@pytest.mark.parametrize("name", ["g1", "talos", "icub", "romeo"])
def test_soles_of_the_catalogue_keep_their_damping(name: str) -> None:
    robot = load_robot(name)
    assert turning_share(robot, sole_inertias(robot)) == 1.0


def test_damping_is_slowed_for_light_soles_alone() -> None:
    robot = load_robot("g1")
    usual = sole_inertias(robot)
    shares = [turning_share(robot, usual / np.array([1.0, k, k])) for k in (1.0, 4.0, 8.0)]
    assert shares[0] == 1.0
    assert shares[1] == pytest.approx(2.0 * shares[2])
    assert shares[1] < 0.5
    assert turning_share(robot, usual / np.array([1.0, 8.0, 1.0])) == 1.0  # one axis alone
