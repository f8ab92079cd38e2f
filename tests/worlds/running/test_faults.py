"""Faults between robot and controller: what they do, and that they are seeded and told when wrong."""

import numpy as np
import pinocchio
import pytest

from surefoot.base.errors import ProblemError
from surefoot.contact.solution import Status
from surefoot.mechanics.robot import load_robot, place
from surefoot.motion.control.controller import Command, JointTargets, RobotState
from surefoot.worlds.mujoco.mujoco_world import MujocoWorld
from surefoot.worlds.running.faults import Faults, scaled_robot


@pytest.fixture(scope="module")
def world() -> MujocoWorld:
    return MujocoWorld(load_robot("go2"))


def asked(torques: np.ndarray, targets: JointTargets | None = None) -> Command:
    """Return a command for torques alone, or with targets."""
    nothing = np.zeros((4, 3)), np.ones(4, dtype=bool)
    return Command(torques, *nothing, True, Status.SOLVED, joint_targets=targets)


def test_no_fault_changes_nothing(world: MujocoWorld) -> None:
    q, v = world.q_v()
    active = Faults().start(world, 1)
    assert active.sense(q, v) == (q, v)
    torques = np.arange(12.0)
    assert (active.act(asked(torques), q, v) == torques).all()


def test_noise_is_seeded_and_of_the_stated_size(world: MujocoWorld) -> None:
    q, v = place(world.robot), np.zeros(18)
    samples = [Faults(noise=2.0).start(world, seed).sense(q, v) for seed in range(400)]
    again = Faults(noise=2.0).start(world, 3).sense(q, v)
    assert (samples[3][0] == again[0]).all()
    joints = np.array([s[0][7:] - q[7:] for s in samples])
    speeds = np.array([s[1][6:] for s in samples])
    assert joints.std() == pytest.approx(0.02, rel=0.05)
    assert speeds.std() == pytest.approx(0.4, rel=0.05)
    assert np.linalg.norm([s[0][3:7] for s in samples], axis=1) == pytest.approx(np.ones(400))


def test_torques_come_late(world: MujocoWorld) -> None:
    active = Faults(delay=0.003).start(world, None)
    given = [active.act(asked(np.full(12, float(k))), *world.q_v())[0] for k in range(8)]
    assert given == [0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 4.0]


def test_one_motor_is_weak(world: MujocoWorld) -> None:
    active = Faults(weak_joint="FR_calf_joint", torque_loss=0.3).start(world, None)
    assert active.act(asked(np.ones(12)), *world.q_v()).tolist() == [1.0] * 5 + [0.7] + [1.0] * 6


def test_late_targets_are_followed_from_the_joints_as_they_are(world: MujocoWorld) -> None:
    active = Faults(delay=0.002).start(world, None)
    q, v, one = np.zeros(19), np.zeros(18), np.ones(12)
    given = []
    for k in range(5):
        q[7:], v[6:] = 0.1 * k, 1.0 * k
        given.append(
            active.act(asked(one, JointTargets(k * one, k * one, 2.0 * one, one, 0.5 * one)), q, v)[0]
        )
    late = [0, 0, 0, 1, 2]
    assert given == pytest.approx([0.5 + 2.0 * (a - 0.1 * k) + a - k for k, a in enumerate(late)])
    strong = asked(one, JointTargets(one, one, 1e9 * one, one, one))
    assert (
        np.abs(Faults().start(world, None).act(strong, q, v)).tolist() == world.robot.effort_limits.tolist()
    )


def test_in_a_dropout_the_last_state_is_told_again(world: MujocoWorld) -> None:
    active = Faults(dropouts=((0.002, 0.003),)).start(world, None)
    states = [RobotState(np.zeros(19), np.zeros(18), 1e-3 * k) for k in range(8)]
    heard = [active.heard(state).time for state in states]
    assert heard == [0.0, 1e-3, 1e-3, 1e-3, 1e-3, 5e-3, 6e-3, 7e-3]


@pytest.mark.parametrize(
    ("faults", "message"),
    [
        (Faults(weak_joint="knee", torque_loss=0.1), "unknown joint 'knee'; valid names: FL_calf_joint"),
        (Faults(noise=-1.0), "noise must be"),
        (Faults(weak_joint="FL_calf_joint", torque_loss=1.5), "torque loss must be"),
        (Faults(delay=-0.1), "delay must be"),
        (Faults(dropouts=((1.0, -0.1),)), "duration of a dropout must be"),
    ],
)
def test_wrong_faults_are_told(world: MujocoWorld, faults: Faults, message: str) -> None:
    with pytest.raises(ProblemError, match=message):
        faults.start(world, None)


def test_a_scaled_robot_is_heavier_and_the_true_one_is_left_alone() -> None:
    robot = load_robot("go2")
    mass = robot.mass
    heavy = scaled_robot(robot, 1.25)
    assert heavy.mass == pytest.approx(1.25 * mass)
    assert pinocchio.computeTotalMass(robot.model) == pytest.approx(mass)
    M, scaled = (pinocchio.crba(r.model, r.model.createData(), r.nominal) for r in (robot, heavy))
    assert scaled == pytest.approx(1.25 * M)
    assert heavy.nominal == pytest.approx(robot.nominal)
