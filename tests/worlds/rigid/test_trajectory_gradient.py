"""Gradients of whole rollouts: closed forms, differences of rollouts, parameters found from many starts."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
from scipy.optimize import minimize

import surefoot as sf
from surefoot.base.spatial import GRAVITY
from surefoot.laws import HuntCrossley
from surefoot.mechanics.collision import Box, Sphere
from surefoot.worlds.rigid.bodies import ball, box
from surefoot.worlds.rigid.trajectory_gradient import TrajectoryGradient
from tests.moving import advance

NONE = np.zeros(0)


def bounced(speed=1.5, spin=-8.0, height=0.5, mu=0.1, restitution=0.8, mass=0.4, seconds=0.5) -> None:
    world = sf.RigidWorld(ball(mass, 0.1), mu=mu, restitution=restitution, dt=4e-3)
    world.reset([0, 0, 0.1 + height, 0, 0, 0, 1], np.array([speed, 0, 0, 0, spin, 0]))
    advance(world, round(seconds / world.dt), NONE)


def pushed(mass, mu, steps=40) -> None:
    """A flat box, pushed with 10 N for a while: friction of both, mass by the push."""
    world = sf.RigidWorld(box(mass, (0.3, 0.2, 0.1)), mu=mu, dt=1e-2)
    world.reset(world.robot.nominal, np.array([1.0, 0, 0, 0, 0, 0]))
    for k in range(steps):
        world.step(NONE, np.array([10.0, 0, 0]) if k < 10 else None)


def landed(stiffness, dissipation) -> None:
    world = sf.RigidWorld(ball(1.0, 0.1), dt=2e-3, law=HuntCrossley(stiffness, dissipation))
    world.reset([0, 0, 0.12, 0, 0, 0, 1])
    advance(world, 100, NONE)


def walked(kp=60.0, kd=3.0, mu=0.25, speed=0.4, payload=1.0, torques=None, order=2) -> None:
    robot = sf.load_robot("go2")
    world, start = sf.RigidWorld(robot, mu=mu, dt=2e-3, payload=payload, order=order), sf.place(robot)
    start[2] += 0.01
    world.reset(start, np.r_[speed, np.zeros(17)])
    for k in range(60):
        q, v = world.q_v()
        world.step(kp * (start[7:] - q[7:]) - kd * v[6:] + (0.0 if torques is None else torques[k]))


def differences(gradient: TrajectoryGradient, name: str, **parameters) -> np.ndarray:
    value, out = np.asarray(parameters[name], dtype=float), []
    for i in np.ndindex(value.shape):
        e = np.zeros(value.shape)
        e[i] = 1e-6 * max(1.0, abs(value[i]))
        low, high = (gradient.value(**{**parameters, name: value + s * e}) for s in (-1.0, 1.0))
        out.append((high - low) / (2.0 * e[i]))
    return np.array(out).reshape(value.shape)


@pytest.mark.parametrize("e", [0.8, 1.0])
def test_a_bounce_has_the_gradient_of_its_closed_form(e: float) -> None:
    """x = v t + (v - mu (1 + e) g t₁) (T - t₁) for a ball that slides through the touch."""
    names = ["speed", "spin", "height", "mu", "restitution", "mass"]
    found = sf.trajectory_gradient(bounced, lambda q, v: q[-1, 0], wrt=names)(
        **dict(zip(names, (1.5, -8.0, 0.5, 0.1, e, 0.4), strict=True))
    )
    t, mu, after = np.sqrt(1.0 / GRAVITY), 0.1, 0.5 - np.sqrt(1.0 / GRAVITY)
    wanted = {"speed": 0.5, "spin": 0.0, "mass": 0.0, "mu": -(1.0 + e) * GRAVITY * t * after,
              "restitution": -mu * GRAVITY * t * after, "height": mu * (1 + e) * (t - after) / t}  # fmt: skip
    assert found.loss == pytest.approx(1.5 * 0.5 - mu * (1.0 + e) * GRAVITY * t * after, abs=1e-7)
    for name, slope in wanted.items():
        assert found.gradient[name] == pytest.approx(slope, abs=1e-5), name


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.long
def test_a_controlled_robot_has_the_gradient_of_differences(order: int) -> None:
    """Through the user's own controller: gains, friction, speed, payload, and extra torques of every step."""
    rng = np.random.default_rng(0)
    given = {"kp": 60.0, "kd": 3.0, "mu": 0.25, "speed": 0.4, "payload": 1.0,
             "torques": 0.1 * rng.normal(size=(60, 12)), "order": order}  # fmt: skip
    gradient = sf.trajectory_gradient(walked, lambda q, v: q[-1, 0] + q[::7, 2].sum(), wrt=list(given)[:-1])
    found = gradient(**given).gradient
    for name in ("kp", "kd", "mu", "speed", "payload"):
        assert found[name] == pytest.approx(
            float(differences(gradient, name, **given)), rel=1e-3, abs=1e-8
        ), name
    few, looks = list(given)[:5], []
    dense = sf.trajectory_gradient(walked, lambda q, v: looks.append(q) or gradient.loss(q, v), wrt=few)
    assert dense(**given).gradient == pytest.approx({name: found[name] for name in few}, rel=1e-5)
    assert len(looks) == 2 * len(few) + 1  # however many states the loss looks at
    way = rng.normal(size=(60, 12))
    ends = [gradient.value(**{**given, "torques": given["torques"] + s * 1e-4 * way}) for s in (-1.0, 1.0)]
    assert float((found["torques"] * way).sum()) == pytest.approx((ends[1] - ends[0]) / 2e-4, rel=1e-3)


