"""A step's derivative against central differences of the very step, block by block.

States are away from changes of mode; differences over 1e-6 are good to about 1e-7 of the largest entry.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio
import pytest

import surefoot as sf
from surefoot.base.errors import NoSolution
from surefoot.base.spatial import GRAVITY
from surefoot.laws import SpringDamper
from surefoot.mechanics.dynamics import Knot, State, Step, StepOptions, Stepper, step_derivative
from surefoot.mechanics.dynamics import free_motion as rules
from surefoot.mechanics.dynamics.state import StepRemainder
from surefoot.mechanics.terrain import Terrain
from surefoot.worlds.rigid.bodies import ball, box, falling_cat
from surefoot.worlds.rigid.rigid_world import RigidWorld
from tests.mechanics.dynamics.waves import ROUGH
from tests.moving import lifted

STEP, NEAR = 1e-6, 2e-6
EXACT = StepOptions(solver_tol=1e-12)


def outcome(stepper: Stepper, a: Step, b: Step) -> np.ndarray:
    """Difference b - a of q, v, impulses and what is left to the next step."""
    model = stepper.bodies.model
    left = 0.0 * a.impulses
    if a.impact is not None and a.state.memory is not None:
        left = b.state.memory.leaving - a.state.memory.leaving
    moved = pinocchio.difference(model, a.state.q, b.state.q)
    return np.concatenate([moved, b.state.v - a.state.v, (b.impulses - a.impulses).ravel(), left.ravel()])


def differences(stepper: Stepper, state: State, torques, push, mu, between=outcome) -> dict[str, np.ndarray]:
    """Differences, as `between` has them of two steps, by everything that goes in."""
    model, joints = stepper.bodies.model, stepper.robot.joints

    def taken(name: str, way: np.ndarray) -> Step:
        q = pinocchio.integrate(model, state.q, way) if name == "q" else state.q
        v = state.v + way if name == "v" else state.v
        memory = state.memory
        if name == "leaving" and memory is not None:
            memory = memory._replace(leaving=memory.leaving + way.reshape(-1, 3))
        return stepper.step(
            State(q, v, state.steps, memory), torques + (way if name == "torques" else 0.0),
            push + (way if name == "push" else 0.0), mu + (float(way[0]) if name == "mu" else 0.0),
        )  # fmt: skip

    sizes = {"q": model.nv, "v": model.nv, "torques": joints, "mu": 1, "push": 3,
             "leaving": 3 * len(stepper.bodies.contacts.group)}  # fmt: skip

    def slope(name: str, e: np.ndarray) -> np.ndarray:
        """Central differences over two widths, of fourth order together."""
        near, far = (
            between(stepper, taken(name, -w * e), taken(name, w * e)) / (2.0 * w) for w in (STEP, 2.0 * STEP)
        )
        return (4.0 * near - far) / 3.0

    return {name: np.array([slope(name, e) for e in np.eye(size)]).T for name, size in sizes.items() if size}


@pytest.fixture
def fine_motion(monkeypatch: pytest.MonkeyPatch) -> None:
    """Free motion to rounding: a difference over 1e-6 sees the choice of its pieces at 1e-8 as noise."""
    monkeypatch.setattr(rules, "TOLERANCE", 1e-14)


def check(stepper: Stepper, state: State, torques, push=None, mu=0.5, touching=False):
    """Compare all blocks; return the derivative."""
    push = np.array([3.0, -2.0, 1.0]) if push is None else push
    d = step_derivative(stepper, state, torques, push, mu)
    # which side of zero a gap comes out, and a projection solved to 1e-6, are worth some 1e-6
    near = 5.0 * NEAR if touching else NEAR
    assert d.kinks == ()
    assert touching or d.touching.size == 0
    wanted = differences(stepper, state, torques, push, mu)
    nv, rest = stepper.bodies.model.nv, 3 * len(stepper.bodies.contacts.group)
    for name, block in wanted.items():
        own = d._blocks[name]
        for rows in (
            slice(0, nv),
            slice(nv, 2 * nv),
            slice(2 * nv, 2 * nv + rest),
            slice(2 * nv + rest, None),
        ):
            if block[rows].size:
                scale = max(float(np.abs(block[rows]).max()), 0.1)  # below, rounding shows
                assert np.abs(own[rows] - block[rows]).max() < near * scale, name
    assert np.array_equal(d.A, np.hstack([d._blocks["q"], d._blocks["v"]])[: 2 * nv])
    return d


def go2_at(terrain: Terrain, height: float, seed: int, speed: float = 0.5):
    robot, rng = sf.load_robot("go2"), np.random.default_rng(seed)
    q = lifted(sf.place(robot, terrain), height)
    v = speed * rng.normal(size=18)
    v[2] -= 0.5
    return robot, q, v, 5.0 * rng.normal(size=12)


@pytest.mark.parametrize("terrain", [sf.FlatTerrain(), sf.SlopeTerrain(15.0), ROUGH], ids=repr)
@pytest.mark.parametrize("height", [2e-4, 0.1], ids=["impact", "air"])
def test_go2_landing_and_in_the_air(terrain: Terrain, height: float) -> None:
    robot, q, v, torques = go2_at(terrain, height, 0)
    stepper = Stepper(robot, terrain)
    d = check(stepper, stepper.start(q, v), torques, np.zeros(3) if height > 0.05 else None)
    assert (d.step.impact is not None) == (height < 0.05 or d.step.impact is not None)


@pytest.mark.usefixtures("fine_motion")
@pytest.mark.parametrize("terrain", [sf.FlatTerrain(), sf.SlopeTerrain(15.0), ROUGH], ids=repr)
@pytest.mark.parametrize("mu", [0.1, 3.0])
def test_go2_with_a_memory_slides_and_sticks(terrain: Terrain, mu: float) -> None:
    """Impulses before this step make a guess of the swerve; feet are 2e-5 to 1e-3 m above the ground."""
    robot, q, v, torques = go2_at(terrain, 3e-4, 1, 0.2)
    rng = np.random.default_rng(2)
    stepper = Stepper(robot, terrain, replace(EXACT, stabilisation="none"))
    impulses, seen = np.abs(rng.normal(size=(4, 3))), []
    for leaving in (rng.normal(size=(4, 3)), 0.01 * rng.normal(size=(4, 3))):
        state = State(q, v, 3, StepRemainder(impulses, leaving, False))
        d = check(stepper, state, torques, mu=mu)
        assert ("slide" if mu < 1.0 else "stick") in d.modes
        seen.append(np.abs(d.leaving).max() > 1e-4)
    assert any(seen)  # where the guess would make energy, another takes its place


@pytest.mark.usefixtures("fine_motion")
@pytest.mark.parametrize("options", [
    EXACT, replace(EXACT, restitution=0.5), replace(EXACT, law="convex"), replace(EXACT, dt=5e-3),
], ids=["rigid", "bounce", "convex", "long"])  # fmt: skip
@pytest.mark.parametrize("body", [ball(1.0, 0.1), box(rounding=0.01)], ids=["ball", "box"])
@pytest.mark.parametrize("speed", [-0.4, -0.9], ids=["in the step", "before its impulses"])
def test_bodies_hit_a_slope(body: sf.Robot, options: StepOptions, speed: float) -> None:
    rng = np.random.default_rng(2)
    stepper = Stepper(body, sf.SlopeTerrain(-5.0), options)
    turn = np.concatenate([np.zeros(3), 0.1 * rng.normal(size=3)])
    q = pinocchio.integrate(body.model, body.nominal, turn)
    for _ in range(3):
        q[2] += 0.3 * options.dt - stepper.contacts(stepper.start(q)).gaps.min()
    v = 0.4 * rng.normal(size=6)
    v[:3] = stepper.bodies.data.oMi[1].rotation.T @ [0.3, 0.1, speed]
    v[3:] *= 0.2
    state = stepper.start(q, v)
    d = check(stepper, state, np.zeros(0), mu=0.3, touching=speed < -0.5)
    assert d.step.forces[:, 2].max() > 0.0
    assert (d._stages.arrival is not None) == (speed < -0.5)


@pytest.mark.usefixtures("fine_motion")
@pytest.mark.parametrize(
    ("stabilisation", "gap"), [("none", 3e-4), ("none", -2e-5), ("projection", -2e-5), ("baumgarte", -2e-5)]
)
@pytest.mark.parametrize("mu", [0.05, 5.0], ids=["slide", "stick"])
def test_a_sphere_on_curved_ground(mu: float, stabilisation: str, gap: float) -> None:
    """Normals and frames turn below the centre; in the ground, projection and Baumgarte's term act."""
    body = ball(2.0, 0.2)
    stepper = Stepper(body, ROUGH, replace(EXACT, stabilisation=stabilisation))
    q = body.nominal.copy()
    q[:2] = 0.13, -0.21
    for _ in range(5):
        q[2] += gap - stepper.contacts(stepper.start(q)).gaps[0]
    state = stepper.start(q, np.array([0.4, -0.2, -0.4, 1.0, -2.0, -0.5]))
    d = check(stepper, state, np.zeros(0), mu=mu, touching=stabilisation == "projection")
    assert d.modes == (("slide",) if mu < 1.0 else ("stick",))
    assert len(d._stages.projections) == (stabilisation == "projection")


