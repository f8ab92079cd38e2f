"""Actuators: figures, friction, bounds, and whole-body control that commands them."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest

import surefoot as sf
from surefoot.base.errors import ProblemError
from surefoot.mechanics.robot.actuators import Actuators, actuators_of, real_actuators
from surefoot.mechanics.robot.motor_limits import MotorLimits, motor_limits
from surefoot.motion.control.whole_body import Tasks, WholeBodyController

GO2 = sf.load_robot("go2")
REAL = real_actuators(GO2)


def own(robot: sf.Robot = GO2, **figures: np.ndarray) -> Actuators:
    nothing = dict.fromkeys(("armature", "damping", "friction"), np.zeros(robot.joints))
    return Actuators(**(nothing | figures), limits=motor_limits(robot, "curve"))


def test_figures_come_from_the_file_the_table_or_the_rule() -> None:
    go1 = real_actuators(sf.load_robot("go1"))  # damping and friction of its URDF, the rotor of the table
    np.testing.assert_array_equal(go1.damping, np.full(12, 0.01))
    np.testing.assert_array_equal(go1.friction, np.full(12, 0.2))
    np.testing.assert_array_equal(go1.armature, np.full(12, 0.01))
    g1 = sf.load_robot("g1")
    by_name = dict(zip(g1.joint_names, real_actuators(g1).armature, strict=True))
    assert by_name["left_knee_joint"] == by_name["right_hip_roll_joint"] == 0.025101925
    assert by_name["left_hip_yaw_joint"] == 0.01017752
    b1 = sf.load_robot("b1")  # in no table: the Go2's, in proportion to the torque
    np.testing.assert_allclose(real_actuators(b1).armature, 0.01 / 23.7 * b1.effort_limits)
    assert actuators_of(GO2, "ideal") is None


def test_friction_opposes_the_motion() -> None:
    for speed in (-8.0, -0.5, 0.5, 8.0):
        lost = REAL.losses(np.full(12, speed))
        np.testing.assert_allclose(lost, 0.1 * speed + 0.2 * np.sign(speed), rtol=1e-3)
    np.testing.assert_array_equal(REAL.losses(np.zeros(12)), np.zeros(12))


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: own(damping=np.full(12, -1.0)), "damping"),
        (lambda: own(armature=np.zeros(11)), "armature"),
        (lambda: own(friction=np.full(12, np.inf)), "friction"),
        (lambda: actuators_of(GO2, "magic"), "valid names: ideal, real"),
        (lambda: actuators_of(sf.load_robot("panda"), REAL), "12"),
    ],
)
def test_what_is_no_actuator_is_refused(make, said: str) -> None:
    with pytest.raises(ProblemError, match=said):
        make()


def test_a_range_is_what_motors_leave_for_the_legs() -> None:
    """Whatever is commanded lies between the motors' bounds; inside, legs get what they ask for."""
    rng = np.random.default_rng(6)
    for speed in rng.normal(size=(20, 12)) * 10.0:
        REAL.usable(speed, GO2.effort_limits, out := np.empty((3, 12)))
        middle, half, losses = out
        low, high = REAL.bounds(speed)
        for wanted in rng.normal(size=(5, 12)) * 40.0:
            command = np.clip(wanted, middle - half, middle + half) + losses  # as the whole body does
            slack = 0.02 * GO2.effort_limits  # of motors near their no-load speed
            assert (command >= low - slack - 1e-9).all()
            assert (command <= high + slack + 1e-9).all()
            inside = np.abs(wanted - middle) <= half
            left = command - REAL.losses(speed)
            np.testing.assert_allclose(left[inside], wanted[inside], atol=1e-9)
            bound = middle + np.copysign(half, wanted - middle)
            np.testing.assert_allclose(left[~inside], bound[~inside], atol=1e-9)


def tasks(push: float, swing: float = 0.0) -> Tasks:
    """Four feet on the ground, or three and one that is swung; the body is to rise."""
    stance = np.array([True, True, True, swing == 0.0])
    feet = np.zeros((4, 6))
    feet[3, :3] = swing * np.array([1.0, 0.0, 1.0])
    return Tasks(
        stance, np.array([0.0, 0.0, push]), np.zeros(3), feet, np.zeros(12), np.zeros((4, 3)),
        np.tile(np.eye(3), (4, 1, 1)), np.zeros(4),
    )  # fmt: skip


