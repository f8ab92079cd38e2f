"""Attempts to make the rigid world make energy, go through the ground, or hand on a state that is none.

Judged by Pinocchio's energy of the reported states alone: nothing of a step's own arithmetic is used. Motors'
work is torque times what the joints turned.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pinocchio
import pytest

import surefoot as sf
from surefoot.base.errors import SimulationError
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics.terrain import rough_ground
from surefoot.worlds.rigid.bodies import box, falling_cat
from surefoot.worlds.rigid.rigid_world import RigidWorld

BODIES = {"cat": falling_cat, "plank": lambda: box(0.7, (0.6, 0.1, 0.02)), "cube": lambda: box(2.0)}
TERRAINS = (sf.FlatTerrain, lambda: sf.SlopeTerrain(20.0), lambda: rough_ground(1, 0.08))


def robot_called(name: str) -> sf.Robot:
    return BODIES[name]() if name in BODIES else sf.load_robot(name)


def thrown_down(name: str, dt: float, seed: int, speed: float) -> RigidWorld:
    """A world whose robot hangs somewhere within 0.2 m of the ground, base and joints whirling."""
    robot, rng = robot_called(name), np.random.default_rng([seed, round(1e5 * dt)])
    world = RigidWorld(robot, TERRAINS[seed % 3](), mu=rng.uniform(0.0, 1.2), dt=dt)
    turn = np.concatenate([np.zeros(3), 0.5 * rng.normal(size=3), 0.3 * rng.normal(size=robot.joints)])
    q = pinocchio.integrate(robot.model, robot.nominal, turn)
    v = np.concatenate([rng.normal(size=3), 3.0 * rng.normal(size=3), speed * rng.normal(size=robot.joints)])
    q[2] += rng.uniform(0.001, 0.2)
    world.reset(q, v)
    while world.contacts().gaps.min(initial=np.inf) < 1e-4:
        q[2] += 0.01
        world.reset(q, v)
    return world


def judge(world: RigidWorld, steps: int, torques: Callable[[int], np.ndarray]) -> tuple[float, float]:
    """Run; return the kinetic energy at the start and the energy made [J].

    Energy made is the most by which energy less motors' work rises above what it was before. Everything that
    is handed on must be finite, and the ground must push, and stay outside.
    """
    model, robot = world.model, world.robot
    data, base = model.createData(), robot.base_dof
    q, v = world.q_v()
    start = float(pinocchio.computeKineticEnergy(model, data, q, v))
    net = lowest = float(pinocchio.computeMechanicalEnergy(model, data, q, v))
    made = work = 0.0
    for k in range(steps):
        command = torques(k)
        world.step(command)
        after, v = world.q_v()
        reading = world.contacts()
        for values in (after, v, reading.forces, reading.gaps, reading.velocities, reading.positions):
            assert np.isfinite(values).all()
        assert reading.forces[:, 2].min(initial=0.0) > -1e-6 * robot.mass * GRAVITY
        assert reading.gaps.min(initial=0.0) > -1e-5
        work += float(command @ pinocchio.difference(model, q, after)[base:])
        net = float(pinocchio.computeMechanicalEnergy(model, data, after, v)) - work
        made, lowest, q = max(made, net - lowest), min(lowest, net), after
    return start, made


def allowed(world: RigidWorld, kinetic: float) -> float:
    """The bound of docs/rigid-world.md: 1e-6 of the kinetic energy, and the weight lifted by 1 cm/s dt."""
    return 1e-6 * kinetic + 0.01 * world.robot.mass * GRAVITY * world.dt


@pytest.mark.parametrize("dt", [1e-3, 5e-3])
@pytest.mark.parametrize("name", ["go2", "g1", "anymal_c", "solo12", "cat", "plank", "cube"])
@pytest.mark.sampled(3)
def test_limp_bodies_make_no_energy(name, dt):
    """Whirling at 15 rad/s, thrown onto flat, sloping and rough ground."""
    for seed in range(3):
        world = thrown_down(name, dt, seed, 15.0)
        rest = np.zeros(world.robot.joints)
        kinetic, made = judge(world, round(0.25 / dt), lambda _, rest=rest: rest)
        assert made < allowed(world, kinetic), f"seed {seed}: {made:.1e} of {kinetic:.1f} J"


@pytest.mark.parametrize("dt", [1e-3, 2e-3])
@pytest.mark.parametrize("name", ["go2", "g1"])
def test_thrashing_robots_get_what_their_motors_give(name, dt):
    """Torques that change at random every 10 steps; what motors do between two of them is of second order."""
    world, rng = thrown_down(name, dt, 1, 1.0), np.random.default_rng(7)
    size = 0.1 * np.minimum(world.robot.effort_limits, 50.0)
    plan = rng.normal(size=(100, world.robot.joints)) * size
    kinetic, made = judge(world, round(0.2 / dt), lambda k: plan[k // 10])
    assert made < allowed(world, kinetic) + 1e-3 * world.robot.mass * (dt / 1e-3) ** 2


@pytest.mark.parametrize("name", ["go2", "g1", "cat"])
@pytest.mark.parametrize("speed", [1e2, 1e3, 1e5, 1e9, 1e100])
def test_extreme_speeds_are_lawful_or_named(name, speed):
    world = thrown_down(name, 5e-3, 2, speed)
    before, caught = world.q_v(), None
    try:
        kinetic, made = judge(world, 5, lambda _: np.zeros(world.robot.joints))
    except SimulationError as error:
        caught = error
    if caught is None:
        assert made < allowed(world, kinetic)
        assert not np.array_equal(world.q_v()[0], before[0])
    else:
        assert "too fast to resolve" in str(caught)
        assert caught.time == world.time
        reading = world.contacts()
        for values in (*world.q_v(), reading.forces, reading.gaps, reading.velocities, reading.positions):
            assert np.isfinite(values).all()


@pytest.mark.parametrize("gain", [1e3, 1e5, 1e7])
@pytest.mark.parametrize("name", ["go2", "g1"])
def test_unstable_controllers_end_in_an_error(name, gain):
    """Damping far beyond what 5 ms can take: each step turns speeds over, larger."""
    robot = sf.load_robot(name)
    world = RigidWorld(robot, dt=5e-3)
    world.reset(sf.place(robot), np.full(robot.model.nv, 1e-3))
    caught = None
    for _ in range(400):
        before = world.q_v()
        try:
            world.step(-gain * before[1][6:])
        except sf.SurefootError as error:
            caught = error
            break
        assert all(np.isfinite(part).all() for part in world.q_v())
    assert isinstance(caught, SimulationError)
    assert np.array_equal(world.q_v()[1], before[1])