def test_g1_lands_on_both_soles() -> None:
    """Eight corners are redundant: q and v have derivatives where single forces have none."""
    robot = sf.load_robot("g1")
    stepper = Stepper(robot)
    rng = np.random.default_rng(3)
    q = lifted(sf.place(robot), 3e-4)
    v = np.zeros(robot.model.nv)
    v[:3] = 0.02, 0.01, -0.35
    torques = rng.normal(size=robot.joints)
    state = stepper.start(q, v)
    d = step_derivative(stepper, state, torques, mu=0.8)
    nv = robot.model.nv
    wanted = differences(stepper, state, torques, np.zeros(3), 0.8)
    for name in ("q", "v", "torques"):
        block, own = wanted[name][: 2 * nv], d._blocks[name][: 2 * nv]
        assert np.abs(own - block).max() < 1e-4 * np.abs(block).max(), name


@pytest.mark.usefixtures("fine_motion")
@pytest.mark.parametrize(("height", "order"), [(2e-4, 2), (0.3, 2), (2e-4, 1)])
def test_inertial_parameters(height: float, order: int) -> None:
    """Mass, its moments and inertia of single bodies, against robots that have others."""
    robot, q, v, torques = go2_at(sf.FlatTerrain(), height, 4)
    options = replace(EXACT, order=order)
    stepper = Stepper(robot, options=options)
    state = stepper.start(q, v)
    d = step_derivative(stepper, state, torques, mu=0.5)
    assert d.inertia.shape == (36, 13, 10)
    kept = [pinocchio.Inertia(i) for i in robot.model.inertias]
    for body, parameter in ((0, 0), (0, 2), (0, 4), (2, 0), (5, 1), (5, 9), (12, 0)):
        ends = []
        for sign in (-1.0, 1.0):
            pi = kept[body + 1].toDynamicParameters()
            pi[parameter] += sign * STEP
            other = Stepper(robot, options=options)
            for model in (other.bodies.model, other.bodies.flight.model, other.bodies.coasting.model):
                model.inertias[body + 1] = pinocchio.Inertia.FromDynamicParameters(pi)
            ends.append(other.step(state, torques, mu=0.5))
        wanted = outcome(stepper, *ends) / (2.0 * STEP)
        own = d._inertia.reshape(len(wanted), 13, 10)[:, body, parameter]
        # a first-order step leaves nothing to the next
        for rows in (slice(0, 36), slice(36, None if order == 2 else 48)):
            assert np.abs(own[rows] - wanted[rows]).max() < 1e-5 * max(np.abs(wanted[rows]).max(), 1e-3)


