"""A batch of robots is as many worlds: bit for bit, whatever the number of workers."""

from __future__ import annotations

import numpy as np
import pytest

import surefoot as sf
from surefoot.simulation.batch import RigidBatch
from surefoot.simulation.rigid import RigidWorld
from surefoot.stepping import StepOptions

COUNT = 5


def starts() -> tuple[sf.Robot, np.ndarray, np.ndarray, np.ndarray]:
    robot, rng = sf.load_robot("go2"), np.random.default_rng(0)
    q = np.tile(sf.place(robot), (COUNT, 1))
    q[:, 2] += rng.uniform(0.0, 0.03, COUNT)
    return robot, q, 0.3 * rng.normal(size=(COUNT, 18)), 3.0 * rng.normal(size=(COUNT, 12))


@pytest.mark.parametrize("workers", [1, 2, 5])
def test_every_robot_moves_as_in_a_world_of_its_own(workers: int) -> None:
    robot, q, v, torques = starts()
    mu, payload = np.linspace(0.1, 0.9, COUNT), np.array([0.0, 1.0, 0.0, 2.0, 1.0])
    slope, push = sf.SlopeTerrain(5.0), np.random.default_rng(1).normal(size=(COUNT, 3))
    with RigidBatch(robot, slope, COUNT, mu, payload, StepOptions(dt=2e-3), workers) as batch:
        batch.reset(q, v)
        for _ in range(20):
            out = batch.step(torques, push)
        again = batch.step(torques, repeat=10)
        assert np.array_equal(batch.state()[1], again.v)
    for k in range(COUNT):
        world = RigidWorld(robot, slope, mu[k], 2e-3, payload[k])
        world.reset(q[k], v[k])
        for step in range(30):
            world.step(torques[k], push[k] if step < 20 else None)
            if step == 19:
                assert np.array_equal(out.q[k], world.state()[0])
                assert np.array_equal(out.forces[k], world.contacts().forces)
                assert np.array_equal(out.gaps[k], world.contacts().gaps)
        assert np.array_equal(again.q[k], world.state()[0])
        assert np.array_equal(again.v[k], world.state()[1])
    assert not again.lost.any()
    assert (again.unsolved == 0).all()


@pytest.mark.parametrize("workers", [1, 2])
def test_a_lost_robot_stays_and_leaves_the_others_alone(workers: int) -> None:
    robot, q, v, torques = starts()
    with RigidBatch(robot, count=COUNT, workers=workers) as batch:
        batch.reset(q, v)
        wanted = batch.step(torques)
        wild = v.copy()
        wild[3] = 1e7
        batch.reset(q, wild)
        for _ in range(2):
            out = batch.step(torques)
        assert out.lost.tolist() == [False, False, False, True, False]
        assert np.array_equal(out.v[3], wild[3])
        batch.reset(q, v, np.arange(COUNT) == 3)
        assert np.array_equal(batch.step(torques).q[3], wanted.q[3])


def test_friction_changes_and_wrong_arguments_are_named() -> None:
    robot, q, v, torques = starts()
    batch = RigidBatch(robot, count=COUNT)
    batch.reset(q[0])
    batch.set_friction(0.1)
    assert np.array_equal(batch.state()[0][4], q[0])
    for name, call in (
        ("torques", lambda: batch.step(torques[:2])),
        ("torques", lambda: batch.step(np.full((COUNT, 12), np.nan))),
        ("push", lambda: batch.step(torques, v)),
        ("q", lambda: batch.reset(q[:2])),
        ("which", lambda: batch.reset(q, which=[1])),
        ("mu", lambda: batch.set_friction(-1.0)),
        ("payload", lambda: RigidBatch(robot, count=2, payload=[1.0])),
        ("count", lambda: RigidBatch(robot, count=0)),
        ("workers", lambda: RigidBatch(robot, count=2, workers=0)),
    ):
        with pytest.raises(sf.ProblemError, match=name):
            call()
