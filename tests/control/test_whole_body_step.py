"""The compiled calls of a step of whole-body control, and the memory that they share, against plain NumPy."""

from __future__ import annotations

import copy
from functools import cache

import numpy as np
import pinocchio
import pytest

from surefoot.control import whole_body_step as parts
from surefoot.control.model_views import ModelViews
from surefoot.control.whole_body_step import force_problem, kinematics, part, reduce, step_memory, torques_of
from surefoot.robot import Robot, load_robot

WEIGHTS = np.array([1.0, 0.1, 2.0, 0.3, 30.0, 12.0, 20.0, 35.0])


@cache
def robot_of(name: str) -> Robot:
    return load_robot(name)


def views_at(robot: Robot, q: np.ndarray, v: np.ndarray) -> ModelViews:
    """Return views of data after all computations of a step."""
    views = ModelViews(robot.model, robot.model.createData())
    pinocchio.crba(robot.model, views.data, q)
    pinocchio.nonLinearEffects(robot.model, views.data, q, v)
    pinocchio.computeJointJacobiansTimeVariation(robot.model, views.data, q, v)
    pinocchio.centerOfMass(robot.model, views.data, q, v, False)
    pinocchio.updateFramePlacements(robot.model, views.data)
    return views


class Memory:
    """The numbers and the memory of a step, with views of the parts that the tests look at."""

    def __init__(self, robot: Robot) -> None:
        nv = robot.model.nv
        self.numbers, self.memory = step_memory(
            nv, robot.contact_points, WEIGHTS, np.full(robot.joints, 1e-3)
        )
        shapes = {
            "ROTATIONS": (-1, 3, 3), "TWISTS": (6, nv), "ROWS": (-1, nv), "E": (-1, nv), "WANTED": (-1,),
            "OFFSET": (nv,), "GAIN": (nv, 6), "TARGET": (6,), "MAP": (6, -1), "H": (nv, nv), "C": (nv,),
        }  # fmt: skip
        for name, shape in shapes.items():
            setattr(self, name.lower(), part(self.numbers, self.memory, getattr(parts, name), *shape))


def prepared(name: str, seed: int) -> tuple[Robot, Memory, ModelViews, np.ndarray, tuple[np.ndarray, ...]]:
    """Return a robot, its memory after `kinematics` at a random state, views, velocity, and the answer."""
    robot, rng = robot_of(name), np.random.default_rng(seed)
    q = pinocchio.integrate(robot.model, robot.nominal, 0.2 * rng.normal(size=robot.model.nv))
    v = rng.normal(size=robot.model.nv)
    views = views_at(robot, q, v)
    memory = Memory(robot)
    found = kinematics(
        memory.numbers, memory.memory, v, views.twists, views.twist_rates, views.rotation, views.com,
        views.com_velocity, views.frame_rotations, views.frame_places,
    )  # fmt: skip
    return robot, memory, views, v, found


@pytest.mark.parametrize("name", ["go2", "g1"])
def test_views_follow_the_data(name: str) -> None:
    robot, rng = robot_of(name), np.random.default_rng(1)
    views = ModelViews(robot.model, robot.model.createData())
    for _ in range(2):
        q = pinocchio.integrate(robot.model, robot.nominal, 0.3 * rng.normal(size=robot.model.nv))
        v, data = rng.normal(size=robot.model.nv), views.data
        pinocchio.computeAllTerms(robot.model, data, q, v)
        pinocchio.computeJointJacobiansTimeVariation(robot.model, data, q, v)
        pinocchio.crba(robot.model, data, q)
        pinocchio.updateFramePlacements(robot.model, data)
        assert np.array_equal(views.mass_matrix, np.array(data.M))
        assert np.array_equal(views.mass_matrix, views.mass_matrix.T)
        assert np.array_equal(views.bias, np.array(data.nle))
        assert np.array_equal(views.twists, np.array(data.J))
        assert np.array_equal(views.twist_rates, np.array(data.dJ))
        for k, pose in enumerate(data.oMf):
            assert np.array_equal(views.frame_rotations[k], pose.rotation)
            assert np.array_equal(views.frame_places[k], pose.translation)
        assert np.array_equal(views.rotation, data.oMi[1].rotation)
        assert np.array_equal(views.place, data.oMi[1].translation)
    own = copy.deepcopy(views)
    before = views.bias.copy()
    pinocchio.nonLinearEffects(robot.model, own.data, robot.nominal, np.zeros(robot.model.nv))
    assert np.array_equal(own.bias, np.array(own.data.nle))
    assert np.array_equal(views.bias, before)


