"""First-order steps and their derivative: against differences, Pinocchio, the exact step, and the laws.

Differences of fourth order over 1e-6 are good to about 1e-8 of a block's largest entry where that is above 1;
the problems are solved to 1e-13, because their derivative is taken at the forces as solved.
"""

from __future__ import annotations

import copy
from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio
import pytest

import surefoot as sf
from surefoot.base.errors import NoSolution, SimulationError
from surefoot.base.spatial import GRAVITY
from surefoot.laws import SpringDamper
from surefoot.mechanics.dynamics import Knot, MomentumKnot, State, Step, StepOptions, Stepper, step_derivative
from surefoot.mechanics.robot.jacobians import attach
from surefoot.mechanics.terrain import Terrain
from surefoot.worlds.rigid.bodies import ball, box, falling_cat
from surefoot.worlds.rigid.rigid_world import RigidWorld
from tests.mechanics.dynamics.test_derivative import differences, paired_arms
from tests.mechanics.dynamics.waves import ROUGH
from tests.mechanics.robot.constraints import constraints
from tests.moving import lifted

STEP, NEAR, CURVED = 1e-6, 1e-6, 1e-5
"""Over curved ground the rates of its normals are differences themselves, over 1e-5 m."""
OPTIONS = StepOptions(order=1, solver_tol=1e-13)
PUSH = np.array([3.0, -2.0, 1.0])


def outcome(stepper: Stepper, a: Step, b: Step) -> np.ndarray:
    """Difference b - a of q, v and forces."""
    moved = pinocchio.difference(stepper.bodies.model, a.state.q, b.state.q)
    return np.concatenate([moved, b.state.v - a.state.v, (b.forces - a.forces).ravel()])


def scene(name: str, terrain: Terrain, height: float, seed: int, speed: float = 0.4):
    """A robot with its lowest contact point at a height over the ground, moving down."""
    rng = np.random.default_rng(seed)
    robot = {"box": lambda: box(rounding=0.01), "ball": ball}.get(name, lambda: sf.load_robot(name))()
    stepper = Stepper(robot, terrain, OPTIONS)
    turn = np.concatenate([np.zeros(3), 0.03 * rng.normal(size=robot.model.nv - 3)])
    q = pinocchio.integrate(robot.model, robot.nominal, turn)
    for _ in range(4):
        q[2] += height - stepper.contacts(stepper.start(q)).gaps.min()
    v = speed * rng.normal(size=robot.model.nv)
    v[2] -= 0.5
    return robot, q, v, 3.0 * rng.normal(size=robot.joints)


CASES = [
    ("go2", sf.FlatTerrain(), 3e-4, 0.1, {}),
    ("go2", sf.FlatTerrain(), -1e-4, 3.0, {}),
    ("go2", sf.SlopeTerrain(15.0), 3e-4, 0.1, {"restitution": 0.5}),
    ("go2", sf.SlopeTerrain(15.0), 3e-4, 3.0, {"dt": 0.02}),
    ("go2", ROUGH, 3e-4, 0.3, {"restitution": 0.5}),
    ("go2", ROUGH, -2e-5, 2.0, {"stabilisation": "baumgarte"}),
    ("go2", sf.FlatTerrain(), 0.3, 0.6, {}),
    ("g1", sf.FlatTerrain(), 2e-4, 0.2, {}),
    ("g1", sf.SlopeTerrain(10.0), 2e-4, 2.0, {"dt": 0.01}),
    ("box", sf.SlopeTerrain(-5.0), 2e-4, 0.2, {}),
    ("box", sf.SlopeTerrain(-5.0), 2e-4, 2.0, {"law": "convex"}),
    ("ball", ROUGH, 2e-4, 0.1, {"stabilisation": "none"}),
]


