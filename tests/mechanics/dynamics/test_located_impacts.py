"""Bounces at the time of their touch: slopes through impacts against closed forms, and who bounces when."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest
from scipy.optimize import brentq

import surefoot as sf
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics.collision import Sphere
from surefoot.mechanics.dynamics import State, StepOptions, Stepper, step_derivative
from surefoot.worlds.rigid.bodies import ball, box
from tests.mechanics.dynamics.test_derivative import fine_motion  # noqa: F401
from tests.moving import advance, lifted

E, RADIUS = 0.8, 0.1


def world_of(robot: sf.Robot, height: float, v=(0.0,) * 6, **settings) -> sf.RigidWorld:
    """A world whose body starts `height` above its nominal place, with 0.8 of restitution."""
    world = sf.RigidWorld(robot, restitution=settings.pop("restitution", E), **settings)
    q = lifted(robot.nominal, height)
    world.reset(q, np.array(v, dtype=np.float64))
    return world


def chained(world: sf.RigidWorld, seconds: float, q=(0.0,) * 6, v=(0.0,) * 6, mu: float = 0.0):
    """The end of a run, and how it moves with its start and friction: (12,) of q and v."""
    dq, dv, left = np.array(q), np.array(v), None
    for _ in range(round(seconds / world.dt)):
        world.step(np.zeros(0))
        moved = world.derivative().jvp(q=dq, v=dv, mu=mu, leaving=left)
        dq, dv, left = moved.q, moved.v, moved.leaving
    return world.q_v()[0], np.concatenate([dq, dv])


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("dt", [4e-3, 2e-2])
@pytest.mark.parametrize("seconds", [0.4, 0.6, 1.0])
def test_the_slope_of_a_drop_is_the_closed_form(seconds: float, dt: float, order: int) -> None:
    """-0.345, 0.783 and, after a second bounce, 0.060; the midpoint of a step says 1.000 for each."""
    world = world_of(ball(0.4, RADIUS), 0.5, dt=dt, order=order)
    q, slope = chained(world, seconds, q=np.eye(6)[2])
    t = np.sqrt(2.0 * 0.5 / GRAVITY)  # first touch; it moves with height by 1 / (g t)
    after, up = seconds - t, E * GRAVITY * t
    if after > 2.0 * E * t:
        again = (1.0 + 2.0 * E) * t
        up, after, rate = E * up, seconds - again, (1.0 + 2.0 * E) / (GRAVITY * t)
        dz = E * E * GRAVITY / (GRAVITY * t) * after - (up - GRAVITY * after) * rate
    else:
        dz = E * after / t - (up - GRAVITY * after) / (GRAVITY * t)
    assert q[2] - RADIUS == pytest.approx(up * after - 0.5 * GRAVITY * after**2, abs=1e-9)
    assert slope[2] == pytest.approx(dz, rel=1e-6)


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize(("mu", "grips"), [(0.1, False), (2.0, True)])
def test_slopes_of_a_throw_with_spin_and_friction(mu: float, grips: bool, order: int) -> None:
    """A ball with back spin, by its spin, place, height and friction: it slides through or grips."""
    speed, spin, h, seconds = 1.5, -8.0, 0.5, 0.5
    ways = np.eye(12)[[0, 10, 2]]
    t = np.sqrt(2.0 * h / GRAVITY)
    fall, after = GRAVITY * t, seconds - t
    slip = speed - RADIUS * spin
    if grips:  # a homogeneous ball: the velocity of the touching point goes to nothing
        velocity = speed - 2.0 / 7.0 * slip
        by = {"q": 1.0, "spin": 2.0 / 7.0 * RADIUS * after, "mu": 0.0}
        by_height = (speed - velocity) / fall
    else:
        velocity = speed - mu * (1.0 + E) * fall
        by = {"q": 1.0, "spin": 0.0, "mu": -(1.0 + E) * fall * after}
        by_height = (speed - velocity) / fall - mu * (1.0 + E) / t * after
    for name, way in zip(("q", "spin", "height"), ways, strict=True):
        v = (speed, 0.0, 0.0, 0.0, spin, 0.0)
        world = world_of(ball(0.4, RADIUS), h, v, mu=mu, dt=4e-3, order=order)
        q, slope = chained(world, seconds, way[:6], way[6:])
        turned = pinocchio.Quaternion(*q[[6, 3, 4, 5]]).matrix() @ slope[:3]
        assert turned[0] == pytest.approx(by.get(name, by_height), rel=1e-5, abs=1e-5), name
        assert q[0] == pytest.approx(speed * t + velocity * after, abs=1e-7)
    world = world_of(ball(0.4, RADIUS), h, v, mu=mu, dt=4e-3, order=order)
    q, slope = chained(world, seconds, mu=1.0)
    turned = pinocchio.Quaternion(*q[[6, 3, 4, 5]]).matrix() @ slope[:3]
    assert turned[0] == pytest.approx(by["mu"], rel=1e-5, abs=1e-5)


@pytest.mark.long
def test_a_bouncing_throw_hits_to_a_millimetre_in_15_evaluations() -> None:
    """Thrown at 4 m/s over rough ground, it is to be at 2 m after 0.9 s and a bounce: by its angle."""
    goal, seconds, speed, h, mu = 2.0, 0.9, 4.0, 0.3, 0.1

    def thrown(angle: float) -> tuple[float, float]:
        v = speed * np.array([np.cos(angle), 0.0, np.sin(angle), 0.0, 0.0, 0.0])
        way = speed * np.array([-np.sin(angle), 0.0, np.cos(angle), 0.0, 0.0, 0.0])
        world = world_of(ball(0.4, RADIUS), h, v, mu=mu, dt=4e-3)
        q, slope = chained(world, seconds, v=way)
        return float(q[0]), float((pinocchio.Quaternion(*q[[6, 3, 4, 5]]).matrix() @ slope[:3])[0])

    def closed(angle: float) -> float:
        along, up = speed * np.cos(angle), speed * np.sin(angle)
        fall = np.sqrt(up * up + 2.0 * GRAVITY * h)
        lost = min(mu * (1.0 + E) * fall, 2.0 / 7.0 * along)  # it slides through the touch or grips
        return float(along * seconds - lost * (seconds - (up + fall) / GRAVITY))

    for start in np.linspace(0.3, 1.2, 10):
        angle = float(start)
        for _ in range(15):
            reached, slope = thrown(angle)
            if abs(reached - goal) < 1e-4:
                break
            angle -= float(np.clip((reached - goal) / slope, -0.2, 0.2))
        assert abs(closed(angle) - goal) < 1e-3, start


@pytest.mark.usefixtures("fine_motion")
@pytest.mark.parametrize("order", [1, 2])
def test_a_tumbling_box_bounces_to_rest_and_its_slopes_are_those_of_the_run(order: int) -> None:
    """Up to three touches of corners in a step; bounces end, and energy is never made without friction."""
    body, rng = box(1.0, (0.3, 0.2, 0.1)), np.random.default_rng(1)
    q = pinocchio.integrate(body.model, body.nominal, np.r_[0.0, 0.0, 0.35, 0.3, 0.2, 0.1])
    v, way = np.r_[0.5, 0.2, -0.3, 1.0, 2.0, -0.5], rng.normal(size=12)

    def run(width: float, steps: int = 120) -> sf.RigidWorld:
        world = sf.RigidWorld(body, mu=0.25, restitution=0.4, dt=4e-3, order=order, solver_tol=1e-12)
        world.reset(pinocchio.integrate(body.model, q, width * way[:6]), v + width * way[6:])
        advance(world, steps, np.zeros(0))
        return world

    world = run(0.0, 0)
    _, slope = chained(world, 0.48, way[:6], way[6:])
    low, high = run(-1e-6), run(1e-6)
    moved = pinocchio.difference(body.model, low.q_v()[0], high.q_v()[0])
    wanted = np.concatenate([moved, high.q_v()[1] - low.q_v()[1]]) / 2e-6
    assert slope == pytest.approx(wanted, abs=1e-5 * np.abs(wanted).max())
    events, energies = 0, []
    smooth = sf.RigidWorld(body, mu=0.0, restitution=0.4, dt=4e-3, order=order)
    smooth.reset(q, v)
    for _ in range(500):
        smooth.step(np.zeros(0))
        assert smooth.last is not None
        events = max(events, len(smooth.last.pieces))
        energies.append(smooth.energy())
    assert 2 <= events <= 6
    assert np.diff(energies).max() < 1e-6 * energies[0]
    assert np.abs(smooth.q_v()[1][2:5]).max() < 1e-3  # it lies, whatever it slides


@pytest.mark.usefixtures("fine_motion")
def test_what_touches_slowly_does_not_bounce_and_the_rest_of_the_step_is_ordinary() -> None:
    """A ball a little faster than the least speed that bounces comes down again at once, too slowly."""
    stepper = Stepper(ball(0.4, RADIUS), options=StepOptions(dt=4e-3, restitution=0.1, solver_tol=1e-12))
    q = lifted(stepper.robot.nominal, 1e-4)
    state = stepper.start(q, np.r_[0.3, 0.0, -0.1, 0.0, 1.0, 0.0])
    d = step_derivative(stepper, state, np.zeros(0), mu=0.3)
    assert [p.rest is not None for p in d.step.pieces] == [False, True]
    for way in np.eye(12):
        starts = [State(pinocchio.integrate(stepper.robot.model, q, w * way[:6]), state.v + w * way[6:])
                  for w in (-1e-7, 1e-7)]  # fmt: skip
        low, high = (stepper.step(start, np.zeros(0), mu=0.3).state for start in starts)
        moved = pinocchio.difference(stepper.robot.model, low.q, high.q)
        wanted = np.concatenate([moved, high.v - low.v]) / 2e-7
        assert d.A @ way == pytest.approx(wanted, abs=1e-5 * np.abs(d.A).max())
    for k in range(20):
        d = step_derivative(stepper, state, np.zeros(0), mu=0.3)
        assert (k == 0) == bool(d.step.pieces)
        state = d.step.state
    assert abs(d.step.velocities[0, 2]) < 1e-9


@pytest.mark.parametrize("degrees", [10.0, 25.0, 40.0, 44.0])
def test_a_corner_that_swings_under_a_box_is_met_where_it_touches(degrees: float) -> None:
    """At the end of the step the corner is nearly at its lowest: its speed there does not tell the touch."""
    dt, half, height = 0.02, 0.1, 0.12
    spin, arm = np.radians(degrees) / dt, half * np.sqrt(2.0)

    def gap(t: float) -> float:
        return height - 0.5 * GRAVITY * t * t - arm * np.sin(0.25 * np.pi + spin * t)

    options = StepOptions(dt=dt, restitution=E, impacts="located")
    stepper = Stepper(box(1.0, (2.0 * half,) * 3), options=options)
    state = stepper.start(lifted(stepper.robot.nominal, height - half), np.r_[np.zeros(4), spin, 0.0])
    step = stepper.step(state, np.zeros(0), mu=0.0)
    if gap(dt) > 0.0:
        assert not step.pieces
        return
    touch = brentq(gap, 0.0, dt, xtol=1e-14)
    assert step.pieces[0].seconds == pytest.approx(touch, abs=1e-9)
    met = step.pieces[0].impact
    before = -GRAVITY * touch - arm * spin * np.cos(0.25 * np.pi + spin * touch)
    assert met.velocities[met.near, 2] == pytest.approx(np.full(2, -E * before), rel=1e-6)


def test_without_restitution_impacts_are_located_where_that_is_asked_for() -> None:
    """A box that falls and stays where it touches: its way is v t, and moves with its height by v / (g t)."""
    ends = []
    for impacts in ("auto", "stepped", "located"):
        world = world_of(ball(0.4, RADIUS), 0.5, [1.5] + 5 * [0.0], restitution=0.0, mu=9.0, impacts=impacts)
        advance(world, round(0.32 / world.dt), np.zeros(0))
        ends.append(np.concatenate(world.q_v()))
    assert np.array_equal(ends[0], ends[1])
    for order in (1, 2):
        world = world_of(box(0.4, (0.2, 0.2, 0.2)), 0.5, [1.5] + 5 * [0.0], restitution=0.0, mu=9.0,
                         impacts="located", order=order, dt=4e-3)  # fmt: skip
        q, slope = chained(world, 0.6, q=np.eye(6)[2])
        t = np.sqrt(2.0 * 0.5 / GRAVITY)
        assert (q[0], slope[0]) == pytest.approx((1.5 * t, 1.5 / (GRAVITY * t)), rel=1e-6)
    with pytest.raises(sf.ProblemError, match="impacts"):
        sf.RigidWorld(ball(), impacts="exact")


def test_a_robot_and_a_scene_bounce_at_the_time_of_their_touch() -> None:
    """Go2 on four feet, a ball of a scene on another: the momentum that comes is that of the fall."""
    world = world_of(sf.load_robot("go2"), 0.31, [0.0, 0.0, -1.0] + [0.0] * 15, dt=4e-3)
    for _ in range(150):
        world.step(np.zeros(12))
        if world.last.pieces:
            break
    first = world.last.pieces[0]
    assert first.impact.velocities[first.impact.near, 2] == pytest.approx(
        -E
        * world.stepper.contacts(first.start._replace(q=first.impact.q)).velocities(first.impact.before)[
            first.impact.near, 2
        ],
        abs=1e-6,
    )
    balls = [sf.Body(n, Sphere(RADIUS), 1.0, (0.0, 0.0, z), restitution=E, fixed=n == "low")
             for n, z in (("low", 0.1), ("high", 0.8))]  # fmt: skip
    scene = sf.SceneWorld(sf.Scene(balls), dt=4e-3)
    advance(scene, 100)
    t = np.sqrt(2.0 * 0.5 / GRAVITY)
    up = 0.4 - t
    assert scene.pose("high").position[2] - 0.3 == pytest.approx(
        E * GRAVITY * t * up - 0.5 * GRAVITY * up * up, abs=1e-6
    )
