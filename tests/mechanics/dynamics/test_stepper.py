"""A step is a function of the state: taken twice, out of turn or from elsewhere, it is the same."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest

import surefoot as sf
from surefoot.base.errors import SimulationError
from surefoot.mechanics.dynamics import State, StepOptions, Stepper
from surefoot.mechanics.dynamics.impacts import Tally
from surefoot.mechanics.robot.dynamics import delassus_dense, mass_matrix
from surefoot.mechanics.terrain import FlatTerrain, Terrain, rough_ground
from surefoot.worlds.rigid.bodies import ball, box, falling_cat
from surefoot.worlds.rigid.rigid_world import RigidWorld


def thrown(height: float = 0.02, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    robot, rng = sf.load_robot("go2"), np.random.default_rng(seed)
    q = sf.place(robot)
    q[2] += height
    return q, 0.3 * rng.normal(size=18)


def same(a: object, b: object) -> bool:
    return np.array_equal(np.asarray(a), np.asarray(b))


@pytest.mark.parametrize("terrain", [sf.FlatTerrain(), rough_ground(1, 0.06)], ids=repr)
def test_steps_taken_twice_and_out_of_turn_are_the_same(terrain: Terrain) -> None:
    """Through the air, the touchdown and the rest, with steps of another state in between."""
    robot, rng = sf.load_robot("go2"), np.random.default_rng(1)
    stepper, other = Stepper(robot, terrain), Stepper(robot, terrain)
    states, torques = [stepper.start(*thrown(0.03))], rng.normal(size=(200, 12))
    steps = []
    for tau in torques:
        steps.append(stepper.step(states[-1], tau))
        states.append(steps[-1].state)
    assert any(step.problem is None for step in steps)
    assert sum(step.problem is not None for step in steps) > 20
    for k in rng.permutation(200):
        for again in (stepper.step(states[k], torques[k]), other.step(states[k], torques[k])):
            assert same(again.state.q, states[k + 1].q)
            assert same(again.state.v, states[k + 1].v)
            assert same(again.impulses, steps[k].impulses)
            assert same(again.velocities, steps[k].velocities)
            assert same(again.gaps, steps[k].gaps)


def test_a_world_is_a_run_of_steps() -> None:
    robot, options = sf.load_robot("go2"), StepOptions(dt=2e-3, restitution=0.2)
    world = RigidWorld(robot, sf.SlopeTerrain(10.0), 0.4, 2e-3, payload=1.0, restitution=0.2)
    stepper = Stepper(robot, sf.SlopeTerrain(10.0), options, payload=1.0)
    q, v = thrown(0.1)
    world.reset(q, v)
    state = stepper.start(q, v)
    push = np.array([0.0, 30.0, 0.0])
    for k in range(150):
        step = stepper.step(state, np.zeros(12), push if k > 50 else None, mu=0.4)
        world.step(np.zeros(12), push if k > 50 else None)
        state = step.state
        assert same(world.contacts().forces, step.forces)
        assert world.contact_work() == step.contact_work
        assert same(world.q_v()[1], state.v)
    assert same(world.q_v()[0], state.q)
    assert world.energy() == stepper.energy(state)
    assert world.time == pytest.approx(0.3)


def test_the_problem_of_a_step_is_that_of_its_impact() -> None:
    """G and g from Pinocchio at the middle of the step, and momentum's balance over the impulses."""
    robot, mu = sf.load_robot("go2"), 0.5
    stepper = Stepper(robot)
    state = stepper.start(sf.place(robot), np.r_[0.1, 0.05, -0.3, np.zeros(15)])
    for _ in range(5):
        step = stepper.step(state, np.zeros(12), mu=mu)
        state = step.state
    impact = step.impact
    assert impact is not None
    assert impact.rows is not None
    assert step.problem is not None
    near = impact.near
    whole = delassus_dense(robot, impact.q, robot.stance(impact.q, mu=mu))
    rows = (3 * near[:, None] + np.arange(3)).ravel()
    assert pytest.approx(whole[np.ix_(rows, rows)], rel=1e-8, abs=1e-12) == step.problem.G
    assert impact.rows @ impact.rows.T == pytest.approx(step.problem.G, rel=1e-12)
    assert (step.problem.mu == mu).all()
    J = stepper.contacts(stepper.start(impact.q)).J
    M = mass_matrix(robot, impact.q)
    assert M @ (impact.after - impact.free) == pytest.approx(J.T @ impact.impulses.ravel(), abs=1e-9)
    gravity = pinocchio.computeGeneralizedGravity(robot.model, robot.model.createData(), impact.q)
    assert M @ (impact.free - impact.before) == pytest.approx(-1e-3 * gravity, abs=1e-9)
    assert J @ impact.after == pytest.approx(impact.leaving.ravel(), abs=1e-12)


def test_a_start_elsewhere_forgets_what_does_not_belong_to_it() -> None:
    """An acceleration that a step left is for its own q and v; with others it is computed anew."""
    stepper = Stepper(sf.load_robot("go2"))
    state = stepper.start(*thrown(0.0))
    for _ in range(30):
        state = stepper.step(state, np.zeros(12)).state
    assert state.rate is not None
    moved = state._replace(v=2.0 * state.v)
    assert moved.rate is None
    assert state._replace(q=state.q.copy()).rate is None
    fresh = Stepper(stepper.robot).step(moved, np.zeros(12))
    assert same(stepper.step(moved, np.zeros(12)).state.q, fresh.state.q)