@pytest.mark.long
@pytest.mark.parametrize(("rollout", "truth", "low", "high"), [
    (pushed, {"mass": 1.2, "mu": 0.3}, (0.5, 0.1), (3.0, 0.5)),
    (landed, {"stiffness": 6e3, "dissipation": 0.4}, (2e3, 0.1), (2e4, 1.5)),
], ids=["mass and friction of a pushed box", "stiffness and dissipation of a landing"])  # fmt: skip
def test_parameters_are_found_from_10_of_10_starts(rollout, truth, low, high) -> None:
    names, seen = list(truth), []
    sf.trajectory_gradient(rollout, lambda q, v: seen.append((q.copy(), v.copy())) or 0.0, wrt=names).value(
        **truth
    )

    def off(q, v) -> float:
        return float(1e4 * ((q[:, [0, 2]] - seen[0][0][:, [0, 2]]) ** 2).mean())

    gradient = sf.trajectory_gradient(rollout, off, wrt=names)
    low, high = np.log(low), np.log(high)

    def both(x) -> tuple[float, np.ndarray]:
        found = gradient(**dict(zip(names, np.exp(x), strict=True)))
        return found.loss, np.exp(x) * np.array([found.gradient[n] for n in names])

    rng = np.random.default_rng(0)
    for _ in range(10):
        start = rng.uniform(low, high)
        end = minimize(both, start, jac=True, method="L-BFGS-B", bounds=list(zip(low, high, strict=True)),
                       options={"ftol": 1e-15, "gtol": 1e-10})  # fmt: skip
        assert np.exp(end.x) == pytest.approx(list(truth.values()), rel=1e-3), start


def test_jax_sees_one_function() -> None:
    jax = pytest.importorskip("jax")
    gradient = sf.trajectory_gradient(bounced, lambda q, v: q[-1, 0] ** 2, wrt=["speed", "mu"])
    found = gradient(speed=1.5, mu=0.1)
    slopes = jax.grad(lambda p: 2.0 * gradient.jax(p[0], p[1]))(jax.numpy.array([1.5, 0.1]))
    assert np.asarray(slopes) == pytest.approx([2.0 * found.gradient[n] for n in ("speed", "mu")], rel=1e-5)
    assert float(jax.jit(gradient.jax)(1.5, 0.1)) == pytest.approx(found.loss, rel=1e-6)


def test_torch_sees_one_function() -> None:
    torch = pytest.importorskip("torch")
    gradient = sf.trajectory_gradient(bounced, lambda q, v: q[-1, 0] ** 2, wrt=["speed", "mu"])
    speed, mu = (torch.tensor(x, dtype=torch.float64, requires_grad=True) for x in (1.5, 0.1))
    gradient.torch(speed, mu).backward()
    assert float(mu.grad) == pytest.approx(gradient(speed=1.5, mu=0.1).gradient["mu"])


def collided(speed, e, m1, m2, x, off=0.0, mu=0.0, spin=0.0) -> None:
    """Two balls in free fall, the second at rest beside the first."""
    way, turning = (speed, 0, 0), (0, 0, spin)
    balls = [sf.Body("a", Sphere(0.1), m1, (0, 0, 9.0), velocity=way, spin=turning, restitution=e),
             sf.Body("b", Sphere(0.1), m2, (x, off, 9.0), restitution=e)]  # fmt: skip
    advance(sf.SceneWorld(sf.Scene(balls), mu=mu, dt=4e-3), 100)


def test_two_balls_that_collide_have_the_gradient_of_their_closed_form() -> None:
    """The second ends at x + c (s T - x + 2 r), c = m1 (1 + e) / (m1 + m2)."""
    s, e, m1, m2, x, t = 2.0, 0.7, 1.0, 2.0, 0.5, 0.4
    hit = sf.trajectory_gradient(collided, lambda q, v: q[-1, 7], wrt=["speed", "e", "m1", "m2", "x"])
    found, c, way = hit(speed=s, e=e, m1=m1, m2=m2, x=x), m1 * (1.0 + e) / (m1 + m2), s * t - x + 0.2
    assert found.loss == pytest.approx(x + c * way, abs=1e-9)
    by_mass = (1.0 + e) * way / (m1 + m2) ** 2
    wanted = {
        "speed": c * t,
        "e": m1 / (m1 + m2) * way,
        "m1": m2 * by_mass,
        "m2": -m1 * by_mass,
        "x": 1.0 - c,
    }
    assert found.gradient == pytest.approx(wanted, rel=1e-7)


