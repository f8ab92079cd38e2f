"""What a whole-body command says of its tasks and limits, against Pinocchio and by cases that are known."""

from __future__ import annotations

import pickle

import numpy as np
import pinocchio
import pytest

from surefoot.contact import Status
from surefoot.motion.control.whole_body import ForceLimits, Tasks, WholeBodyController
from surefoot.motion.control.whole_body_outcome import BindingLimit
from tests.motion.control.test_whole_body import GRAVITY, centre_accelerations, random_case
from tests.robots import robot_of


def standing(robot, **changes) -> Tasks:
    """Return the tasks of a robot that stands still on level ground."""
    n, points = len(robot.feet), len(robot.contact_points)
    forces = np.tile([0.0, 0.0, robot.mass * GRAVITY / points], (points, 1))
    tasks = Tasks(
        np.ones(n, dtype=bool), np.zeros(3), np.zeros(3), np.zeros((n, 6)), np.zeros(robot.joints), forces,
        np.tile(np.eye(3), (n, 1, 1)), np.zeros(n),
    )  # fmt: skip
    return tasks._replace(**changes)


def step(robot, tasks: Tasks, limits: ForceLimits | None = None, **options):
    """Return the command for a robot at rest in its nominal pose."""
    controller = WholeBodyController(robot, **options)
    still = robot.nominal, np.zeros(robot.model.nv)
    return controller.step(*still, tasks) if limits is None else controller.step(*still, tasks, limits)


@pytest.mark.parametrize("name", ["go2", "g1"])
@pytest.mark.parametrize("seed", range(4))
def test_what_is_got_is_what_pinocchio_says_of_the_command(name: str, seed: int) -> None:
    robot, q, v, tasks = random_case(name, 700 + seed)
    command = WholeBodyController(robot, effort_limits=np.full(robot.joints, np.inf)).step(q, v, tasks)
    data = robot.model.createData()
    pinocchio.centerOfMass(robot.model, data, q, v, command.accelerations)
    got = command.attained
    assert got["com_acceleration"].got == pytest.approx(data.acom[0], abs=1e-6)
    rotation = pinocchio.Quaternion(q[3:7]).toRotationMatrix()
    assert got["turn_acceleration"].got == pytest.approx(rotation @ command.accelerations[3:6], abs=1e-9)
    feet = centre_accelerations(robot, q, v, command.accelerations)
    assert got["feet"].got == pytest.approx(feet, abs=1e-6)
    for task, outcome in got.items():
        assert np.array_equal(outcome.wanted, getattr(tasks, task)), task
        assert outcome.wanted.shape == outcome.got.shape


def test_a_robot_that_stands_gets_what_it_wants_and_nothing_binds() -> None:
    for name in ("go2", "g1"):
        command = step(robot_of(name), standing(robot_of(name)))
        assert command.status is Status.SOLVED
        assert all(command.attained[task].met for task in ("com_acceleration", "turn_acceleration", "feet"))
        assert command.binding == ()


@pytest.mark.parametrize("wanted", [10 * GRAVITY, 1e6])
def test_too_much_upward_is_compromised_by_the_largest_normal_force(wanted: float) -> None:
    robot = robot_of("go2")
    tasks = standing(robot, com_acceleration=np.array([0.0, 0.0, wanted]))
    command = step(robot, tasks, normal_max=1.0 * robot.mass * GRAVITY, effort_limits=np.full(12, np.inf))
    assert command.feasible
    assert command.distribution is not Status.INVALID
    assert command.status is Status.COMPROMISED
    assert not command.attained["com_acceleration"].met
    assert {b.kind for b in command.binding} == {"normal_max"}
    assert [b.name for b in command.binding] == [f"{foot}:0" for foot in robot.foot_names]
    limited = step(robot, tasks)
    assert limited.status in (Status.COMPROMISED, Status.INFEASIBLE)
    assert any(b.kind == "torque" and b.name in robot.joint_names for b in limited.binding)


def test_more_sideways_than_friction_gives_is_compromised_by_it() -> None:
    robot = robot_of("go2")
    tasks = standing(robot, com_acceleration=np.array([0.0, 6.0, 0.0]))
    command = step(robot, tasks, ForceLimits(mu=0.2))
    assert command.status is Status.COMPROMISED
    kinds = {b.kind for b in command.binding}
    assert "friction" in kinds
    assert step(robot, tasks._replace(com_acceleration=np.array([0.0, 1.0, 0.0]))).status is Status.SOLVED


def test_no_contact_is_compromised_and_named() -> None:
    robot = robot_of("go2")
    command = step(robot, standing(robot, stance=np.zeros(4, dtype=bool)))
    assert command.status is Status.COMPROMISED
    assert command.binding[0] == BindingLimit("no_contact", "go2")
    assert command.attained["com_acceleration"].got == pytest.approx([0.0, 0.0, -GRAVITY])


def test_a_foot_in_the_air_that_its_motors_cannot_lift_is_compromised_by_torque() -> None:
    robot = robot_of("go2")
    feet, stance = np.zeros((4, 6)), np.array([False, True, True, True])
    feet[0, 2] = 500.0
    command = step(robot, standing(robot, stance=stance, feet=feet), effort_limits=np.full(12, 12.0))
    assert command.status is Status.COMPROMISED
    assert not command.attained["feet"].met
    assert {b.name[:2] for b in command.binding if b.kind == "torque"} >= {"FL"}


def test_a_kept_command_speaks_of_its_own_step_whatever_is_written_later() -> None:
    robot, q, v, tasks = random_case("go2", 11)
    controller = WholeBodyController(robot)
    first = controller.step(q, v, tasks)
    said = first.attained, first.binding, first.status
    again = pickle.loads(pickle.dumps(first._replace(notes=first.notes._replace(robot=None))))
    assert np.array_equal(again.notes.memory, first.notes.memory)
    tasks.com_acceleration[:] = 1e3
    tasks.forces[:] = 0.0
    controller.step(q, -v, tasks, ForceLimits(mu=0.01, most=np.full(4, 5.0)))
    assert str((first.attained, first.binding, first.status)) == str(said)


@pytest.mark.parametrize("quaternion", [(0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.1), (9.0, 0.0, 0.0, 0.0)])
def test_a_quaternion_that_is_none_is_invalid(quaternion: tuple[float, ...]) -> None:
    robot = robot_of("go2")
    q = robot.nominal.copy()
    q[3:7] = quaternion
    controller = WholeBodyController(robot)
    command = controller.step(q, np.zeros(18), standing(robot))
    assert command.status is Status.INVALID
    assert not command.feasible
    assert command.attained == {}
    assert command.binding == ()
    assert controller.step(robot.nominal, np.zeros(18), standing(robot)).status is Status.SOLVED
