"""Soft laws in the rigid-body world: closed forms, the law itself, convergence, passivity, bad input."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import surefoot as sf
from surefoot.base.errors import ProblemError, SimulationError
from surefoot.base.spatial import GRAVITY, quaternion_from_rotation, rotation_about
from surefoot.laws import Hertz, HuntCrossley, MujocoLaw, RegularisedFriction, SoftLaw, SpringDamper
from surefoot.worlds.rigid.bodies import ball, box
from surefoot.worlds.rigid.rigid_world import RigidWorld
from tests.moving import advance, lifted

NONE = np.zeros(0)
MASS = 4.0
LAWS: dict[str, SoftLaw] = {
    "spring": SpringDamper(2e4, 400.0),
    "stiff": SpringDamper(1e9, 1e4),
    "hunt-crossley": HuntCrossley(2e5, 5.0),
    "hertz": Hertz.sphere(0.1, 1e6, dissipation=5.0),
    "mujoco": MujocoLaw(mass=MASS),
    "mujoco-direct": MujocoLaw((-3000.0, -60.0), (0.3, 0.95, 0.003, 0.3, 3.0), mass=MASS),
}


class ImplicitStep(SoftLaw):
    """What an implicit step of dt makes of a law: the overlap at its end counts, which damps by k dt."""

    def __init__(self, law: SoftLaw, dt: float) -> None:
        super().__init__()
        self.__dict__.update(law=law, dt=dt)

    def pressed(self, depth, rate):
        force, by_depth, by_rate = self.law.pressed(depth, rate)
        return force + self.dt * by_depth * rate, by_depth, by_rate + self.dt * by_depth

    def stored(self, depth):
        return self.law.stored(depth)


def dropped(law, height: float, seconds: float, dt: float = 1e-3, speed: float = 0.0, **options) -> tuple:
    """Return the world, and gaps and upward velocities after every step, of a ball."""
    body = ball(MASS, 0.1)
    world = RigidWorld(body, law=law, dt=dt, **options)
    q, v = lifted(body.nominal, height), np.zeros(6)
    v[2] = speed
    world.reset(q, v)
    track = []
    for _ in range(round(seconds / dt)):
        world.step(NONE)
        q, v = world.q_v()
        track.append((q[2] - 0.1, v[2]))
    return world, *np.array(track).T


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS.keys())
@pytest.mark.sampled(2)
def test_a_dropped_ball_comes_to_rest_where_the_law_carries_it(law):
    world, gaps, speeds = dropped(law, 0.05, 2.0)
    assert -gaps[-1] == pytest.approx(law.rest_depth(MASS * GRAVITY), rel=1e-6)
    assert abs(speeds[-1]) < 1e-6
    assert world.contacts().forces[0, 2] == pytest.approx(MASS * GRAVITY, rel=1e-6)
    assert (world.unsolved, world.law_error <= 1e-8) == (0, True)


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS.keys())
def test_every_force_is_the_laws_own(law):
    """The law itself, at the end of each step, from the gaps and velocities that the world reports."""
    body, touched = ball(MASS, 0.1), 0
    world = RigidWorld(body, law=law)
    world.reset(lifted(body.nominal, 0.02))
    before = 0.0
    for _ in range(300):
        world.step(NONE)
        seen = world.contacts()
        gap, speed = float(seen.gaps[0]), float(seen.velocities[0, 2])
        depth = -(gap + world.dt * speed)
        if seen.forces[0, 2] > 0.0 and depth > 1e-9:
            if isinstance(law, MujocoLaw):
                stiff, damp = law.stiffness_and_damping
                d = float(law.impedance(np.array(depth))[0])
                pull = -damp * speed + stiff * d * depth - (speed - before) / world.dt
                wanted = law.mass * d / (1.0 - d) * pull
            else:
                wanted = float(law.normal(-depth, speed))
            slack = 1e-7 if law is not LAWS["stiff"] else 1e-4  # there the depth itself has lost digits
            assert seen.forces[0, 2] == pytest.approx(wanted, rel=slack)
            touched += 1
        before = world.q_v()[1][2]
    assert touched > 50


@pytest.mark.parametrize(
    "law", [SpringDamper(2e4, 40.0), HuntCrossley(2e5, 0.4), Hertz.sphere(0.1, 1e6, 0.5, 0.4)]
)
def test_bounce_is_the_one_that_the_implicit_law_has_in_closed_form(law):
    errors = []
    for dt in (2e-4, 1e-4):
        _, gaps, speeds = dropped(law, 0.0, 0.1, dt, speed=-1.0)
        left = speeds[np.argmax((gaps > 0.0) & (speeds > 0.0))]
        assert left == pytest.approx(sf.laws.rebound(ImplicitStep(law, dt), MASS, 1.0), abs=0.02)
        errors.append(abs(left - sf.laws.rebound(law, MASS, 1.0)))
    assert 1.6 < errors[0] / errors[1] < 2.5  # first order in dt


@pytest.mark.long
def test_frequency_and_damping_about_rest():
    law, dt = SpringDamper(2e4, 10.0), 1e-4
    expected = sf.laws.behaviour(law, MASS)
    _, gaps, _ = dropped(law, -1.3 * expected.rest_depth, 0.6, dt)
    x = gaps + expected.rest_depth
    past = np.column_stack([x[20:-20:20], x[:-40:20]])
    a, b = np.linalg.lstsq(past, x[40::20], rcond=None)[0]
    roots = np.log(np.roots([1.0, -a, -b]).astype(complex)) / (20 * dt)
    frequency = math.sqrt((roots[0] * roots[1]).real)
    ratio = -roots.sum().real / 2.0 / frequency
    assert frequency == pytest.approx(expected.frequency, rel=2e-3)
    assert ratio == pytest.approx(expected.ratio + 0.5 * expected.frequency * dt, rel=0.01)


def test_soft_converges_to_rigid_with_the_order_of_its_overlap():
    """A sliding box that lands: the distance from rigid motion is m g / k, and (m g / k)^(2/3) for Hertz."""
    body = box(2.0, (0.3, 0.3, 0.1), 0.01)
    start = np.array([1.0, 0.2, -0.5, 0.0, 0.0, 0.0])

    def end(law):
        world = RigidWorld(body, mu=0.5, law=law)
        q = lifted(body.nominal, 0.0013)
        world.reset(q, start)
        advance(world, 150, NONE)
        assert world.unsolved == 0
        return world.q_v()[0][:3]

    rigid = end(None)
    for make, order in ((lambda k: SpringDamper(k, 1e-2 * k), 1.0), (lambda k: Hertz(k, 30.0), 2.0 / 3.0)):
        errors = [abs(end(make(k))[2] - rigid[2]) for k in (1e7, 1e8, 1e9)]
        slopes = -np.diff(np.log10(errors))
        assert np.abs(slopes - order).max() < 0.02, slopes
    apart = [np.linalg.norm(end(SpringDamper(k, 1e-2 * k)) - rigid) for k in (1e6, 1e8, 1e10)]
    assert apart[0] > 30.0 * apart[1] > 900.0 * apart[2]


@pytest.mark.parametrize("law", [v for k, v in LAWS.items() if "mujoco" not in k])
@pytest.mark.parametrize("seed", [0, *(pytest.param(k, marks=pytest.mark.long) for k in (1, 2))])
@pytest.mark.sampled(1)
def test_thrown_box_never_gains_energy(law, seed):
    """Kinetic, potential and stored energy together fall at every step but for `Stepper.stored`'s bound."""
    rng = np.random.default_rng(seed)
    body = box(MASS, (0.3, 0.2, 0.1), 0.01)
    world = RigidWorld(body, mu=0.4, law=law)
    q, v = lifted(body.nominal, 0.05), 0.7 * rng.normal(size=6)
    v[3:] = 0.0  # a turning edge moves by the square of dt: see the robots below
    world.reset(q, v)
    energy = world.energy()
    for _ in range(400):
        world.step(NONE)
        made, energy = world.energy() - energy, world.energy()
        push = world.last.impulses[:, 2].sum()
        assert made <= 0.5 * push * GRAVITY * world.dt + 1e-5, made
    assert world.unsolved == 0