def slid(mu, rough, m, push, x, boxes=2) -> None:
    """A stack whose lowest box is pushed: all slide on the ground, the upper ones on each other as well."""
    cube = Box((0.2, 0.2, 0.2))
    stack = [sf.Body(f"b{k}", cube, m if k else 2.0, (x * k, 0, 0.1 + 0.2 * k), friction=rough if k else mu)
             for k in range(boxes)]  # fmt: skip
    advance(sf.SceneWorld(sf.Scene(stack), mu=mu, dt=5e-3), 20, None, np.array([push, 0, 0]))


def dropped(h, e, m, mu) -> None:
    """A ball falls on another that lies on the ground: met in the middle of the step."""
    low, high = (0.0, 0.0, 0.1), (0.01, 0.0, 0.3 + h)
    balls = [sf.Body("low", Sphere(0.1), 1.0, low, restitution=e), sf.Body("high", Sphere(0.1), m, high)]
    advance(sf.SceneWorld(sf.Scene(balls), dt=4e-3, mu=mu, restitution=e), 80)


def caught(mass, x, kp) -> None:
    """A ball falls on the back of a Go2 that holds its pose: bodies next to a joint tree."""
    robot = sf.load_robot("go2")
    scene, start = sf.Scene([sf.Body("ball", Sphere(0.1), mass, (x, 0.0, 0.6))], robot), sf.place(robot)
    world, kd = sf.SceneWorld(scene, dt=4e-3), 2.0
    world.reset(np.r_[start, scene.start()[0][19:]])
    for _ in range(50):
        q, v = world.q_v()
        world.step(kp * (start[7:] - q[7:19]) - kd * v[6:18])


@pytest.mark.parametrize(("rollout", "given"), [
    (caught, {"mass": 1.0, "x": 0.05, "kp": 60.0}),
    (collided, {"speed": 2.0, "e": 0.7, "m1": 1.0, "m2": 2.0, "x": 0.5, "off": 0.08, "mu": 0.2, "spin": 5.0}),
    (slid, {"mu": 0.3, "rough": 0.1, "m": 1.0, "push": 20.0, "x": 0.03}),
    (partial(slid, boxes=5), {"mu": 0.4, "rough": 0.35, "m": 0.7, "push": 30.0, "x": 0.004}),
    (dropped, {"h": 0.3, "e": 0.8, "m": 0.5, "mu": 0.3}),
], ids=["on a robot", "oblique", "pushed stack", "stack of 5", "on a ball that lies"])  # fmt: skip
@pytest.mark.sampled(1)
def test_scenes_have_the_gradient_of_differences(rollout, given) -> None:
    gradient = sf.trajectory_gradient(
        rollout, lambda q, v: q[-1, 0] + 2.0 * q[-1, 7] + v[-1, 6], wrt=list(given)
    )
    found = gradient(**given).gradient
    for name in given:
        truth = float(differences(gradient, name, **given))
        assert found[name] == pytest.approx(truth, rel=1e-5, abs=1e-6), name


def test_what_has_no_gradient_is_refused() -> None:
    def wrong(**changes):
        def rollout(x) -> None:
            world = sf.RigidWorld(ball(1.0, 0.1 + changes.get("radius", 0.0) * x), dt=2e-3)
            kept = 0.0
            for _ in range(5):
                kept = 0.5 * kept + float(world.q_v()[0][2])
                noise = np.random.default_rng().normal() if "noise" in changes else 0.0
                world.step(NONE, np.array([x + kept * changes.get("memory", 0.0) + noise, 0.0, 0.0]))

        return sf.trajectory_gradient(rollout, lambda q, v: q[-1, 0], wrt=["x"])

    assert wrong()(x=0.1).gradient["x"] > 0.0
    for changes, message in (
        ({"radius": 1.0}, "shapes"),
        ({"memory": 1.0}, "remembers"),
        ({"noise": 1.0}, "random"),
    ):
        with pytest.raises(sf.ProblemError, match=message):
            wrong(**changes)(x=0.1)
    for at, message in (
        ({}, "give the rollout's x"),
        ({"x": np.nan}, "x is NaN"),
        ({"x": "fast"}, "x must be"),
    ):
        with pytest.raises(sf.ProblemError, match=message):
            wrong()(**at)
    with pytest.raises(sf.ProblemError, match="valid names: x"):
        sf.trajectory_gradient(wrong().rollout, lambda q, v: 0.0, wrt=["speed"])
    with pytest.raises(sf.ProblemError, match="the loss must be a number"):
        sf.trajectory_gradient(wrong().rollout, lambda q, v: None, wrt=["x"])(x=0.1)
    with pytest.raises(sf.ProblemError, match="this one took none"):
        sf.trajectory_gradient(lambda x: None, lambda q, v: 0.0, wrt=["x"])(x=1.0)