@pytest.mark.parametrize(("name", "terrain", "height", "mu", "changes"), CASES)
@pytest.mark.sampled(3)
def test_blocks_are_those_of_differences_and_of_the_knot(name, terrain, height, mu, changes) -> None:
    seen: set[str] = set()
    near = NEAR if terrain.planar else CURVED
    for seed in range(3):
        robot, q, v, torques = scene(name, terrain, height, seed)
        stepper = Stepper(robot, terrain, replace(OPTIONS, **changes))
        state = stepper.start(q, v)
        d = step_derivative(stepper, state, torques, PUSH, mu)
        assert d.kinks == ()
        wanted, n = differences(stepper, state, torques, PUSH, mu, outcome), robot.model.nv
        for key, block in wanted.items():
            own = np.vstack([d._blocks[key][: 2 * n], d.forces[key]])
            for rows in (slice(0, n), slice(n, 2 * n), slice(2 * n, None)):
                scale = max(float(np.abs(block[rows]).max(initial=0.0)), 1.0)
                assert np.abs(own[rows] - block[rows]).max(initial=0.0) < near * scale, (seed, key, rows)
        # what the compiled pipeline fills is the same
        knot, seen = Knot(stepper), seen | set(d.modes)
        d = step_derivative(stepper, state, torques, 0.0 * PUSH, mu)  # a pushed step locates no impact
        step = knot.step(q, v, torques, mu)
        assert step.solved
        A, B, by_mu = knot.derivative(step)
        assert pytest.approx(A, abs=1e-11 * np.abs(A).max()) == d.A
        assert pytest.approx(B, abs=1e-11) == d.B
        assert by_mu == pytest.approx(d.mu, abs=1e-10)
        assert step.q == pytest.approx(d.step.state.q, abs=1e-12)
        assert step.v == pytest.approx(d.step.state.v, abs=1e-10)
        assert step.impulses == pytest.approx(d.step.impulses, abs=1e-10)
    assert height > 0.1 or seen & {"stick", "slide"}


def pointed(name: str) -> sf.Robot:
    """A robot whose contact spheres have no radius: contact points fixed to bodies, as Pinocchio's are."""
    robot = sf.load_robot(name)
    robot.feet = tuple(replace(foot, radius=0.0) for foot in robot.feet)
    return robot


def test_where_all_feet_stick_it_is_pinocchios_constrained_dynamics() -> None:
    """At rest on the ground, without stabilisation: v⁺ = dt a, and the projection by v is the ground's."""
    robot = pointed("go2")
    dt, nv = 1e-3, 18
    stepper = Stepper(robot, options=replace(OPTIONS, dt=dt, stabilisation="none"))
    q = np.array(sf.place(robot))
    for _ in range(3):
        q[2] -= stepper.contacts(stepper.start(q)).gaps.max() + 1e-9
    v, share = np.zeros(nv), np.tile([0.0, 0.0, 0.25 * robot.mass * GRAVITY], 4)
    held = pinocchio.computeGeneralizedGravity(robot.model, robot.data, q)
    torques = (held - stepper.contacts(stepper.start(q)).J.T @ share)[6:]
    torques += 0.3 * np.random.default_rng(0).normal(size=12)
    d = step_derivative(stepper, stepper.start(q), torques, mu=5.0)
    assert d.modes == ("stick",) * 4
    data, models, datas = constraints(robot, q, attach(robot, q, robot.stance(q, mu=5.0)))
    pinocchio.initConstraintDynamics(robot.model, data, models, datas)
    settings = pinocchio.ProximalSettings(1e-13, 0.0, 1)
    tau = np.concatenate([np.zeros(6), torques])
    a = np.array(pinocchio.constraintDynamics(robot.model, data, q, v, tau, models, datas, settings))
    pinocchio.computeConstraintDynamicsDerivatives(robot.model, data, models, datas, settings)
    assert d.step.state.v == pytest.approx(dt * a, abs=1e-10 * np.abs(a).max())
    low = d.A[nv:]
    assert low[:, :nv] == pytest.approx(dt * data.ddq_dq, abs=1e-7 * np.abs(data.ddq_dq).max())
    assert d.B[nv:] == pytest.approx(dt * np.array(data.ddq_dtau)[:, 6:], abs=1e-10)
    J = stepper.contacts(stepper.start(q)).J
    M = np.triu(pinocchio.crba(robot.model, robot.data, q))
    M = M + np.triu(M, 1).T
    W = np.linalg.solve(M, J.T)
    held = np.eye(nv) - W @ np.linalg.solve(J @ W, J)
    assert low[:, nv:] == pytest.approx(held + dt * data.ddq_dv, abs=1e-9)


def test_it_converges_to_the_exact_step_with_order_one() -> None:
    """A rolling, sliding ball and a falling, turning robot: half the step, half the error."""
    errors = []
    ramp = sf.SlopeTerrain(8.0)
    for body, terrain, v in (
        (ball(), ramp, np.array([1.0, 0.3, 0.0, 2.0, 1.0, 0.5])),
        (sf.load_robot("go2"), sf.FlatTerrain(), np.linspace(-1.0, 1.0, 18)),
    ):
        q = body.nominal.copy()
        exact = Stepper(body, terrain, StepOptions(dt=1e-4))
        for _ in range(3):
            q[2] -= exact.contacts(exact.start(q)).gaps.min()
        q[2] += 0.3 if body.joints else 0.0

        def after(stepper: Stepper, q=q, v=v) -> State:
            state = stepper.start(q, v)
            for _ in range(round(0.04 / stepper.options.dt)):
                state = stepper.step(state, np.zeros(stepper.robot.joints), mu=0.05).state
            return state

        best = after(exact)
        for dt in (4e-3, 2e-3, 1e-3):
            end = after(Stepper(body, terrain, StepOptions(dt=dt, order=1)))
            gap = pinocchio.difference(body.model, best.q, end.q)
            errors.append(float(np.linalg.norm(np.concatenate([gap, end.v - best.v]))))
    ratios = np.array(errors).reshape(2, 3)
    assert ratios[:, :-1] / ratios[:, 1:] == pytest.approx(2.0, abs=0.25)


