"""The rigid world keeps the laws, whatever is thrown into it, and says so where it cannot."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pinocchio
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import surefoot as sf
from surefoot.base.errors import SimulationError
from surefoot.base.spatial import GRAVITY
from surefoot.records.audit.laws import log_laws
from surefoot.worlds.rigid.bodies import ball, box
from surefoot.worlds.rigid.rigid_world import RigidWorld
from tests.moving import advance, lifted
from tests.worlds.rigid.rigid_runs import NONE, on_slope, run


@settings(max_examples=12, deadline=None, derandomize=True)
@given(
    spin=arrays(float, 3, elements=st.floats(-30, 30)),
    speed=arrays(float, 3, elements=st.floats(-3, 3)),
    turn=arrays(float, 3, elements=st.floats(-3, 3)),
    mu=st.floats(0, 1.5),
    degrees=st.floats(-40, 40),
)
@example(spin=np.full(3, 20.0), speed=np.zeros(3), turn=np.ones(3), mu=1.0, degrees=0.0)
def test_thrown_plank_obeys_every_law(spin, speed, turn, mu, degrees):
    """No penetration beyond the curvature of a step, forces in their cones, energy that only falls."""
    body = box(0.7, (0.6, 0.1, 0.02))
    terrain = sf.SlopeTerrain(degrees)
    world = RigidWorld(body, terrain, mu=mu)
    q = pinocchio.integrate(body.model, on_slope(body, degrees, 0.4), np.concatenate([np.zeros(3), turn]))
    world.reset(q, np.concatenate([speed, spin]))
    energy = start = world.energy()
    for _ in range(400):
        turning = np.linalg.norm(world.q_v()[1][3:])
        world.step(NONE)
        reading = world.contacts()
        assert world.contact_work() <= 1e-10
        tangent = np.hypot(reading.forces[:, 0], reading.forces[:, 1])
        assert np.all(tangent <= mu * reading.forces[:, 2] + 1e-5)
        reach = np.linalg.norm(world.q_v()[1][3:]) + turning
        last, energy = energy, world.energy()
        # the bound of docs/rigid-world.md: a contact that opens or closes within a step errs at first order
        assert energy <= last + 1e-6 * start + 9.81 * 0.7 * 1e-2 * world.dt
        assert reading.gaps.min() > -1e-6 - 0.31 * (reach * world.dt) ** 2
    assert world.unsolved == 0


@pytest.mark.parametrize("stabilisation", ["projection", "baumgarte", "none"])
def test_stabilisation_undoes_a_penetration(stabilisation):
    body = box(1.0, (0.2, 0.2, 0.2))
    world = RigidWorld(body, stabilisation=stabilisation)
    world.reset(lifted(body.nominal, -0.002))
    run(world, 0.1)
    deepest = world.contacts().gaps.min()
    if stabilisation == "none":
        assert deepest == pytest.approx(-0.002, rel=1e-6)
    else:
        assert deepest > -1e-5
    if stabilisation == "projection":  # moved without a kick
        assert np.abs(world.q_v()[1]).max() < 1e-9


def test_robot_without_contacts_follows_aba():
    """Against the classical Runge-Kutta scheme in joint coordinates."""
    robot = sf.load_robot("panda")
    world, torque, h = RigidWorld(robot), np.linspace(-1, 1, 9), 5e-4

    def rate(y):
        return np.concatenate([y[9:], pinocchio.aba(robot.model, robot.data, y[:9], y[9:], torque)])

    y = np.concatenate([robot.nominal, np.zeros(9)])
    for _ in range(100):
        a = rate(y)
        b = rate(y + h / 2 * a)
        c = rate(y + h / 2 * b)
        y = y + h / 6 * (a + 2 * b + 2 * c + rate(y + h * c))
    advance(world, 50, torque)
    assert np.abs(np.concatenate(world.q_v()) - y).max() < 1e-8 * np.abs(y).max()
    assert world.contacts().forces.shape == (0, 3)


@pytest.mark.parametrize("size", [1e5, 1e12, 1e200])
def test_a_lost_state_raises_and_is_never_handed_on(size):
    """Torques that no step can take: the world stays where it was, and goes on from there."""
    robot = sf.load_robot("go2")
    world = RigidWorld(robot)
    world.reset(sf.place(robot))
    advance(world, 5, np.zeros(12))
    caught = None
    for _ in range(100):
        before, time = world.q_v(), world.time
        try:
            world.step(np.full(12, size))
        except SimulationError as error:
            caught = error
            break
    assert re.search(r"became non-finite or too fast .* smaller dt", str(caught))
    assert caught.time == time == world.time
    assert np.array_equal(world.q_v()[0], before[0])
    assert np.array_equal(world.q_v()[1], before[1])
    reading = world.contacts()
    for values in (reading.forces, reading.gaps, reading.velocities, reading.positions):
        assert np.isfinite(values).all()
    world.reset(sf.place(robot))
    world.step(np.zeros(12))
    assert np.isfinite(world.energy())


def test_convex_law_throws_a_sliding_block_up():
    """The convex law asks for u_n + gap / dt = mu ||u_t||: it kicks the block up by mu v / (1 + mu²), then
    floats it at a gap of dt mu v. Momentum balance keeps the mean friction, and so the speed, right.
    """
    body = box(2.0, (0.3, 0.3, 0.1))
    world = RigidWorld(body, mu=0.5, law="convex")
    world.reset(body.nominal, np.array([2.0, 0, 0, 0, 0, 0]))
    states = run(world, 0.2)
    kick = (0.5 * 2.0 - 0.25 * GRAVITY * world.dt) / 1.25
    assert states[0][1][2] == pytest.approx(kick, rel=1e-2)
    q, v = states[-1]
    assert q[2] - 0.05 == pytest.approx(world.dt * 0.5 * v[0], rel=0.02)
    assert v[0] == pytest.approx(2.0 - 0.5 * GRAVITY * 0.2, rel=0.01)


def test_bad_input():
    with pytest.raises(sf.ProblemError, match="mass must be positive"):
        ball(0.0)
    with pytest.raises(sf.ProblemError, match="size must be above twice the rounding"):
        box(1.0, (0.1, 0.1, 0.02), rounding=0.02)


@pytest.mark.parametrize("world", ["rigid", "mujoco"])
def test_what_soft_ground_declares_counts_in_summary_and_audit_alike(world: str) -> None:
    """Two millimetres deep in either world: the ground's own softness, and no broken law."""
    robot, flat = sf.load_robot("go2"), sf.FlatTerrain()
    q = sf.place(robot, flat)
    law = sf.laws.SpringDamper(2e4, 400.0)
    made = {
        "rigid": lambda: RigidWorld(robot, flat, 0.6, law=law),
        "mujoco": lambda: sf.MujocoWorld(robot, flat, 0.6, solref=(0.02, 1.0), solimp=(0.9, 0.95)),
    }[world]()
    controller = sf.StandingController(robot, sf.StandingPlan(robot, flat, q), flat, q, mu=0.6)
    log = sf.run(made, controller, sf.Scenario(0.4, mu=0.6, start=q))
    laws = log_laws(log)
    assert laws.penetration_max > 1.5e-3
    assert laws.broken(robot.mass * GRAVITY) == []
    assert sf.audit_log(log).verdict == "lawful"
    hard = replace(laws, sinking=0.0)
    assert "penetration" in hard.broken(robot.mass * GRAVITY)[0]