@pytest.mark.parametrize(("push", "swing"), [(0.0, 0.0), (2.0, 0.0), (0.0, 30.0), (60.0, 0.0), (0.0, 2000.0)])
def test_whole_body_control_knows_rotors_friction_and_curve(push: float, swing: float) -> None:
    """The motors' torques, less friction, are those of the equations of motion with rotors; all are given."""
    controller = WholeBodyController(GO2, actuators=REAL)
    rng = np.random.default_rng(7)
    v = np.concatenate([np.zeros(6), rng.normal(size=12) * 6.0])
    command = controller.step(GO2.nominal, v, tasks(push, swing))
    low, high = REAL.bounds(v[6:])
    assert (command.torques >= low - 1e-6).all()
    assert (command.torques <= high + 1e-6).all()
    if not command.feasible:
        assert push > 50.0 or swing > 1000.0
        return
    M, bias, *_ = controller.instant()
    M = np.triu(M) + np.triu(M, 1).T
    bare = np.triu(pinocchio.crba(GO2.model, GO2.data, GO2.nominal))
    np.testing.assert_allclose(np.diag(M)[6:] - np.diag(bare)[6:], REAL.armature)
    ground = np.zeros(18)
    pinocchio.computeJointJacobians(GO2.model, GO2.data, GO2.nominal)
    for k, foot in enumerate(GO2.feet):
        pose = pinocchio.updateFramePlacement(GO2.model, GO2.data, foot.frame)
        J = pinocchio.getFrameJacobian(GO2.model, GO2.data, foot.frame, pinocchio.LOCAL_WORLD_ALIGNED)
        arm = pose.act(foot.centre) - [0.0, 0.0, foot.radius] - pose.translation
        ground += (J[:3] - pinocchio.skew(arm) @ J[3:]).T @ command.forces[k]
    moved = M @ command.accelerations + bias - ground
    np.testing.assert_allclose(moved[:6], 0.0, atol=1e-5)
    slack = 2e-6 * GO2.effort_limits.max()  # pinned torques meet their limits to a millionth of them
    np.testing.assert_allclose(command.torques - REAL.losses(v[6:]), moved[6:], atol=slack)


@pytest.mark.parametrize(
    ("left", "speed", "most", "way"),
    [(0.8, 15.0, 140.0, (300.0, 0.0, -300.0)), (0.03, 3.0, -150.0, (-100.0, 0.0, -100.0))],
)
def test_a_knee_in_the_air_passes_neither_its_speed_limit_nor_its_stop(left, speed, most, way) -> None:
    """So near to its stop [rad] and as fast [rad/s], whatever is wanted of the foot [m/s²].

    It takes up the 0.7 rad/s that are left in 5 ms, or slows by at least v² / 2 over the way that is left.
    """
    q, v = GO2.nominal.copy(), np.zeros(18)
    q[18], v[17] = GO2.model.upperPositionLimit[18] - left, speed
    swung = tasks(0.0, 1.0)._replace(feet=np.outer([0.0, 0.0, 0.0, 1.0], [*way, 0.0, 0.0, 0.0]))
    command = WholeBodyController(GO2, actuators=REAL).step(q, v, swung)
    assert command.feasible
    assert command.accelerations[17] <= most + 1e-3


def test_own_figures_change_the_command() -> None:
    heavy = own(armature=np.full(12, 0.2))
    light, loaded = (WholeBodyController(GO2, actuators=a) for a in (own(), heavy))
    swung = tasks(0.0, 20.0)
    a, b = (c.step(GO2.nominal, np.zeros(18), swung) for c in (light, loaded))
    assert np.abs(a.torques[9:] - b.torques[9:]).max() > 1.0
    endless = Actuators(
        np.zeros(12), np.ones(12), np.ones(12), MotorLimits(np.full(12, np.inf), np.full(12, np.inf))
    )
    free = WholeBodyController(GO2, actuators=endless).step(GO2.nominal, np.zeros(18), swung)
    assert np.isfinite(free.torques).all()