def test_forces_of_a_fall_are_lawful() -> None:
    """Signorini for the gaps at the end, Coulomb and dissipation, read off one by one."""
    robot = sf.load_robot("go2")
    world = RigidWorld(robot, mu=0.4, order=1)
    q = lifted(sf.place(robot), 0.05)
    world.reset(q, np.r_[0.5, 0.2, 0.0, np.zeros(15)])
    touched = 0
    for _ in range(300):
        world.step(np.zeros(12))
        step = world.last
        f, u = step.impulses, step.velocities
        ahead = step.gaps + world.dt * u[:, 2]
        unit = np.abs(u).max() * max(float(np.abs(f).max()), 1e-3)
        assert step.unsolved == 0
        assert ahead.min() > -1e-8
        assert f[:, 2].min() >= 0.0
        assert (f[:, 2] * ahead / world.dt).max() <= 1e-7 * unit
        slip = np.hypot(u[:, 0], u[:, 1])
        assert (np.hypot(f[:, 0], f[:, 1]) - 0.4 * f[:, 2]).max() < 1e-8
        assert (0.4 * f[:, 2] * slip + (f[:, :2] * u[:, :2]).sum(axis=1)).max() <= 1e-7 * unit
        touched += int(f[:, 2].max() > 0.0)
    assert touched > 150
    assert world.worst_residual < 1e-8


@pytest.mark.parametrize("law", ["coulomb", "convex"])
@pytest.mark.parametrize("height", [3e-4, 0.05])
def test_smoothing_is_the_slope_of_the_central_path(law: str, height: float) -> None:
    robot, q, v, torques = scene("go2", sf.SlopeTerrain(10.0), height, 2)
    knot = Knot(Stepper(robot, sf.SlopeTerrain(10.0), replace(OPTIONS, law=law)))
    step = knot.step(q, v, torques, 0.5)
    exact, off = knot.derivative(step).A, []
    for kappa in (1e-2, 1e-4, 1e-7):
        A, B, _ = knot.derivative(step, kappa)
        off.append(np.abs(A - exact).max())
        if kappa < 1e-4:
            continue
        for k, way in enumerate(np.random.default_rng(3).normal(size=(3, 48))):
            ends = [
                speed_on_path(knot, pinocchio.integrate(robot.model, q, w * way[:18]), v + w * way[18:36],
                              torques + w * way[36:], kappa)
                for w in (-STEP, STEP)
            ]  # fmt: skip
            wanted, found = (ends[1] - ends[0]) / (2.0 * STEP), A[18:] @ way[:36] + B[18:] @ way[36:]
            assert found == pytest.approx(wanted, abs=1e-4 * np.abs(wanted).max()), k
    assert off[0] > off[1] > off[2]
    assert off[2] < 1e-2 * off[0]


def speed_on_path(knot: Knot, q: np.ndarray, v: np.ndarray, torques: np.ndarray, kappa: float) -> np.ndarray:
    """Return the velocity that a step has on the central path."""
    step = knot.step(q, v, torques, 0.5)
    assert step.solved
    return knot._exchange_on_path(step, kappa)[-1]


def test_outputs_are_the_callers_and_a_step_depends_on_its_arguments_alone() -> None:
    robot, q, v, torques = scene("go2", ROUGH, 3e-4, 0)
    stepper = Stepper(robot, ROUGH, OPTIONS)
    knot, A, B = Knot(stepper), np.full((36, 36), np.nan), np.full((36, 12), np.nan)
    place, speed = q.copy(), v.copy()
    step = knot.step(place, speed, torques)
    assert step.solved
    place[:], speed[:] = robot.nominal, 0.0  # the caller goes on in place
    stepper.step(stepper.start(robot.nominal), torques)  # the knot keeps its own arrays
    found = knot.derivative(step, out=(A, B))
    assert found.A is A
    assert found.B is B
    first = A.copy()
    knot.derivative(knot.step(robot.nominal, v, 0.0 * torques, 0.3), 1e-3)
    assert np.array_equal(knot.derivative(knot.step(q, v, torques)).A, first)


