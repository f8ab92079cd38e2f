"""The wrench observer: its kernels against Pinocchio and NumPy, its answers against loads that are known."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest

from surefoot.base.spatial import GRAVITY
from surefoot.mechanics.robot import Robot
from surefoot.mechanics.robot.payload import loaded_model
from surefoot.motion.estimation import wrench_kernels as kernels
from surefoot.motion.estimation.wrench_observer import (
    FURTHEST,
    LARGEST,
    LEAST,
    MOST,
    Instant,
    WrenchObserver,
)
from tests.robots import robot_of

DT = 1e-3
TROT = np.array([True, False, False, True])


class Motion:
    """A step under known forces at the feet: with a known wrench on the base, or with a payload and no other.

    `model` is what really moves, `robot` what an observer believes.
    """

    def __init__(
        self, robot: Robot, seed: int, touching: np.ndarray, model: pinocchio.Model | None = None
    ) -> None:
        random, nv = np.random.default_rng(seed), robot.model.nv
        true, data = model or robot.model, robot.model.createData()
        q = pinocchio.integrate(robot.model, robot.nominal, 0.1 * random.normal(size=nv))
        v, acceleration = 0.3 * random.normal(size=nv), random.normal(size=nv)
        pinocchio.computeJointJacobians(robot.model, data, q)
        pinocchio.updateFramePlacements(robot.model, data)
        rows, points = [], []
        for foot in robot.feet:
            pose = data.oMf[foot.frame]
            points.append(pose.act(foot.centre) - [0.0, 0.0, foot.radius])
            J = pinocchio.getFrameJacobian(robot.model, data, foot.frame, pinocchio.LOCAL_WORLD_ALIGNED)
            rows.append(J[:3] - pinocchio.skew(points[-1] - pose.translation) @ J[3:])
        total = pinocchio.rnea(true, true.createData(), q, v, acceleration)
        forces = 40.0 * random.normal(size=(4, 3)) * touching[:, None]
        if model is not None:  # the feet on the ground carry the base, and nothing else does
            forces = (np.linalg.pinv(np.vstack(rows)[:, :6].T) @ total[:6]).reshape(4, 3)
        rest = total - forces.ravel() @ np.vstack(rows)
        R = np.array(data.oMi[1].rotation)
        self.torques, self.wrench = rest[6:], np.r_[R @ rest[:3], R @ rest[3:6]]
        self.after, self.touching = v + DT * acceleration, touching
        pose = np.column_stack([R, data.oMi[1].translation])
        twists = np.ascontiguousarray(pinocchio.computeJointJacobians(robot.model, data, q))
        M = np.array(pinocchio.crba(robot.model, robot.model.createData(), q))
        bias = np.array(pinocchio.nonLinearEffects(robot.model, robot.model.createData(), q, v))
        self.instant = Instant(M, bias, v, twists, np.array(points), pose)


def seen(robot: Robot, motion: Motion) -> np.ndarray:
    wrench, points, now = np.zeros(6), robot.contact_points, motion.instant
    kernels.sum_wrench(
        now.M, now.bias, now.v, motion.after, DT, motion.torques, now.twists, points.foot_support, now.points,
        points.flat, motion.touching, now.pose, np.zeros(4), wrench,
    )  # fmt: skip
    return wrench


@pytest.mark.parametrize("name", ["go2", "anymal_c", "hyq"])
@pytest.mark.parametrize("touching", [TROT, np.ones(4, dtype=bool), np.zeros(4, dtype=bool)])
def test_a_known_wrench_is_what_the_equations_of_motion_leave(name: str, touching: np.ndarray) -> None:
    robot = robot_of(name)
    for seed in range(4):
        motion = Motion(robot, seed, touching)
        error = seen(robot, motion) - motion.wrench
        assert np.abs(error[:3]).max() < 0.005 * robot.mass * GRAVITY  # damping of the legs' short levers
        assert np.abs(error[3:]).max() < 0.005 * robot.mass * GRAVITY * robot.nominal[2]


def test_the_filters_step_is_kalmans() -> None:
    random = np.random.default_rng(4)
    rotation = np.array(pinocchio.Quaternion(random.normal(size=4)).normalized().matrix(), order="C")
    x, root, y = random.normal(size=10), random.normal(size=(10, 10)), random.normal(size=6)
    P, noise = root @ root.T, random.uniform(0.1, 1.0, 6)
    keep, drive = random.uniform(0.5, 1.0, 10), random.uniform(0.0, 0.5, 10)
    down = np.array([0.0, 0.0, -1.0])
    H = np.zeros((6, 10))
    H[:3, 0], H[:, 4:] = down, np.eye(6)
    H[3:, 1:4] = np.column_stack([np.cross(rotation[:, j], down) for j in range(3)])
    before = np.diag(keep) @ P @ np.diag(keep) + np.diag(drive)
    gain = before @ H.T @ np.linalg.inv(H @ before @ H.T + np.diag(noise))
    state = keep * x + gain @ (y - H @ (keep * x))
    covariance = (np.eye(10) - gain @ H) @ before
    x, P = kernels.filter_wrench(x, P, y, rotation, noise, keep, drive)
    assert np.allclose(x, state, rtol=1e-9, atol=1e-12)
    assert np.allclose(P, covariance, rtol=1e-9, atol=1e-9)


def observed(
    mass: float, place: list[float], carried: np.ndarray | None = None, steps: int = 3000
) -> WrenchObserver:
    """Return an observer that has seen random instants of a robot with a payload."""
    robot = robot_of("go2")
    model = loaded_model(robot.model, mass, place)
    observer = WrenchObserver(robot, DT)
    motions = [Motion(robot, seed, np.ones(4, dtype=bool), model) for seed in range(30)]
    for k in range(steps):
        one = motions[k // 10 % len(motions)]  # a block of steps each
        # the load's own inertial forces are left in: they are noise to an observer that was not told of it
        observer.observe(one.instant, one.after, one.torques, one.touching, carried)
    return observer


def test_a_payload_is_found_with_its_place() -> None:
    load = observed(5.0, [0.1, 0.08, 0.05]).load
    assert load.mass == pytest.approx(5.0, rel=0.05)
    assert load.place[:2] == pytest.approx([0.1, 0.08], abs=0.012)


def test_a_load_that_the_model_carries_is_part_of_the_estimate() -> None:
    """The model of `Motion` has no load, so that being told of one adds its weight."""
    plain, told = (observed(2.0, [0.1, 0.0, 0.0], load) for load in (None, np.array([3.0, 0.0, 0.3, 0.0])))
    assert told.load.mass - plain.load.mass == pytest.approx(3.0, rel=0.02)
    assert (told.load.moment - plain.load.moment)[:2] == pytest.approx([0.0, 0.3], abs=0.015)


def standing(robot: Robot) -> Motion:
    """Return a motion without any: on four feet, nothing moves, and motors hold what they must."""
    motion = Motion(robot, 0, np.ones(4, dtype=bool))
    data = robot.model.createData()
    M = np.array(pinocchio.crba(robot.model, data, robot.nominal))
    bias = np.array(pinocchio.computeGeneralizedGravity(robot.model, data, robot.nominal))
    pinocchio.computeJointJacobians(robot.model, data, robot.nominal)
    points = robot.foot_positions(robot.nominal) - [[0.0, 0.0, foot.radius] for foot in robot.feet]
    pose = np.column_stack([np.eye(3), robot.nominal[:3]])
    still = np.zeros(robot.model.nv)
    motion.instant = Instant(M, bias, still, np.ascontiguousarray(data.J), points, pose)
    motion.after = still
    share = np.tile([0.0, 0.0, robot.mass * GRAVITY / 4], (4, 1))
    # forces that do not balance the moment of the weight are the load's: four equal ones
    jacobian = robot.contact_points.foot_support[:, None, :] * np.stack(
        [data.J[:3] + np.cross(data.J[3:], p, axis=0) for p in points]
    )
    motion.torques = (bias - np.einsum("kc,kcj->j", share, jacobian))[6:]
    return motion


@pytest.mark.parametrize(("axis", "size"), [(0, 60.0), (1, -60.0), (2, 60.0)])
def test_a_push_is_no_payload_and_a_pull_that_lasts_sideways_neither(axis: int, size: float) -> None:
    robot = robot_of("go2")
    still, observer = standing(robot), WrenchObserver(robot, DT)
    pushed = still.instant.v.copy()
    pushed[axis] = DT * size / robot.mass  # a change of velocity that no force of the feet explains
    masses = []
    for k in range(4000):
        after = pushed if 3000 <= k < 3100 else still.after
        observer.observe(still.instant, after, still.torques, still.touching)
        masses.append(observer.load.mass)
        if k == 3099:
            found = observer.wrench[:3] - [0.0, 0.0, observer.load.mass * GRAVITY]
    assert found[axis] == pytest.approx(size, rel=0.3)
    # of a push downwards some is taken for weight, for a while
    assert np.ptp(masses[2000:]) < (0.1 if axis == 2 else 0.02) * robot.mass
    for _ in range(3000):
        observer.observe(still.instant, pushed, still.torques, still.touching)
    if axis < 2:
        assert observer.wrench[axis] == pytest.approx(size, rel=0.25)
        assert abs(observer.load.mass) < 0.02 * robot.mass
    else:  # what always lifts is negative weight
        assert observer.load.mass == pytest.approx(-size / GRAVITY, rel=0.3)


def test_everything_is_bounded_and_what_is_not_finite_is_left_out() -> None:
    robot = robot_of("go2")
    still, observer = standing(robot), WrenchObserver(robot, DT)
    for size in (1e6, -1e6):
        violent = still.after + size * np.r_[np.ones(6), np.zeros(12)]
        for _ in range(500):
            observer.observe(still.instant, violent, still.torques, still.touching)
        assert LEAST <= observer.state[0] <= MOST
        assert np.abs(observer.wrench[:3]).max() <= LARGEST * robot.mass * GRAVITY * (1.0 + 1e-12)
        assert np.abs(observer.load.place).max() <= FURTHEST * observer.height * (1.0 + 1e-12)
    before = observer.state.copy()
    for _ in range(50):
        observer.observe(still.instant, np.full(18, np.nan), still.torques, still.touching)
    assert np.array_equal(observer.state, before)
    for _ in range(12000):
        observer.observe(still.instant, still.after, still.torques, still.touching)
    assert abs(observer.load.mass) < 0.05 * robot.mass  # the bounds have kept nothing back
    observer.reset()
    assert not observer.state.any()
