"""The MPC's model against plain step-by-step mechanics and a nonlinear rigid body."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from benchmarks.problems.walking import INERTIA, MASS, choose_scenes, controller, record
from benchmarks.walk.horizon import horizon_program
from surefoot.motion.control.mpc import BodyReference, ConvexMpc

NAMES = ("trot", "walk", "slope", "rough")


@pytest.fixture(scope="module")
def inputs():
    return {name: record(choose_scenes([name])[0], 45)[20:44:8] for name in NAMES}


def march(mpc, given, forces):
    """Return cost, positions, velocities and orientation errors under (N, n, 3) forces, step by step.

    The levers are those of a first pass: the velocity error dies out within a tenth of a second.
    """
    state, ref, feet, contacts, frames = given
    N, dt = mpc.horizon, mpc.dt
    w = mpc.weights
    middle = ref.rotation[N // 2]
    heading = Rotation.from_euler("z", np.arctan2(middle[1, 0], middle[0, 0])).as_matrix()
    p, v, spin = state.position, state.linear_velocity, state.angular_velocity
    turn = Rotation.from_matrix(state.rotation @ ref.rotation[0].T).as_rotvec()
    lag, slip = p - ref.position[0], v - ref.linear_velocity[0]
    track = [(p, v, spin, turn)]
    cost = 0.0
    for k in range(N):
        centre = 0.5 * (ref.position[k] + ref.position[k + 1]) + lag
        centre = centre + 0.1 * (1.0 - np.exp(-(k + 0.5) * dt / 0.1)) * slip
        inertia = ref.rotation[k] @ np.asarray(mpc.inertia) @ ref.rotation[k].T
        pull, moment = np.split(mpc.outside * np.exp(-(k + 0.5) * dt / mpc.fading), 2)
        on = np.flatnonzero(contacts[k])
        for i in on:
            world = frames[k, i] @ forces[k, i]
            pull, moment = pull + world, moment + np.cross(feet[k, i] - centre, world)
            wanted = frames[k, i].T @ [0.0, 0.0, mpc.mass * 9.81 / on.size]
            cost += 0.5 * w.force * np.sum((forces[k, i] - wanted) ** 2)
        a, b = pull / mpc.mass - [0.0, 0.0, 9.81], np.linalg.solve(inertia, moment)
        step = Rotation.from_matrix(ref.rotation[k + 1] @ ref.rotation[k].T).as_rotvec()
        p, turn = p + dt * v + 0.5 * dt**2 * a, turn + dt * spin + 0.5 * dt**2 * b - step
        v, spin = v + dt * a, spin + dt * b
        for weight, error in (
            (w.position, p - ref.position[k + 1]),
            (w.orientation, turn),
            (w.linear_velocity, v - ref.linear_velocity[k + 1]),
            (w.angular_velocity, spin - ref.angular_velocity[k + 1]),
        ):
            cost += 0.5 * np.sum(np.array(weight) * (heading.T @ error) ** 2)
        track.append((p, v, spin, turn))
    return cost, *(np.array(part) for part in zip(*track, strict=True))


OUTSIDE = np.array([20.0, -30.0, 15.0, 3.0, -2.0, 1.0])


@pytest.mark.parametrize("outside", [0.0, 1.0])
@pytest.mark.parametrize("name", NAMES)
def test_the_condensed_cost_is_the_cost_of_the_march(inputs, name, outside):
    mpc = controller(choose_scenes([name])[0])
    mpc.outside, mpc.fading = outside * OUTSIDE, 0.2
    rng = np.random.default_rng(1)
    for given in inputs[name]:
        program = horizon_program(mpc, *given)
        H, g = program.condensed()
        values = []
        for _ in range(4):
            f = rng.normal(size=(program.step.size, 3)) * 40.0
            full = np.zeros((mpc.horizon, 4, 3))
            full[program.step, program.foot] = f
            values.append((march(mpc, given, full)[0], 0.5 * f.ravel() @ H @ f.ravel() + g @ f.ravel()))
        plain, condensed = np.array(values).T
        assert np.allclose(np.diff(plain), np.diff(condensed), rtol=1e-9, atol=1e-9 * np.ptp(plain))


@pytest.mark.parametrize("outside", [0.0, 1.0])
@pytest.mark.parametrize("name", NAMES)
def test_the_prediction_is_the_march(inputs, name, outside):
    mpc = controller(choose_scenes([name])[0])
    mpc.outside, mpc.fading = outside * OUTSIDE, 0.2
    for given in inputs[name]:
        plan = mpc.solve(*given)
        _, p, v, spin, turn = march(mpc, given, plan.forces)
        for mine, plain in (
            (plan.position, p),
            (plan.linear_velocity, v),
            (plan.angular_velocity, spin),
            (plan.orientation_error, turn),
        ):
            assert np.allclose(mine, plain, rtol=0, atol=1e-10)


def fly(state, forces, feet, dt, pieces=200):
    """Return position and rotation of the true rigid body after each step of constant world forces."""
    R, p, v, w = state.rotation, state.position, state.linear_velocity, state.angular_velocity
    h, out = dt / pieces, []
    for k in range(forces.shape[0]):
        for _ in range(pieces):
            inertia = R @ INERTIA @ R.T
            moment = np.cross(feet[k] - p, forces[k]).sum(axis=0)
            a = forces[k].sum(axis=0) / MASS - [0.0, 0.0, 9.81]
            b = np.linalg.solve(inertia, moment - np.cross(w, inertia @ w))
            p, v, w = p + h * v + 0.5 * h * h * a, v + h * a, w + h * b
            R = Rotation.from_rotvec(h * (w - 0.5 * h * b)).as_matrix() @ R
        out.append((p, R))
    return np.array([p for p, _ in out]), np.array([R for _, R in out])


@pytest.mark.parametrize("name", NAMES)
def test_the_prediction_is_near_the_true_rigid_body(inputs, name):
    """Positions are exact; orientations are near after 3 steps, and not far after 10."""
    mpc = controller(choose_scenes([name])[0])
    given = inputs[name][0]
    plan = mpc.solve(*given)
    p, R = fly(given.state, plan.forces_world, given.foot_positions, mpc.dt)
    assert np.allclose(plan.position[1:], p, rtol=0, atol=1e-9)
    for k, most in ((3, 0.02), (10, 0.8)):
        turned = Rotation.from_matrix(R[k - 1] @ given.reference.rotation[k].T).as_rotvec()
        assert np.linalg.norm(turned - plan.orientation_error[k]) < most


def test_remembered_points_move_with_time():
    mpc = ConvexMpc(15.0, np.eye(3), horizon=5, dt=0.03)
    points = np.random.default_rng(4).normal(size=(5, 4, 3))
    for elapsed, steps in ((0.0, 0), (0.014, 0), (0.016, 1), (0.06, 2), (9.0, 4)):
        mpc._points = points.copy()
        mpc.shift(elapsed)
        assert np.array_equal(mpc._points[: 5 - steps], points[steps:])
        assert np.array_equal(mpc._points[5 - steps :], np.tile(points[4], (steps, 1, 1)))


def test_cruise_moves_along_the_surface_and_turns_about_its_normal():
    a = 0.3
    normal = np.array([-np.sin(a), 0.0, np.cos(a)])
    ref = BodyReference.cruise([1, 2, 3], 0.4, (0.5, -0.2), 0.8, horizon=20, dt=0.05, normal=normal)
    assert np.allclose((ref.position - ref.position[0]) @ normal, 0.0, atol=1e-12)
    assert np.allclose(ref.rotation[:, :, 2], normal)
    assert np.allclose(np.linalg.norm(ref.linear_velocity, axis=1), np.hypot(0.5, 0.2))
    assert np.allclose(np.einsum("kji,kj->ki", ref.rotation, ref.linear_velocity), [0.5, -0.2, 0.0])
    turn = Rotation.from_matrix(ref.rotation[-1] @ ref.rotation[0].T).as_rotvec()
    assert np.allclose(turn, 0.8 * 1.0 * normal, atol=1e-12)
    speeds = np.diff(ref.position, axis=0) / 0.05  # central differences of an arc, second order in dt
    assert np.allclose(speeds, 0.5 * (ref.linear_velocity[1:] + ref.linear_velocity[:-1]), atol=1e-3)
