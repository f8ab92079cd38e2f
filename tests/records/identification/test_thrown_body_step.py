"""Thrown bodies, compiled: against closed forms, Pinocchio's dynamics, MuJoCo's flight and our own step."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from scipy.spatial.transform import Rotation

from benchmarks import toss_speed
from benchmarks.problems.tosses import ELBOW
from surefoot.mechanics.collision import Box
from surefoot.mechanics.robot import load_robot
from surefoot.records.identification import thrown_body_impact as layout
from surefoot.records.identification.ground_plane import GroundPlane
from surefoot.records.identification.thrown_body import ThrownBody, cube_body, thrown_body
from surefoot.records.identification.thrown_body_step import throw
from surefoot.records.identification.thrown_body_tree import dynamics, place, work_arrays
from surefoot.records.identification.toss_model import LAWS, ThrownModel, TossScene
from surefoot.records.identification.tosses import Cube
from surefoot.worlds.rigid.scene import Body

G, LEVEL, RIGID = 9.81, GroundPlane(0.0, np.zeros(2)), np.array([0.3, 0.0, 0.0])


@pytest.fixture(scope="module")
def elbow(tmp_path_factory: pytest.TempPathFactory) -> ThrownBody:
    path = tmp_path_factory.mktemp("model") / "elbow.urdf"
    path.write_text(ELBOW)
    return thrown_body(path)


def scene(body: ThrownBody, start: list[float], frames: int, dt: float = 0.005) -> TossScene:
    return TossScene(np.array([start]), np.array([frames]), dt, LEVEL, G, body)


def test_the_mass_matrix_and_forces_are_pinocchios(elbow: ThrownBody, tmp_path: Path) -> None:
    path = tmp_path / "elbow.urdf"
    path.write_text(ELBOW)
    robot, random = load_robot(path), np.random.default_rng(0)
    model, data = robot.model, robot.model.createData()
    for _ in range(5):
        turn, angle = Rotation.from_rotvec(random.normal(size=3)), float(random.normal())
        v, p = random.normal(size=7), random.normal(size=3)
        at = work_arrays(elbow.tree)
        here = np.array([*p, *turn.as_quat(), angle])
        place(elbow.tree, here, at)
        dynamics(elbow.tree, at, here, v, np.array([0.0, 0.0, -G]), 0.0)
        a = np.linalg.solve(np.tril(at.M) @ np.tril(at.M).T, at.f)
        R = turn.as_matrix()
        q = np.array([*p, *turn.as_quat(), np.cos(angle), np.sin(angle)])
        body_v = np.array([*(R.T @ v[:3]), *(R.T @ v[3:6]), v[6]])
        theirs = pin.aba(model, data, q, body_v, np.zeros(7))
        # spatial acceleration in body axes to that of the origin in the world's
        linear = R @ (theirs[:3] + np.cross(body_v[3:6], body_v[:3]))
        np.testing.assert_allclose(a, [*linear, *(R @ theirs[3:6]), theirs[6]], atol=1e-9)


def test_flight_keeps_momentum_and_energy_of_a_lopsided_jointed_body(elbow: ThrownBody) -> None:
    lopsided = elbow.at({"com_x": 0.01, "com_z_hinge": -0.008, "spread_y": 0.05})
    start = [0.0, 0.0, 30.0, 0.0, 0.0, 0.0, 1.0, 0.4, 0.3, -0.2, 0.5, 6.0, -3.0, 4.0, 5.0]
    poses = ThrownModel(steps=10).rollout(RIGID, scene(lopsided, start, 60))
    tree, centres = lopsided.tree, []
    at = work_arrays(tree)
    for pose in poses:
        place(tree, pose, at)
        links = [tree.masses[i] * (at.p[i] + at.R[i] @ tree.centres[i]) for i in range(2)]
        centres.append(sum(links) / tree.masses.sum())
    c, t = np.array(centres), 0.005 * np.arange(60)
    parabola = (
        c[0] + np.outer(t, (c[1] - c[0]) / 0.005 + [0, 0, 0.5 * G * 0.005]) - np.outer(t * t, [0, 0, 0.5 * G])
    )
    np.testing.assert_allclose(c, parabola, atol=2e-5)


@pytest.mark.parametrize(("height", "speed"), [(0.3, 0.0), (0.5, 0.7)])
def test_a_flat_drop_bounces_and_slides_as_the_books_say(height: float, speed: float) -> None:
    body, mu, e = cube_body(Cube()), 0.1, 0.4
    a = Cube().half_side
    start = [0.0, 0.0, a + height, 0.0, 0.0, 0.0, 1.0, speed, 0.0, 0.0, 0.0, 0.0, 0.0]
    poses = ThrownModel().rollout(np.array([mu, e, 0.0]), scene(body, start, 500, 0.001))
    fall = np.sqrt(2.0 * height / G)
    rise = poses[int(np.ceil(fall / 0.001)) + 2 :, 2].max() - a
    assert rise == pytest.approx(e * e * height, rel=2e-2)
    if speed:
        after = (poses[340, 0] - poses[330, 0]) / 0.01
        assert fall < 0.33
        assert after == pytest.approx(speed - mu * (1.0 + e) * G * fall, abs=5e-3)


def test_a_slide_ends_where_friction_stops_it_with_our_own_step() -> None:
    from surefoot.worlds.rigid.scene import Scene, SceneWorld

    a, cube = Cube().half_side, Cube()
    edge = 2.0 * a
    world = SceneWorld(
        Scene([Body("cube", Box((edge,) * 3), cube.mass, (0, 0, a), velocity=(1.0, 0.5, 0.0))]),
        mu=0.3,
        dt=1e-3,
    )
    for _ in range(500):
        world.step()
    start = [0.0, 0.0, a, 0.0, 0.0, 0.0, 1.0, 1.0, 0.5, 0.0, 0.0, 0.0, 0.0]
    poses = ThrownModel(steps=5).rollout(RIGID, scene(cube_body(cube), start, 101))
    np.testing.assert_allclose(poses[-1, :3], world.pose("cube").position, atol=1.5e-3)
    exact = np.array([1.0, 0.5]) * np.hypot(1.0, 0.5) / (2.0 * 0.3 * G)
    np.testing.assert_allclose(poses[-1, :2], exact, atol=1.5e-3)


def test_a_joints_dry_friction_stops_it_and_damping_slows_it(elbow: ThrownBody) -> None:
    start = [0.0, 0.0, 30.0, 0.0, 0.0, 0.0, 1.0, 0.0, *[0.0] * 6, 2.0]
    free, dry, damped = (
        ThrownModel(steps=5).rollout(RIGID, scene(elbow.at(values), start, 60))[:, 7]
        for values in ({}, {"friction_hinge": 0.02}, {"damping_hinge": 1e-3})
    )
    assert free[-1] - free[-2] > 0.005
    assert dry[-1] == dry[-20] > 0.0
    assert dry[-1] < damped[-1] < free[-1]


def test_no_energy_comes_from_nothing_under_any_law() -> None:
    body, random = cube_body(Cube()).at({"com_z": 0.006}), np.random.default_rng(3)
    tree = body.rounded(0.003)
    for slot, value in ((layout.POISSON, 0.4), (layout.RESTITUTION, 0.3), (layout.TANGENTIAL, 0.3)):
        law = np.zeros(layout.SIZE)
        law[layout.MU], law[slot] = 0.2, value
        turns = Rotation.random(20, rng=1).as_quat()
        starts = np.concatenate([np.zeros((20, 2)), np.full((20, 1), 0.2), turns,
                                 random.normal(size=(20, 6)) * [1, 1, 1, 4, 4, 4]], axis=1)  # fmt: skip
        poses = np.empty((20 * 400, 7))
        assert throw(tree, law, np.array([0, 0, -G]), starts, np.full(20, 400), 0.005, 4, poses) == 0
        ends = poses.reshape(20, 400, 7)[:, -10:]
        assert np.abs(np.diff(ends, axis=1)).max() < 1e-4
        assert ends[:, -1, 2].max() < np.sqrt(3.0) * Cube().half_side


def test_the_price_of_a_throw_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    toss_speed.main(["--tosses", "2", "--repeats", "1"])
    lines = capsys.readouterr().out.splitlines()
    rows = [line.split("│")[1:-1] for line in lines if line.startswith("│")]
    own = [row for row in rows if row[1].strip() in LAWS]
    assert len(own) == 2 * len(LAWS)
    assert {row[0].strip() for row in own} == {"cube", "elbow"}
    assert all(0.0 < float(row[2]) <= float(row[3]) for row in rows)
