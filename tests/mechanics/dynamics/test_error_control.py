"""Steps to a stated error: closed forms are reached, events included, and the estimate does not lie."""

from __future__ import annotations

import numpy as np
import pytest

import surefoot as sf
from benchmarks.work_precision import PERIOD, motions
from surefoot.base.errors import SimulationError
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics.collision import Box
from surefoot.mechanics.terrain import Terrain
from surefoot.worlds.rigid.bodies import ball, box
from tests.moving import advance, lifted

MOTIONS = {motion.name: motion for motion in motions()}


@pytest.mark.parametrize("tol", [1e-2, 1e-4])
@pytest.mark.parametrize("name", MOTIONS)
def test_the_stated_error_is_reached(name: str, tol: float) -> None:
    error, steps, _ = MOTIONS[name].run(PERIOD, tol)
    assert error <= tol
    assert steps <= 1500


def test_a_stop_is_found_at_little_cost() -> None:
    """Where a box comes to rest, within 1e-8 m: fixed steps of a tenth of a millisecond need 8000."""
    error, steps, _ = MOTIONS["slide"].run(PERIOD, 1e-6)
    assert error < 1e-8
    assert steps < 300
    assert MOTIONS["slide"].run(1e-3, None)[0] > 1e-7


@pytest.mark.long
def test_an_impact_while_another_contact_presses_is_met_in_time() -> None:
    """A box tips from an edge onto its face: when it lies flat is found by halving, not by the grid."""
    body = box(2.0, (0.2, 0.2, 0.2))
    start = body.nominal.copy()
    tilt = 0.02
    start[2] = 0.1 * (np.sin(tilt) + np.cos(tilt))
    start[3:7] = (0.0, np.sin(0.5 * tilt), 0.0, np.cos(0.5 * tilt))
    ends = []
    for dt, tol in ((0.01, 1e-5), (1e-5, None)):
        world = sf.RigidWorld(body, mu=2.0, dt=dt, tol=tol)
        world.reset(start)
        advance(world, round(0.09 / dt), np.zeros(0))
        ends.append(np.r_[world.q_v()[0][:3], world.q_v()[1]])
    assert ends[0] == pytest.approx(ends[1], abs=2e-4)
    assert abs(ends[0][2] - 0.1) < 1e-6  # it lies


def test_a_step_is_one_step_to_whoever_looks() -> None:
    world = sf.RigidWorld(ball(2.0, 0.1), dt=0.02, tol=1e-4)
    q = lifted(world.robot.nominal, 0.02)
    world.reset(q)
    pushes = []
    for _ in range(10):
        world.step(np.zeros(0))
        pushes.append(world.contacts().forces[0, 2] * world.dt)
    assert world.time == pytest.approx(0.2)
    assert sum(pushes) == pytest.approx(2.0 * GRAVITY * 0.2, rel=1e-9)  # all momentum is the ground's
    assert world.contact_work() <= 1e-12
    assert [touch.body for touch in world.touches()] == ["ball"]
    assert world.control.error <= 1e-4
    world.reset(q)
    assert world.control.taken == 0


def test_a_lost_step_spends_nothing_of_the_error_and_may_be_tried_again() -> None:
    """The ground ends 5 cm ahead of a ball that is pushed back, at the first attempt or the second."""

    class Hole(Terrain):
        def height(self, xy: np.ndarray) -> np.ndarray:
            return np.where(np.asarray(xy)[..., 0] < 0.3, 0.0, np.nan)

    worlds = [sf.RigidWorld(ball(1.0, 0.1), Hole(), dt=0.03, tol=1e-4) for _ in range(2)]
    for world in worlds:
        world.reset(lifted(world.robot.nominal, 0.01), np.array([5.0, 0.0, 0.0, 0.0, 0.0, 0.0]))
        world.step(np.zeros(0))
        world.step(np.zeros(0), np.array([-100.0, 0.0, 0.0]))
    with pytest.raises(SimulationError, match="gap between feet and ground"):
        worlds[0].step(np.zeros(0), np.array([200.0, 0.0, 0.0]))
    with pytest.raises(sf.ProblemError, match="torques must have shape"):
        worlds[0].step(np.zeros(3))
    assert worlds[0].stepper.options.dt == 0.03
    for world in worlds:
        world.step(np.zeros(0), np.array([-200.0, 0.0, 0.0]))
    one, other = ((*world.q_v(), world.control.error, world.control.taken) for world in worlds)
    assert all(np.array_equal(a, b) for a, b in zip(one, other, strict=True))


def test_scenes_take_a_stated_error_too() -> None:
    cube = Box((0.2, 0.2, 0.2))
    bodies = [sf.Body("low", cube, 2.0, (0, 0, 0.1)), sf.Body("high", cube, 1.0, (0, 0, 0.35))]
    world = sf.SceneWorld(sf.Scene(bodies), dt=0.02, tol=1e-4)
    advance(world, 15)
    assert world.pose("high").position[2] == pytest.approx(0.3, abs=1e-4)


@pytest.mark.parametrize("tol", [0.0, -1.0, np.nan, 1e-9, "small"])
def test_what_is_no_tolerance_is_refused(tol) -> None:
    with pytest.raises(sf.ProblemError, match="tol must be"):
        sf.RigidWorld(ball(), tol=tol)


def test_a_divided_step_has_no_derivative() -> None:
    world = sf.RigidWorld(ball(), tol=1e-3)
    world.step(np.zeros(0))
    with pytest.raises(sf.ProblemError, match="not with a tol"):
        world.derivative()

    def rollout(height: float) -> None:
        inner = sf.RigidWorld(ball(), tol=1e-3)
        inner.reset([0, 0, height, 0, 0, 0, 1])
        inner.step(np.zeros(0))

    with pytest.raises(sf.ProblemError, match="not with a tol"):
        sf.trajectory_gradient(rollout, lambda q, v: q[-1, 2], wrt=["height"])(height=0.5)
