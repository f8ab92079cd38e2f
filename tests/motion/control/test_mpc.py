"""`ConvexMpc` as a controller: cones and schedules at all times, warm starts, frames, bad input."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.problems.walking import TICK, choose_scenes, controller, record
from benchmarks.walk.horizon import horizon_program
from surefoot.base.errors import ProblemError
from surefoot.base.spatial import rotation_about, rotation_from_normal
from surefoot.contact.solution import Status
from surefoot.motion.control.mpc import BodyReference, BodyState, ConvexMpc, MpcWeights

FEET = np.array([[0.2, 0.14, 0.0], [0.2, -0.14, 0.0], [-0.2, 0.14, 0.0], [-0.2, -0.14, 0.0]])
TROT = np.array([[1, 0, 0, 1]] * 5 + [[0, 1, 1, 0]] * 5, dtype=bool)
INERTIA = np.diag([0.1, 0.25, 0.3])


def make(**changes):
    values = {"mu": 0.6, "normal_min": 3.0, "normal_max": 200.0, **changes}
    return ConvexMpc(15.0, INERTIA, **values)


def state_off(position=(0, 0, 0), velocity=(0, 0, 0), turn=(0, 0, 0), spin=(0, 0, 0)):
    angle = float(np.linalg.norm(turn))
    rotation = rotation_about(np.array(turn) / angle, angle) if angle > 0.0 else np.eye(3)
    return BodyState(
        rotation, np.array([0, 0, 0.3]) + position, np.array(velocity, float), np.array(spin, float)
    )


def reference(**changes):
    return BodyReference.cruise([0, 0, 0.3], **{"yaw": 0.0, **changes})


def assert_inside(plan, mpc, schedule, mu=0.6, low=3.0, high=200.0):
    f = plan.forces
    assert np.isfinite(f).all()
    assert (f[~schedule] == 0.0).all()  # swing feet carry exactly nothing
    on = f[schedule]
    sideways = np.linalg.norm(on[:, :2], axis=1)
    assert (sideways <= mu * on[:, 2] * (1.0 + 1e-12)).all()
    assert ((on[:, 2] >= low) & (on[:, 2] <= high)).all()
    for part in (plan.position, plan.linear_velocity, plan.angular_velocity, plan.orientation_error):
        assert np.isfinite(part).all()


anything = st.tuples(*[st.floats(-1.0, 1.0)] * 12)


@settings(max_examples=120, deadline=None, derandomize=True)
@given(where=anything, size=st.sampled_from([0.1, 1.0, 30.0, 1e4]), seed=st.integers(0, 99))
def test_forces_stay_inside_whatever_the_state(where, size, seed):
    p, v, r, w = (size * np.array(where[i : i + 3]) for i in range(0, 12, 3))
    schedule = np.random.default_rng(seed).random((10, 4)) < 0.5
    mpc = make(max_iterations=30)
    plan = mpc.solve(state_off(p, v, r, w), reference(velocity=(0.5, 0)), FEET, schedule)
    assert_inside(plan, mpc, schedule)
    assert plan.status in (Status.SOLVED, Status.ALMOST, Status.MAX_ITERATIONS, Status.STALLED)
    assert plan.solved == (plan.error <= mpc.tol)


def test_feet_in_swing_may_be_anywhere():
    feet = np.tile(FEET, (10, 1, 1))
    wanted = make().solve(state_off((0.01, 0, 0)), reference(), feet, TROT).forces
    feet[~TROT] = np.nan
    assert np.array_equal(make().solve(state_off((0.01, 0, 0)), reference(), feet, TROT).forces, wanted)


def test_flight_is_no_contact_at_all():
    plan = make().solve(state_off(velocity=(0, 0, 1)), reference(), FEET, np.zeros((10, 4), dtype=bool))
    assert plan.solved
    assert (plan.forces == 0.0).all()
    t = 0.03 * np.arange(11)
    assert np.allclose(plan.position[:, 2], 0.3 + t - 0.5 * 9.81 * t**2)


@settings(max_examples=25, deadline=None, derandomize=True)
@given(yaw=st.floats(-3.1, 3.1), seed=st.integers(0, 9999))
def test_forces_do_not_depend_on_where_the_world_looks(yaw, seed):
    rng = np.random.default_rng(seed)
    normal = np.array([0.2, -0.1, 1.0]) / np.linalg.norm([0.2, -0.1, 1.0])
    ref = BodyReference.cruise([0, 0, 0.3], 0.3, (0.5, 0.2), 0.5, normal=normal)
    state = BodyState(
        rotation_about([1.0, 0, 0], 0.1) @ ref.rotation[0], ref.position[0] + 0.02 * rng.normal(size=3),
        0.5 * rng.normal(size=3), 0.5 * rng.normal(size=3),
    )  # fmt: skip
    frames = np.array([rotation_from_normal(normal)] * 4)
    R, shift = rotation_about([0.0, 0, 1], yaw), rng.normal(size=3)
    turned = BodyReference(
        R @ ref.rotation, ref.position @ R.T + shift, ref.linear_velocity @ R.T, ref.angular_velocity @ R.T
    )
    moved = BodyState(
        R @ state.rotation, R @ state.position + shift, R @ state.linear_velocity, R @ state.angular_velocity
    )
    here = make(tol=1e-7).solve(state, ref, FEET, TROT, frames)
    there = make(tol=1e-7).solve(moved, turned, FEET @ R.T + shift, TROT, R @ frames)
    assert np.allclose(here.forces, there.forces, rtol=0, atol=1e-5)
    assert np.allclose(there.forces_world, here.forces_world @ R.T, rtol=0, atol=1e-5)
    assert np.allclose(there.position, here.position @ R.T + shift, atol=1e-7)


def test_friction_lives_in_the_contact_frame():
    """On two walls of a gully every force leans beyond the world's cone, and none beyond its own."""
    lean = (
        rotation_from_normal([0.0, -np.sin(0.8), np.cos(0.8)]),
        rotation_from_normal([0.0, np.sin(0.8), np.cos(0.8)]),
    )
    frames = np.array([lean[0], lean[1], lean[0], lean[1]])
    mpc = make(mu=0.3, normal_min=0.0)
    schedule = np.ones((10, 4), dtype=bool)
    plan = mpc.solve(state_off(), reference(), FEET, schedule, frames)
    assert_inside(plan, mpc, schedule, mu=0.3, low=0.0)
    world = plan.forces_world[0]
    assert np.allclose(np.einsum("nij,nj->ni", frames, plan.first), world)
    assert (np.linalg.norm(world[:, :2], axis=1) > 0.3 * world[:, 2]).all()
    assert world[:, 2].sum() == pytest.approx(15.0 * 9.81, rel=0.02)