@pytest.mark.parametrize("order", [1, 2])
def test_products_are_adjoint_and_agree_with_the_blocks(order: int) -> None:
    robot, q, v, torques = go2_at(sf.FlatTerrain(), 2e-4, 0)
    stepper, rng = Stepper(robot, options=StepOptions(order=order)), np.random.default_rng(5)
    state = stepper.step(stepper.start(q, v), torques, mu=0.5).state
    d = step_derivative(stepper, state, torques, mu=0.5)
    given = {"q": rng.normal(size=18), "v": rng.normal(size=18), "torques": rng.normal(size=12), "mu": 0.3,
             "push": rng.normal(size=3), "inertia": rng.normal(size=(13, 10)),
             "leaving": rng.normal(size=(4, 3))}  # fmt: skip
    weights = {"q": rng.normal(size=18), "v": rng.normal(size=18), "forces": rng.normal(size=(4, 3)),
               "leaving": rng.normal(size=(4, 3))}  # fmt: skip
    ahead, back = d.jvp(**given), d.vjp(**weights)
    one = sum(float(np.sum(w * getattr(ahead, name))) for name, w in weights.items())
    other = sum(float(np.sum(w * getattr(back, name))) for name, w in given.items())
    assert one == pytest.approx(other, rel=1e-11)
    plain = d.jvp(q=given["q"], torques=given["torques"])
    assert np.r_[plain.q, plain.v] == pytest.approx(d.A[:, :18] @ given["q"] + d.B @ given["torques"])
    assert plain.forces.ravel() == pytest.approx(
        d.forces["q"] @ given["q"] + d.forces["torques"] @ given["torques"]
    )
    assert (d.vjp(q=weights["q"], inertia=False).inertia == 0.0).all()