@pytest.mark.parametrize("name", ["go2", "g1"])
def test_kinematics_are_those_of_pinocchio(name: str) -> None:
    robot, memory, views, v, found = prepared(name, 3)
    com, com_velocity, rotation, spin, centres, twists, _ = found
    data = views.data
    assert np.array_equal(com, np.array(data.com[0]))
    assert np.array_equal(com_velocity, np.array(data.vcom[0]))
    assert np.array_equal(rotation, np.array(data.oMi[1].rotation))
    np.testing.assert_allclose(spin, rotation @ v[3:6], atol=1e-13)
    assert np.array_equal(memory.twists, np.array(data.J))
    for k, foot in enumerate(robot.feet):
        pose = data.oMf[foot.frame]
        assert np.array_equal(memory.rotations[k], pose.rotation)
        np.testing.assert_allclose(centres[k], pose.act(foot.centre), atol=1e-12)
        twist = pinocchio.getFrameVelocity(robot.model, data, foot.frame, pinocchio.LOCAL_WORLD_ALIGNED)
        arm = pose.rotation @ foot.centre
        np.testing.assert_allclose(twists[k, 3:], twist.angular, atol=1e-10)
        np.testing.assert_allclose(twists[k, :3], twist.linear + np.cross(twist.angular, arm), atol=1e-10)


@pytest.mark.parametrize("name", ["go2", "g1"])
@pytest.mark.parametrize("seed", range(3))
def test_accelerations_obey_their_constraints_and_torques_the_dynamics(name: str, seed: int) -> None:
    robot, memory, views, _, _ = prepared(name, seed)
    rng, n, p = np.random.default_rng(seed), len(robot.feet), len(robot.contact_points.foot)
    stance = np.arange(n) != seed % n
    frames, outside = np.tile(np.eye(3), (n, 1, 1)), rng.normal(size=6)
    M, bias = views.mass_matrix, views.bias
    count, sound = force_problem(
        memory.numbers, memory.memory, M, bias, robot.mass, outside, stance, rng.normal(size=3),
        rng.normal(size=3), rng.normal(size=(n, 6)), rng.normal(size=robot.joints), frames, np.zeros(n),
    )  # fmt: skip
    assert sound
    assert count == 6 + int(np.where(robot.contact_points.flat, 6, 3)[stance].sum())
    f = robot.mass * rng.normal(size=(p, 3))
    w = memory.rows.T[:6] @ f.ravel()
    a = memory.offset + memory.gain @ w
    wanted = memory.wanted[:count] + np.r_[w, np.zeros(count - 6)]
    size = np.abs(wanted).max()
    np.testing.assert_allclose(memory.e[:count] @ a, wanted, atol=1e-7 * size)
    np.testing.assert_allclose(memory.wanted[:6], outside - bias[:6], atol=1e-12)

    # the cost of forces is that of the tasks, but for a constant
    def missed(force: np.ndarray) -> float:
        return 0.5 * float(np.sum((memory.map @ force.ravel() - memory.target) ** 2))

    tasks, costs = memory.h, memory.c

    def cost(force: np.ndarray) -> float:
        at = memory.offset + memory.gain @ (memory.rows.T[:6] @ force.ravel())
        return float(0.5 * at @ tasks @ at - costs @ at)

    g = robot.mass * rng.normal(size=(p, 3))
    np.testing.assert_allclose(missed(f) - missed(g), cost(f) - cost(g), rtol=1e-7, atol=1e-7)
    middle, half = 0.1 * rng.normal(size=robot.joints), np.full(robot.joints, 20.0)
    losses, loose = rng.normal(size=robot.joints), rng.random(robot.joints) < 0.5
    torques, found, command, exceeded = torques_of(
        memory.numbers, memory.memory, f, M, bias, middle, half, losses, loose
    )
    np.testing.assert_allclose(found, a, atol=1e-9 * np.abs(a).max())
    rest = M @ a + bias - memory.rows.T @ f.ravel()
    np.testing.assert_allclose(torques, rest[6:], atol=1e-9 * np.abs(rest).max())
    np.testing.assert_allclose(command, np.clip(torques, middle - half, middle + half) + losses, atol=1e-12)
    shares = np.abs(torques - middle) / half
    assert exceeded[0] == pytest.approx(np.max(shares, where=loose, initial=0.0))
    assert exceeded[1] == pytest.approx(np.max(shares, where=~loose, initial=0.0))
    memory.wanted[0] = np.nan
    assert not reduce(memory.numbers, memory.memory, count)