@pytest.mark.long
@pytest.mark.parametrize("name", ["go2", "g1"])
@pytest.mark.parametrize("law", [SpringDamper(2e4, 100.0), HuntCrossley(2e5, 0.5)], ids=["linear", "hunt"])
def test_limp_robot_makes_no_energy_beyond_the_first_order_of_the_step(name, law):
    robot = sf.load_robot(name)
    made = []
    for dt in (1e-3, 2.5e-4):
        world = RigidWorld(robot, law=law, dt=dt)
        world.reset(lifted(robot.nominal, 0.1))
        energies = [world.energy()]
        for _ in range(round(0.5 / dt)):
            world.step(np.zeros(robot.joints))
            energies.append(world.energy())
        lowest = np.minimum.accumulate(energies)
        made.append((np.array(energies) - lowest).max())
        assert max(energies) <= energies[0] * (1.0 + 1e-9)
        assert energies[-1] < energies[0]
        assert world.unsolved == 0
    scale = robot.mass * GRAVITY * 0.1
    assert made[0] < 0.1 * scale
    assert made[1] < max(0.5 * made[0], 1e-4 * scale)


def test_friction_is_exact():
    body, mu = box(2.0, (0.3, 0.3, 0.02)), 0.5
    law = SpringDamper(5e4, 200.0, friction=mu)
    world = RigidWorld(body, law=law)
    assert world.mu == mu
    q = lifted(body.nominal, -law.rest_depth(2.0 * GRAVITY / 4.0))
    world.reset(q, np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0]))
    advance(world, 300, NONE)
    assert world.q_v()[0][0] == pytest.approx(1.0 / (2.0 * mu * GRAVITY), rel=2e-3)
    assert np.abs(world.q_v()[1]).max() < 1e-8
    limit = math.atan(mu)
    for angle, sticks in ((limit - 0.01, True), (limit + 0.01, False)):
        world = RigidWorld(body, sf.SlopeTerrain(math.degrees(angle)), law=law)
        rotation = rotation_about([0, 1, 0], -angle)
        q[:3], q[3:7] = rotation @ [0.0, 0.0, 0.01], quaternion_from_rotation(rotation)
        world.reset(q)
        advance(world, 600, NONE)
        assert (np.linalg.norm(world.q_v()[1][:3]) < 1e-6) == sticks
        assert world.unsolved == 0