def test_a_run_of_steps_passes_on_what_they_leave() -> None:
    """Ten steps of a sliding ball against differences of the run: q, v and leaving are passed on."""
    body = ball()
    stepper = Stepper(body, sf.SlopeTerrain(3.0), StepOptions(stabilisation="none"))
    start = stepper.start(
        stepper.robot.nominal + np.array([0, 0, 2e-3, 0, 0, 0, 0]), np.array([1.0, 0.3, -1.0, 2.0, 1.0, 0.5])
    )

    def run(q, v, mu=0.2):
        state = State(q, v)
        for _ in range(10):
            state = stepper.step(state, np.zeros(0), mu=mu).state
        return state

    way = np.random.default_rng(6).normal(size=12)
    state, dq, dv, left = start, way[:6], way[6:], None
    for _ in range(10):
        d = step_derivative(stepper, state, np.zeros(0), mu=0.2)
        out = d.jvp(dq, dv, mu=1.0, leaving=left)
        dq, dv, left, state = out.q, out.v, out.leaving, d.step.state
    ends = [
        run(pinocchio.integrate(body.model, start.q, w * way[:6]), start.v + w * way[6:], 0.2 + w)
        for w in (-STEP, STEP)
    ]
    assert d.modes == ("slide",)
    wanted = (ends[1].v - ends[0].v) / (2.0 * STEP)
    assert dv == pytest.approx(wanted, abs=1e-5 * np.abs(wanted).max())
    moved = pinocchio.difference(stepper.bodies.model, ends[0].q, ends[1].q) / (2.0 * STEP)
    assert dq == pytest.approx(moved, abs=1e-5 * np.abs(moved).max())


def test_touching_contacts_are_one_sided() -> None:
    """A ball that lies: lifted it is put back by the step, pressed in it is not."""
    body = ball()
    stepper = Stepper(body, options=StepOptions(stabilisation="none"))
    state = stepper.start(body.nominal)
    d = step_derivative(stepper, state, np.zeros(0), mu=0.5)
    assert d.touching.tolist() == [0]
    for sign in (1.0, -1.0):
        way = np.r_[0.0, 0.0, sign, np.zeros(3)]
        moved = State(pinocchio.integrate(body.model, state.q, 1e-7 * way), state.v)
        wanted = outcome(stepper, d.step, stepper.step(moved, np.zeros(0), mu=0.5))[:12] / 1e-7
        ahead = d.jvp(q=way)
        assert np.r_[ahead.q, ahead.v] == pytest.approx(wanted, abs=1e-3)
    for stabilisation, touching in (("none", [0]), ("projection", [])):
        first = Stepper(body, options=StepOptions(order=1, stabilisation=stabilisation))
        assert step_derivative(first, state, np.zeros(0), mu=0.5).touching.tolist() == touching


@pytest.mark.parametrize("order", [1, 2])
def test_smoothing_reaches_a_ball_above_the_ground(order: int) -> None:
    """Against the root of λ (v + λ/m - g dt + gap/dt) = κ, straight above a plane."""
    m, height, kappa, dt = 2.0, 0.03, 1e-3, 1e-3
    body = ball(m, 0.1)
    stepper = Stepper(body, options=StepOptions(order=order))
    q = lifted(body.nominal, height)
    state, speed = stepper.start(q, np.r_[0.0, 0.0, -0.4, np.zeros(3)]), -0.4
    assert step_derivative(stepper, state, np.zeros(0), mu=0.0).forces["q"].any() == np.False_
    d = step_derivative(stepper, state, np.zeros(0), mu=0.0, smoothing=kappa)

    def impulse(z: float) -> float:
        free = speed - GRAVITY * dt + (z + 0.5 * (order - 1) * dt * speed) / dt
        return 2.0 * kappa / (np.sqrt(free**2 + 4.0 * kappa / m) + free)

    slope = (impulse(height + 1e-7) - impulse(height - 1e-7)) / 2e-7
    assert d.modes == ("smooth",)
    assert slope < 0.0
    assert d.forces["q"][2, 2] * dt == pytest.approx(slope, rel=1e-6)
    assert d.A[8, 2] == pytest.approx(slope / m, rel=1e-6)
    if order == 1:  # what the compiled pipeline fills is the same
        knot = Knot(stepper)
        step = knot.step(q, state.v, np.zeros(0), 0.0)
        assert step.solved
        assert knot.derivative(step, kappa).A[8, 2] == pytest.approx(slope / m, rel=1e-6)