def test_a_lost_step_names_the_time_and_leaves_the_stepper_usable() -> None:
    stepper = Stepper(sf.load_robot("go2"))
    good = stepper.start(*thrown(0.0))
    expected = stepper.step(good, np.zeros(12))
    with pytest.raises(SimulationError, match="at 0 s the motion"):
        stepper.step(stepper.start(good.q, np.full(18, 1e7)), np.zeros(12))
    with pytest.raises(SimulationError, match=r"at 0\.007 s"):
        stepper.step(State(good.q, np.full(18, 1e7), 7), np.zeros(12))
    with pytest.raises(SimulationError, match="gap between feet and ground"):
        stepper.contacts(State(np.full(19, np.nan), good.v))
    with pytest.raises(sf.ProblemError, match="torques"):
        stepper.step(good, np.full(12, np.nan))
    with pytest.raises(sf.ProblemError, match="push"):
        stepper.step(good, np.zeros(12), np.zeros(2))
    assert same(stepper.step(good, np.zeros(12)).state.q, expected.state.q)


def test_friction_is_an_argument_of_the_step() -> None:
    robot, slope = sf.load_robot("go2"), sf.SlopeTerrain(20.0)
    stepper = Stepper(robot, slope)
    state = stepper.start(sf.place(robot, slope))
    for mu in (0.0, 0.1, 0.9):
        step = stepper.step(state, np.zeros(12), mu=mu)
        tangential = np.linalg.norm(step.forces[:, :2], axis=1)
        assert (tangential <= mu * step.forces[:, 2] + 1e-6).all()
        assert step.forces[:, 2].min() > 0.0
        assert (tangential > 0.0).all() == (mu > 0.0)


class Raised(FlatTerrain):
    """The plane z = 0.3."""

    def height(self, xy: object) -> np.ndarray:
        return np.full(np.shape(xy)[:-1], 0.3)


def test_a_plane_need_not_go_through_the_origin() -> None:
    body = box(rounding=0.01)
    low, high = Stepper(body), Stepper(body, Raised())
    v = np.array([0.3, 0.1, 0.0, 1.0, 0.0, 2.0])
    a = low.start(body.nominal, v)
    b = high.start(body.nominal + np.array([0, 0, 0.3, 0, 0, 0, 0]), v)
    for _ in range(200):
        a, b = low.step(a, np.zeros(0)).state, high.step(b, np.zeros(0)).state
    assert b.q[2] - a.q[2] == pytest.approx(0.3, abs=1e-9)
    assert b.v == pytest.approx(a.v, abs=1e-6)


@pytest.mark.parametrize("body", [ball(), box(), falling_cat()], ids=lambda b: b.name)
def test_bodies_with_one_many_and_no_contact_points(body: sf.Robot) -> None:
    stepper = Stepper(body)
    state = stepper.start()
    for _ in range(50):
        step = stepper.step(state, np.zeros(body.joints))
        state = step.state
    weight = sum(i.mass for i in body.model.inertias) * 9.81
    assert step.forces.shape == (len(body.contact_points), 3)
    if len(body.contact_points):
        assert step.forces[:, 2].sum() == pytest.approx(weight, rel=1e-6)
    else:
        assert step.problem is None
        assert state.v[2] == pytest.approx(-9.81 * 0.05)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"dt": 0.0}, "dt"),
        ({"dt": np.nan}, "dt"),
        ({"restitution": 1.5}, "restitution must be a number between 0 and 1"),
        ({"stabilisation": "hope"}, "unknown stabilisation 'hope'; valid names: baumgarte, none"),
        ({"law": "none"}, "unknown law 'none'"),
    ],
)
def test_options_are_checked(options: dict[str, object], message: str) -> None:
    with pytest.raises(sf.ProblemError, match=message):
        StepOptions(**options)  # type: ignore[arg-type]


def test_velocities_of_an_exchange_without_its_guess_are_means() -> None:
    """Two corners of a box were twice as fast in a log's row once: laws hold for the sum as for its half."""
    world = RigidWorld(box(1.0, (0.2, 0.1, 0.05), 0.01), mu=0.3, dt=0.002)
    for _ in range(20):
        world.step(np.zeros(0), np.array([8.0, 0.0, 0.0]))
    stepper, (q, v) = world.stepper, world.q_v()
    contacts, last = stepper.detect(q), world.last
    assert last is not None
    stepper.bodies.weigh(q)
    free, arriving = v - [0.0, 0.0, 9.81 * 0.002, 0.0, 0.0, 0.0], contacts.velocities(v)
    meeting = stepper.meeting(q, v, free, contacts, 0.002, 0.3, Tally())
    fast = arriving + np.array([3.0, 0.0, 1.0])  # as if they had left so: what changed since makes energy
    impact = meeting.collide(np.arange(len(contacts.gaps)), last.impulses, fast)
    pressed = last.impulses[:, 2] > 0.0
    assert impact.summed is not None
    assert pressed.any()
    assert not pressed.all()
    assert impact.summed.all()  # corners of one foot share the mean of those that were pressed
    shared = arriving[pressed].mean(axis=0)  # all frames of the floor are alike
    np.testing.assert_allclose(impact.means, 0.5 * (shared + impact.leaving), atol=1e-12)