@pytest.mark.parametrize("ratio", [0.0, 0.3])
def test_an_explicit_step_fails_just_above_the_limit_and_the_worlds_does_not(ratio):
    dt = 1e-3
    for share, stable in ((0.98, True), (1.02, False)):
        frequency = share * 2.0 * (math.sqrt(1.0 + ratio**2) - ratio) / dt
        law = SpringDamper(MASS * frequency**2, 2.0 * ratio * MASS * frequency)
        assert sf.laws.stable_step(law, MASS, 0.0) == pytest.approx(dt / share, rel=1e-12)
        depth, speed = law.rest_depth(MASS * GRAVITY), 0.0
        way, worst = 1.001 * depth, 0.0
        for _ in range(600):  # forces first, velocities, then places
            speed -= dt * (float(law.normal(np.array(-way), np.array(-speed))) / MASS - GRAVITY)
            way += dt * speed
            worst = max(worst, abs(way / depth - 1.0))
        assert (worst < 0.01) if stable else (worst > 0.5)
        _, gaps, _ = dropped(law, -1.001 * depth, 0.6, dt)
        assert np.abs(gaps / depth + 1.0).max() < 0.0011


def test_friction_that_is_no_cone_is_refused():
    law = SpringDamper(5e4, 200.0, friction=RegularisedFriction(0.6, 1e-2))
    with pytest.raises(ProblemError, match="ExactFriction, which RegularisedFriction replaces"):
        RigidWorld(ball(), law=law)


def test_contact_begins_where_the_gap_closes_within_the_step_and_never_pulls():
    """A damper alone would stop a fast ball in the air; it is stopped at the surface at the earliest."""
    law = SpringDamper(1e4, 2e4)
    body = ball(MASS, 0.1)
    world = RigidWorld(body, law=law)
    q, v = lifted(body.nominal, 0.0022), np.zeros(6)
    v[2] = -3.0
    world.reset(q, v)
    world.step(NONE)  # the middle of the step is 0.7 mm above the ground, its span ends at it
    seen = world.contacts()
    assert 0.0 < seen.forces[0, 2] < law.damping * 3.0
    assert seen.gaps[0] + world.dt * seen.velocities[0, 2] == pytest.approx(0.0, abs=1e-12)
    assert world.law_error <= 1e-8
    for _ in range(100):
        world.step(NONE)
        assert world.contacts().forces[0, 2] >= 0.0


@given(
    st.sampled_from(sorted(LAWS)), st.floats(-12.0, 14.0), st.floats(-6.0, 6.0), st.floats(-1e3, 1e3),
    st.floats(-0.05, 0.05), st.sampled_from([1e-5, 1e-3, 0.05]),
)  # fmt: skip
@settings(max_examples=120, deadline=None)
@pytest.mark.long
def test_extreme_laws_and_speeds_give_a_lawful_step_or_a_named_error(name, power, damped, speed, height, dt):
    law = LAWS[name]
    if isinstance(law, SpringDamper):
        law = SpringDamper(10.0**power, 10.0**damped)
    elif isinstance(law, HuntCrossley):
        law = HuntCrossley(10.0**power, 10.0**damped, law.exponent)
    body = ball(MASS, 0.1)
    world = RigidWorld(body, law=law, dt=dt)
    q, v = lifted(body.nominal, height), np.zeros(6)
    v[2], v[0] = speed, 0.3 * speed
    world.reset(q, v)
    try:
        for _ in range(4):
            world.step(NONE)
            force = world.contacts().forces[0]
            assert np.isfinite(force).all()
            assert force[2] >= 0.0
            assert np.linalg.norm(force[:2]) <= world.mu * force[2] * (1.0 + 1e-6) + 1e-9
            assert np.isfinite(world.energy())
    except SimulationError as error:
        assert "non-finite" in str(error)  # noqa: PT017 - either outcome is right
    assert world.law_error <= 1e-8 or world.unsolved > 0


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"restitution": 0.3}, "restitution is of rigid contacts"),
        ({"stabilisation": "baumgarte"}, "baumgarte"),
    ],
)
def test_wrong_options_are_named(options, words):
    with pytest.raises(ProblemError, match=words):
        RigidWorld(ball(), **({"law": SpringDamper(1e4)} | options))