def test_smoothing_of_a_standing_robot_is_near_the_derivative_itself() -> None:
    robot, q, v, torques = go2_at(sf.FlatTerrain(), 2e-4, 0)
    stepper = Stepper(robot)
    state = stepper.start(q, v)
    exact = step_derivative(stepper, state, torques, mu=0.5).A
    off = [
        np.abs(step_derivative(stepper, state, torques, mu=0.5, smoothing=k).A - exact).max()
        for k in (1e-5, 1e-7)
    ]
    assert off[1] < 0.1 * off[0]


def test_a_world_differentiates_its_last_step() -> None:
    robot, q, v, torques = go2_at(sf.FlatTerrain(), 2e-4, 0)
    world = RigidWorld(robot, mu=0.5)
    world.reset(q, v)
    with pytest.raises(sf.ProblemError, match="no step"):
        world.derivative()
    before = world.stepper.start(q, v)
    world.step(torques)
    d = world.derivative()
    assert np.array_equal(d.A, step_derivative(world.stepper, before, torques, mu=0.5).A)
    world.step(torques)
    assert np.array_equal(world.derivative().step.state.q, world.q_v()[0])


def test_wrong_arguments_are_named() -> None:
    robot = sf.load_robot("go2")
    stepper = Stepper(robot, options=StepOptions(solver_tol=1e-300))
    state = stepper.start(*go2_at(sf.FlatTerrain(), 2e-4, 0)[1:3])
    with pytest.raises(NoSolution):
        step_derivative(stepper, state, np.zeros(12)).A  # noqa: B018
    soft = Stepper(robot, options=StepOptions(law=SpringDamper(2e4, 100.0)))
    with pytest.raises(sf.ProblemError, match="a step with a SpringDamper"):
        step_derivative(soft, state, np.zeros(12), smoothing=1e-3)
    stepper = Stepper(robot)
    with pytest.raises(sf.ProblemError, match="torques"):
        step_derivative(stepper, state, np.zeros(3))
    with pytest.raises(sf.ProblemError, match="smoothing"):
        step_derivative(stepper, state, np.zeros(12), smoothing=-1.0)
    d = step_derivative(stepper, state, np.zeros(12))
    with pytest.raises(sf.ProblemError, match="leaving"):
        d.jvp(leaving=np.zeros(3))
    with pytest.raises(sf.ProblemError, match="forces"):
        d.vjp(forces=np.full((4, 3), np.nan))


def paired_arms() -> sf.Robot:
    """Three bodies on a ball joint and a hinge, without contact points."""
    model = pinocchio.Model()
    place = pinocchio.SE3(np.eye(3), np.array([0.1, 0.0, 0.2]))
    body = pinocchio.Inertia(1.0, np.array([0.0, 0.05, 0.1]), np.diag([0.01, 0.02, 0.025]))
    joints = (pinocchio.JointModelFreeFlyer(), pinocchio.JointModelSpherical(), pinocchio.JointModelRX())
    for k, joint in enumerate(joints):
        model.appendBodyToJoint(model.addJoint(k, joint, place, f"j{k}"), body, place)
    empty = pinocchio.GeometryModel()
    return sf.Robot("arms", model, empty, empty, (), np.array(pinocchio.neutral(model)), True)


@pytest.mark.usefixtures("fine_motion")
def test_a_body_without_contact_points_and_with_a_ball_joint() -> None:
    arms = paired_arms()
    stepper = Stepper(arms)
    state = stepper.start(v=2.0 * np.random.default_rng(0).normal(size=arms.model.nv))
    d = check(stepper, state, np.random.default_rng(1).normal(size=arms.joints), np.zeros(3))
    assert d.modes == ()


def test_joints_out_of_order_are_refused() -> None:
    """The cat's front legs lie between its spine and what that carries: Pinocchio's derivatives are wrong."""
    stepper = Stepper(falling_cat())
    with pytest.raises(sf.ProblemError, match="what joint twist carries"):
        step_derivative(stepper, stepper.start(), np.zeros(5))
