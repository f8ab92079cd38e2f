"""The knot of plans keeps momentum to rounding, by Pinocchio's account, and its derivative is its own."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest

from surefoot.base.spatial import GRAVITY
from surefoot.mechanics.dynamics import Knot, MomentumKnot, StepOptions, Stepper
from surefoot.mechanics.dynamics.momentum_knot import velocity_of_way
from surefoot.mechanics.robot import load_robot, place
from surefoot.mechanics.robot.centroidal import free_momentum_rows
from surefoot.mechanics.terrain import SlopeTerrain
from surefoot.motion.planning.transcription import planar

ROBOTS = {
    "go2": (lambda: load_robot("go2"), (0, 1, 2, 3, 4, 5)),
    "planar hopper": (planar.planar_hopper, (0, 2, 4)),
    "sliding hopper": (planar.sliding_hopper, (0, 2)),
    "ball": (lambda: planar.point("ball", 0.1), (0, 2)),
    "block and foot": (planar.block_and_foot, ()),
}


def knot_of(robot, dt=0.005, kind=MomentumKnot, terrain=None):
    return kind(Stepper(robot, terrain, StepOptions(dt=dt, order=1, solver_tol=1e-12)))


def thrown(name, height, seed=1):
    """Return a robot `height` [m] above where it stands, its state and its motors' efforts."""
    rng, robot = np.random.default_rng(seed), ROBOTS[name][0]()
    q = np.array(place(robot) if robot.floating else robot.nominal)
    q[2 if robot.floating else 1] += height
    effort = np.where(planar.passive_joints(robot), 0.0, np.minimum(robot.effort_limits, 1e3))
    v = rng.normal(size=robot.model.nv)
    v[2 if robot.floating else 1] -= 1.0
    return robot, q, v, effort, rng


def flown(knot, thrown_robot, rows, steps=30):
    """Return the worst error of momentum over its size, and of the centre of mass's way [m]; and impulses."""
    robot, q, v, effort, rng = thrown_robot
    model, data, joints = robot.model, robot.model.createData(), robot.joints
    dt, worst, off, pressed = knot.stepper.options.dt, 0.0, 0.0, 0.0
    way, rows = velocity_of_way(model, q, v, dt), list(rows)
    for _ in range(steps):
        pull = (
            0.6 * (robot.nominal[-joints:] + 0.2 * rng.normal(size=joints) - q[-joints:])
            - 5e-3 * way[-joints:]
        )
        before = pinocchio.computeCentroidalMomentum(model, data, q, v).vector.copy()
        com = pinocchio.centerOfMass(model, data, q).copy()
        places = knot.stepper.contacts(knot.stepper.start(q))
        step = knot.step(q, way, effort * np.clip(pull, -1.0, 1.0))
        assert step.solved
        pushes = np.einsum("pij,pj->pi", places.frames, step.impulses)
        wrench = np.concatenate([pushes.sum(axis=0), np.cross(places.positions - com, pushes).sum(axis=0)])
        wrench[2] -= robot.mass * GRAVITY * dt
        q, way, v = step.q, step.v, knot.velocity_at_end(step)
        after = pinocchio.computeCentroidalMomentum(model, data, q, v).vector.copy()
        worst = max(worst, np.abs((after - before - wrench)[rows]).max() / np.abs(after).max())
        ahead = pinocchio.centerOfMass(model, data, q) - com - dt / robot.mass * after[:3]
        off = max(off, np.abs(ahead[[row for row in rows if row < 3]]).max())
        pressed = max(pressed, step.impulses[:, 2].max())
    return worst, off, pressed


@pytest.mark.parametrize("name", list(ROBOTS)[:-1])
@pytest.mark.parametrize("height", [3.0, 0.02])
def test_momentum_changes_by_gravity_and_impulses_alone(name, height) -> None:
    """Linear and angular, in the air and over landings; the centre of mass goes where momentum takes it."""
    given = thrown(name, height)
    rows = free_momentum_rows(given[0].model)
    assert rows == ROBOTS[name][1]
    worst, off, pressed = flown(knot_of(given[0]), given, rows)
    assert worst < 1e-13
    assert off < 1e-14
    assert (pressed > 0.0) == (height < 1.0)


def test_the_plain_step_loses_momentum_where_this_one_does_not() -> None:
    given = thrown("planar hopper", 0.02)
    worst, _, _ = flown(knot_of(given[0], kind=PlainKnot), given, (0, 2, 4))
    assert worst > 1e-3


class PlainKnot(Knot):
    """The plain step, whose velocity is the knot's."""

    def velocity_at_end(self, step):
        return step.v


@pytest.mark.parametrize("name", list(ROBOTS))
@pytest.mark.parametrize("angle", [0.0, 10.0])
def test_the_derivative_is_that_of_the_step(name, angle) -> None:
    robot, q, v, _, _ = thrown(name, 0.003)
    model, nv = robot.model, int(robot.model.nv)
    knot = knot_of(robot, 0.02, terrain=SlopeTerrain(angle) if angle else None)

    def after(change):
        at = pinocchio.integrate(model, q, change[:nv])
        step = knot.step(at, v + change[nv : 2 * nv], change[2 * nv :])
        assert step.solved
        return step.q, step.v

    size = 2 * nv + robot.joints
    A, B, _ = knot.derivative(knot.step(q, v, np.zeros(robot.joints)))
    for k, step in enumerate(np.eye(size)):
        eps = 1e-6 if k < 2 * nv else 1e-4
        (q0, v0), (q1, v1) = after(-eps * step), after(eps * step)
        slope = np.concatenate([pinocchio.difference(model, q0, q1), v1 - v0]) / (2.0 * eps)
        block, at = (A, k) if k < 2 * nv else (B, k - 2 * nv)
        assert np.abs(slope - block[:, at]).max() < 1e-7 * max(1.0, np.abs(block).max())


def test_where_nothing_is_carried_the_step_is_plain() -> None:
    robot, q, v, _, _ = thrown("block and foot", 0.003)
    steps = [knot_of(robot, kind=kind).step(q, v, np.zeros(4)) for kind in (Knot, MomentumKnot)]
    assert all(step.solved for step in steps)
    assert np.array_equal(steps[0].q, steps[1].q)
    assert np.array_equal(velocity_of_way(robot.model, q, v, 0.01), v)