def test_there_is_no_derivative_of_a_step_before_the_first() -> None:
    world = RigidWorld(sf.load_robot("go2"))
    with pytest.raises(sf.ProblemError, match="before the first step"):
        world.derivative()
    world.step(np.zeros(12))
    world.derivative()
    world.reset(world.robot.nominal)
    with pytest.raises(sf.ProblemError, match="before the first step"):
        world.derivative()


def test_soft_ground_under_a_robot_that_never_lands_gives_way_by_its_weight_alone() -> None:
    """A spring stops what comes at no speed at twice its rest depth: m g x = k x² / 2."""
    robot, stiffness = sf.load_robot("go2"), 2e4
    world = RigidWorld(robot, law=sf.laws.SpringDamper(stiffness, 400.0))
    speeds = np.tile([0.0, 0.0, -1.0], (3, 4, 1))

    def sinking(loads: np.ndarray) -> float:
        rows = {"forces": loads, "contact_velocities": speeds}
        return world.softness(rows)["sinking"]  # type: ignore[arg-type]  # it reads two channels

    assert sinking(np.zeros((3, 4, 3))) == pytest.approx(2.0 * robot.mass * GRAVITY / stiffness, rel=1e-3)
    loads = np.zeros((3, 4, 3))
    loads[2, 1, 2] = 10.0  # and one that lands at 1 m/s: x = d + sqrt(d² + m v² / k)
    depth = robot.mass * GRAVITY / stiffness
    assert sinking(loads) == pytest.approx(depth + np.sqrt(depth**2 + robot.mass / stiffness), rel=1e-3)