@pytest.mark.parametrize("kind", [Knot, MomentumKnot])
@pytest.mark.parametrize("terrain", [sf.SlopeTerrain(10.0), ROUGH])
def test_a_step_is_a_value(kind: type[Knot], terrain: sf.Terrain) -> None:
    """What a knot does later changes no step, and any knot of the same robot differentiates it alike."""
    robot, q, v, torques = scene("go2", terrain, 3e-4, 0)
    knot, other = (kind(Stepper(robot, terrain, OPTIONS)) for _ in range(2))
    step = knot.step(q, v, torques, 0.5)
    kept, wanted = copy.deepcopy(step), [knot.derivative(step, kappa) for kappa in (0.0, 1e-3)]
    rates = knot.contact_rates(step)
    later = knot.step(robot.nominal, -v, 0.0 * torques, 0.3)
    knot.derivative(later, 1e-2)
    assert same(step, kept)
    for who in (knot, other):
        assert same([who.derivative(step, kappa) for kappa in (0.0, 1e-3)], wanted)
        assert np.array_equal(who.contact_rates(step), rates)


def same(one: Any, other: Any) -> bool:
    """Return whether values are equal to the last bit, arrays in tuples included."""
    if isinstance(one, tuple | list):
        return len(one) == len(other) and all(map(same, one, other))
    return np.array_equal(one, other)


def test_other_solvers_and_lost_motion() -> None:
    robot, q, v, torques = scene("go2", sf.FlatTerrain(), 3e-4, 0)
    knot = Knot(Stepper(robot, options=OPTIONS))
    other = Knot(Stepper(robot, options=replace(OPTIONS, solver="nsgs", solver_tol=1e-10)))
    step, far = (one.step(q, v, torques) for one in (knot, other))
    assert step.solved
    assert far.solved
    assert far.v == pytest.approx(step.v, abs=1e-7)
    assert pytest.approx(knot.derivative(step).A, abs=1e-4) == other.derivative(far).A
    lost = knot.step(q, np.full(18, 1e200), torques)
    assert not lost.solved
    assert np.isnan(lost.v).all()
    with pytest.raises(NoSolution):
        knot.derivative(lost)
    with pytest.raises(SimulationError):
        step_derivative(knot.stepper, State(q, np.full(18, 1e200)), torques)
    unsolved = Stepper(robot, options=replace(OPTIONS, solver_tol=1e-300))
    assert not Knot(unsolved).step(q, v, torques).solved
    with pytest.raises(NoSolution):
        step_derivative(unsolved, unsolved.start(q, v), torques)


def test_wrong_arguments_are_named() -> None:
    robot = sf.load_robot("go2")
    with pytest.raises(sf.ProblemError, match="order must be 1 or 2, got 3"):
        StepOptions(order=3)
    with pytest.raises(sf.ProblemError, match="got a SpringDamper"):
        StepOptions(order=1, law=SpringDamper(2e4, 100.0))
    with pytest.raises(sf.ProblemError, match="order=1 is of feet on the ground"):
        RigidWorld(robot, order=1, collision="full")
    with pytest.raises(sf.ProblemError, match="got order=2"):
        Knot(Stepper(robot))
    with pytest.raises(sf.ProblemError, match="what joint twist carries"):
        Knot(Stepper(falling_cat(), options=OPTIONS))
    knot = Knot(Stepper(robot, options=OPTIONS))
    q = sf.place(robot)
    for arguments, name in (
        ((q[:3], np.zeros(18), np.zeros(12)), "q"),
        ((q, np.full(18, np.nan), np.zeros(12)), "v"),
        ((q, np.zeros(18), np.zeros(3)), "torques"),
        ((q, np.zeros(18), np.zeros(12), -1.0), "mu"),
    ):
        with pytest.raises(sf.ProblemError, match=name):
            knot.step(*arguments)
    step = knot.step(q, np.zeros(18), np.zeros(12))
    with pytest.raises(sf.ProblemError, match="A of out"):
        knot.derivative(step, out=(np.empty((36, 36)).T, np.empty((36, 12))))
    with pytest.raises(sf.ProblemError, match="smoothing"):
        knot.derivative(step, -1.0)


def test_bodies_without_joints_or_contact_points() -> None:
    arms = paired_arms()
    stepper = Stepper(arms, options=OPTIONS)
    state = stepper.start(v=2.0 * np.random.default_rng(0).normal(size=arms.model.nv))
    torques = np.random.default_rng(1).normal(size=arms.joints)
    d = step_derivative(stepper, state, torques, np.zeros(3))
    wanted = differences(stepper, state, torques, np.zeros(3), 0.6, outcome)
    assert d.modes == ()
    assert pytest.approx(np.hstack([wanted["q"], wanted["v"]]), abs=1e-7) == d.A
    assert pytest.approx(wanted["torques"], abs=1e-7) == d.B