def test_friction_can_differ_per_call_foot_and_step():
    mpc = make()
    mu = np.full((10, 4), 0.6)
    mu[3:, 0] = 0.05
    plan = mpc.solve(state_off(velocity=(0, 0.8, 0)), reference(), FEET, TROT, mu=mu)
    f = plan.forces
    assert (np.linalg.norm(f[..., :2], axis=-1) <= mu * f[..., 2] + 1e-9).all()
    other = mpc.solve(state_off(velocity=(0, 0.8, 0)), reference(), FEET, TROT).forces
    assert np.linalg.norm(other - f) > 1.0


@pytest.mark.parametrize("name", ["slope", "rough", "limit"])
def test_warm_starts_change_the_work_and_not_the_answer(name):
    scene = choose_scenes([name])[0]
    warm, cold = controller(scene, tol=1e-4), controller(scene, tol=1e-4)
    saved = total = 0
    for k, inputs in enumerate(record(scene, 80)):
        warm.shift(TICK)
        cold.reset()
        a, b = warm.solve(*inputs), cold.solve(*inputs)
        assert a.solved
        assert np.linalg.norm(a.forces - b.forces) <= 2e-4
        if k > 0:
            saved, total = saved + b.iterations - a.iterations, total + b.iterations
    assert saved >= 0.15 * total


def test_another_step_length_is_that_of_a_fresh_controller():
    state, feet = state_off((0, 0.02, 0), (0.1, 0, 0)), np.ones((6, 4), dtype=bool)
    paced, fresh = (make(horizon=6, dt=dt) for dt in (0.03, 0.05))
    paced.solve(state, reference(horizon=6), FEET, feet)
    paced.pace(0.05)
    a, b = (mpc.solve(state, reference(horizon=6, dt=0.05), FEET, feet) for mpc in (paced, fresh))
    np.testing.assert_allclose(a.forces, b.forces, rtol=0.0, atol=0.05)
    with pytest.raises(ProblemError, match="dt"):
        paced.pace(0.0)


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"mass": 0.0}, "mass"),
        ({"inertia": -np.eye(3)}, "inertia"),
        ({"inertia": np.eye(2)}, "inertia"),
        ({"horizon": 0}, "horizon"),
        ({"dt": -0.1}, "dt"),
        ({"mu": -0.1}, "mu"),
        ({"mu": [0.1, 0.2]}, "mu"),
        ({"normal_min": 5.0, "normal_max": 1.0}, "normal_min"),
        ({"weights": MpcWeights(linear_velocity=(0.0, 1.0, 1.0))}, "velocities"),
        ({"weights": MpcWeights(position=(-1.0, 1.0, 1.0))}, "weights"),
        ({"weights": MpcWeights(force=0.0)}, "force weight"),
    ],
)
def test_settings_that_make_no_sense_are_named(changes, text):
    values = {"mass": 15.0, "inertia": INERTIA, **changes}
    with pytest.raises(ProblemError, match=text):
        ConvexMpc(**values)


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"contacts": np.ones((9, 4))}, "contacts"),
        ({"foot_positions": np.zeros((3, 3))}, "foot_positions"),
        ({"foot_positions": "feet"}, "foot_positions"),
        ({"frames": np.zeros((4, 3))}, "frames"),
        ({"frames": np.tile(-np.eye(3), (4, 1, 1))}, "right-handed"),
        ({"frames": np.tile(2.0 * np.eye(3), (4, 1, 1))}, "rotations"),
        ({"mu": -np.ones(4)}, "mu"),
        ({"mu": np.ones(3)}, "mu"),
        ({"mu": np.full(4, np.nan)}, "mu"),
        ({"reference": reference(horizon=7)}, "horizon of 10"),
    ],
)
def test_input_of_the_wrong_shape_is_named(changes, text):
    values = {"reference": reference(), "foot_positions": FEET, "contacts": TROT, **changes}
    with pytest.raises(ProblemError, match=text):
        make().solve(state_off(), **values)


def test_a_program_needs_finite_input():
    with pytest.raises(ProblemError, match="finite"):
        horizon_program(make(), state_off((np.nan, 0, 0)), reference(), FEET, TROT)
