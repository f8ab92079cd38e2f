"""The compiled cube against closed forms, and against NumPy and the general contact solver."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import surefoot as sf
from surefoot.arrays import FloatArray
from surefoot.errors import ProblemError
from surefoot.estimation import cube_contact as layout
from surefoot.estimation.cube_contact import exchange, place, rise
from surefoot.estimation.cube_model import PARAMETERS, CubeModel
from surefoot.estimation.cube_motion import fly, simulate, step
from surefoot.estimation.ground_plane import GroundPlane
from surefoot.estimation.toss_model import TossScene
from surefoot.estimation.tosses import Cube

G = 9.81
CUBE = Cube()
A = CUBE.half_side
LEVEL = GroundPlane(0.0, np.zeros(2))


def scene(
    position: object, velocity: object = (0, 0, 0), spin: object = (0, 0, 0), turn: Rotation | None = None,
    frames: int = 100, dt: float = 0.005, plane: GroundPlane = LEVEL,
) -> TossScene:  # fmt: skip
    quaternion = (turn or Rotation.identity()).as_quat()
    start = np.concatenate([np.array(x, dtype=float) for x in (position, quaternion, velocity, spin)])
    return TossScene(start[None], np.array([frames]), dt, plane, G, CUBE)


def model_array(mu: float = 0.3, restitution: float = 0.0, **soft: float) -> FloatArray:
    model = np.zeros(layout.SIZE)
    model[layout.MU], model[layout.RESTITUTION], model[layout.HALF] = mu, restitution, A
    model[layout.GYRATION], model[layout.GRAVITY + 2] = CUBE.inertia / CUBE.mass, -G
    for name, value in soft.items():
        model[getattr(layout, name)] = value
    return model


def energy(poses: FloatArray, dt: float) -> FloatArray:
    """Return kinetic and potential energy per mass between frames, from differences of the poses."""
    v = np.diff(poses[:, :3], axis=0) / dt
    turns = [Rotation.from_quat(q) for q in poses[:, 3:]]
    w = np.array([(b * a.inv()).magnitude() / dt for a, b in pairwise(turns)])
    z = 0.5 * (poses[1:, 2] + poses[:-1, 2])
    return 0.5 * (v**2).sum(axis=1) + 0.5 * CUBE.inertia / CUBE.mass * w**2 + G * z


def test_flight_is_a_parabola_and_a_steady_turn() -> None:
    turn, v, w = (
        Rotation.from_rotvec([0.3, -1.0, 0.4]),
        np.array([0.5, -0.2, 1.0]),
        np.array([9.0, -4.0, 6.0]),
    )
    given = scene([0.1, 0.2, 5.0], v, w, turn, frames=60)
    poses = CubeModel().rollout(np.array([0.3, 0.2, 0.0]), given)
    t = given.dt * np.arange(60)[:, None]
    np.testing.assert_allclose(
        poses[:, :3], [0.1, 0.2, 5.0] + v * t - [0, 0, 0.5 * G] * t**2, rtol=0, atol=1e-12
    )
    expected = Rotation.from_rotvec(w * t) * turn
    assert (Rotation.from_quat(poses[:, 3:]) * expected.inv()).magnitude().max() < 1e-7


def test_fly_turns_slowly_and_not_at_all() -> None:
    for spin in ([0.0, 0.0, 0.0], [1e-9, 0.0, 0.0], [3.0, 2.0, -5.0]):
        state = np.array([0.0, 0.0, 1.0, 0.1, 0.2, 0.3, 0.9])
        state[3:] /= np.linalg.norm(state[3:])
        before = Rotation.from_quat(state[3:])
        fly(state, np.array([1.0, 2.0, 3.0, *spin]), np.array([0.0, 0.0, -G]), 0.01)
        np.testing.assert_allclose(state[:3], [0.01, 0.02, 1.03 - 0.5 * G * 1e-4], atol=1e-15)
        turned = (Rotation.from_quat(state[3:]) * before.inv()).as_rotvec()
        np.testing.assert_allclose(turned, 0.01 * np.array(spin), atol=1e-15)


def test_corners_and_their_speeds_are_those_of_a_rotated_box() -> None:
    random = np.random.default_rng(0)
    arms, gaps = np.empty((8, 3)), np.empty(8)
    for radius in (0.0, 0.004):
        turn, v = Rotation.from_rotvec(random.normal(size=3)), random.normal(size=6)
        state, model = np.array([0.0, 0.0, 0.3, *turn.as_quat()]), model_array(RADIUS=radius)
        place(state, model, arms, gaps)
        signs = np.array([[(1 if k & 1 << a else -1) for a in range(3)] for k in range(8)])
        expected = turn.apply((A - radius) * signs) - [0.0, 0.0, radius]
        np.testing.assert_allclose(arms, expected, atol=1e-15)
        np.testing.assert_allclose(gaps, 0.3 + expected[:, 2], atol=1e-15)
        for k in range(8):
            assert rise(v, arms, k) == pytest.approx((v[:3] + np.cross(v[3:], arms[k]))[2], abs=1e-14)


@pytest.mark.parametrize("restitution", [0.0, 0.4])
@pytest.mark.parametrize("law", ["rigid", "spring-damper"])
def test_impulses_obey_the_laws_of_the_problem_as_numpy_writes_it(law: str, restitution: float) -> None:
    random, t, k, d = np.random.default_rng(1), 1e-3, 3e4, 20.0
    soft = {"LAW": layout.SPRING_DAMPER, "STIFFNESS": k, "DAMPING": d} if law != "rigid" else {}
    model, worst = model_array(0.4, restitution, **soft), 0.0
    arms, gaps = np.empty((8, 3)), np.empty(8)
    for trial in range(40):
        turn = Rotation.from_rotvec(random.normal(size=3))
        place(np.array([0.0, 0.0, 0.0, *turn.as_quat()]), model, arms, gaps)
        near = np.sort(np.argsort(gaps)[: 1 + trial % 4])
        gaps[near] = 1e-5 * random.normal(size=near.size)
        before = np.array([*random.normal(size=2), -1.0, *(3.0 * random.normal(size=3))])
        free = before + G * t * np.array([0, 0, -1, 0, 0, 0])
        J = np.vstack([np.hstack([np.eye(3), -_skew(arms[i])]) for i in near])
        inverse = np.diag([1.0] * 3 + [CUBE.mass / CUBE.inertia] * 3)
        matrix, g = J @ inverse @ J.T, J @ free
        arrival = (J @ before)[2::3]
        if law == "rigid":
            gap = gaps[near]
            hold = np.where(gap > 0.0, gap / t, -np.minimum(-layout.RISE * gap / t, layout.RISE_SPEED))
            g[2::3] += np.where(arrival < -0.01, restitution * arrival, hold)
        else:
            g[2::3] += k * gaps[near] / (k * t + d)
            matrix[np.arange(2, 3 * near.size, 3), np.arange(2, 3 * near.size, 3)] += 1 / (t * (k * t + d))
        after, kept = free.copy(), np.zeros((8, 4))
        assert exchange(model, arms, gaps, near, t, 0.01, before, after, kept)
        impulses = kept[near, :3]
        judged = sf.residuals(sf.ContactProblem(matrix, g, 0.4), impulses)
        assert max(judged.velocity_error, judged.rounding) < 1e-7
        assert not np.delete(kept[:, :3], near, axis=0).any()
        worst = max(worst, float(np.abs(after - free - inverse @ J.T @ impulses.ravel()).max()))
    assert worst < 1e-12


def _skew(r: FloatArray) -> FloatArray:
    return np.array([[0, -r[2], r[1]], [r[2], 0, -r[0]], [-r[1], r[0], 0]])


@pytest.mark.parametrize("e", [0.0, 0.3, 0.7])
def test_a_flat_drop_bounces_to_e_squared(e: float) -> None:
    drop = 0.2
    poses = CubeModel().rollout(np.array([0.3, e, 0.0]), scene([0.0, 0.0, A + drop], dt=0.001, frames=600))
    fall = int(np.sqrt(2 * drop / G) / 0.001) + 2
    top = poses[fall:, 2].max() - A
    assert top == pytest.approx(e * e * drop, abs=1e-4)
    assert np.abs(poses[:, :2]).max() < 1e-8  # the solver stops at 1e-8 of 2 m/s
    assert poses[:, 2].min() > A - 3e-5


@pytest.mark.parametrize("law", PARAMETERS)
def test_a_flat_slide_stops_where_coulomb_says(law: str) -> None:
    mu, speed = 0.2, 0.8
    values = {"rigid": [mu, 0.0, 0.0], "spring-damper": [mu, 1e5, 200.0], "hunt-crossley": [mu, 1e5, 5.0]}[
        law
    ]
    given = scene([0.0, 0.0, A], [speed, 0.0, 0.0], dt=0.005, frames=140)
    poses = CubeModel(law).rollout(np.array(values), given)
    assert poses[-1, 0] == pytest.approx(speed**2 / (2 * mu * G), abs=2e-3)
    assert np.abs(poses[-1, :3] - poses[-20, :3]).max() < 1e-6
    assert poses[-1, 2] == pytest.approx(A, abs=2e-5)


@pytest.mark.parametrize(("mu", "slides"), [(0.25, True), (0.35, False)])
def test_a_slope_holds_below_the_friction_angle_only(mu: float, slides: bool) -> None:
    plane = GroundPlane(0.02, np.array([0.3, 0.0]))
    turn = plane.rotation
    start = np.array([0.0, 0.0, 0.02]) + turn.apply([0.0, 0.0, A])
    given = scene(start, turn=turn, plane=plane, frames=100)
    poses = CubeModel().rollout(np.array([mu, 0.0, 0.0]), given)
    angle, t = np.arctan(0.3), 0.005 * 99
    expected = 0.5 * G * (np.sin(angle) - mu * np.cos(angle)) * t * t if slides else 0.0
    assert np.linalg.norm(poses[-1, :3] - poses[0, :3]) == pytest.approx(expected, rel=0.01, abs=1e-5)


def test_a_tumble_without_restitution_never_gains_energy() -> None:
    random = np.random.default_rng(4)
    for _ in range(6):
        turn = Rotation.from_rotvec(random.normal(size=3))
        given = scene([0, 0, 0.15], [0.8, 0.1, -0.3], 8 * random.normal(size=3), turn, 300, 0.002)
        poses = CubeModel().rollout(np.array([0.4, 0.0, 0.0]), given)
        change = np.diff(energy(poses, given.dt))
        assert change.max() < 2e-3
        assert LEVEL.above(_lowest(poses)).min() > -1e-3


def _lowest(poses: FloatArray) -> FloatArray:
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
    arms = np.einsum("nij,kj->nki", Rotation.from_quat(poses[:, 3:]).as_matrix(), A * signs)
    return np.asarray((poses[:, None, :3] + arms).reshape(-1, 3))


def test_soft_laws_become_the_rigid_one_as_stiffness_grows() -> None:
    given = scene(
        [0.0, 0.0, 0.12], [0.5, 0.0, 0.0], [1.0, 3.0, 0.5], Rotation.from_rotvec([0.4, 0.3, 0.0]), 60
    )
    rigid = CubeModel(steps=40).rollout(np.array([0.3, 0.0, 0.0]), given)
    away = []
    for stiffness in (1e3, 1e4, 1e5):
        damping = 2.0 * np.sqrt(stiffness * CUBE.mass)
        soft = CubeModel("spring-damper", steps=40).rollout(np.array([0.3, stiffness, damping]), given)
        away.append(float(np.linalg.norm(soft[:40, :3] - rigid[:40, :3], axis=1).max()))
    assert away[0] > away[1] > away[2]
    assert away[2] < 2e-3


def test_a_step_of_the_kernel_is_one_of_the_rollout() -> None:
    given = scene([0.0, 0.0, 0.1], [0.5, 0.0, -1.0], [1.0, 3.0, 0.5], frames=40, dt=0.001)
    model, start = model_array(0.3, 0.1), given.starts[0]
    poses = np.empty((40, 7))
    assert simulate(given.starts, given.frames, given.dt, 1, model, poses) == 0
    state, v = start[:7].copy(), start[7:].copy()
    room = np.empty(3), np.empty((8, 3)), np.empty(8), np.empty(8, dtype=np.int64), np.empty(6)
    last = np.zeros((8, 4))
    for k in range(1, 40):
        _, solved = step(state, v, model, 0.001, *room, last)
        assert solved
        np.testing.assert_allclose(state, poses[k], rtol=0, atol=1e-12)


def test_finer_steps_change_little() -> None:
    given = scene([0.0, 0.0, 0.12], [0.8, 0.2, 0.0], [2.0, -1.0, 0.5], Rotation.from_rotvec([0.5, 0.2, 0.1]))
    coarse = CubeModel().rollout(np.array([0.2, 0.1, 0.0]), given)
    fine = CubeModel(steps=50).rollout(np.array([0.2, 0.1, 0.0]), given)
    assert np.linalg.norm(coarse[:, :3] - fine[:, :3], axis=1).max() < 0.03 * CUBE.width


def test_wrong_models_are_refused() -> None:
    with pytest.raises(ProblemError, match="unknown contact law 'hertz'; valid names: hunt-crossley, rigid"):
        CubeModel("hertz")
    with pytest.raises(ProblemError, match="steps must be a whole number >= 1"):
        CubeModel(steps=0)
