"""Rival simulators of a thrown body: the same free flight, the same slide; what is missing is named."""

from __future__ import annotations

import pickle
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from benchmarks.problems.tosses import ELBOW
from surefoot.base.errors import ProblemError
from surefoot.records.identification.ground_plane import GroundPlane
from surefoot.records.identification.thrown_body import ThrownBody, cube_body, thrown_body
from surefoot.records.identification.toss_model import ThrownModel, TossModel, TossScene
from surefoot.records.identification.tosses import Cube
from surefoot.worlds.drake import drake_python
from surefoot.worlds.experiments.mujoco_tosses import MujocoBody
from surefoot.worlds.experiments.tosses import RIVALS
from surefoot.worlds.experiments.tosses import rival as known

STIFF = {
    "mujoco": [0.2, 0.004, 1.0, 0.95, 0.99], "drake": [0.2, 6.0, 10.0, 1e-3],
    "bullet": [0.2, 0.0, 5.0, 2.0, 1e-3],
}  # fmt: skip
HERE = {
    "mujoco": find_spec("mujoco") is not None, "drake": drake_python.present(),
    "bullet": find_spec("pybullet") is not None,
}  # fmt: skip


@pytest.mark.parametrize("name", RIVALS)
def test_rivals_go_to_other_processes(name: str) -> None:
    copy = pickle.loads(pickle.dumps(rival(name)))
    assert (copy.name, copy.parameters) == (name, rival(name).parameters)


def scene(
    *starts: list[float], slope: float = 0.0, frames: int = 40, body: ThrownBody | None = None
) -> TossScene:
    plane = GroundPlane(0.01, np.array([slope, 0.0]))
    return TossScene(
        np.array(starts), np.full(len(starts), frames), 0.005, plane, 9.7, body or cube_body(Cube())
    )


def rival(name: str) -> TossModel:
    if not HERE[name]:
        pytest.skip(f"{name} is not installed")
    return known(name)


@pytest.mark.parametrize("name", RIVALS)
def test_free_flight_is_the_same(name: str) -> None:
    turn = Rotation.from_rotvec([0.5, 0.2, -0.3]).as_quat()
    given = scene([0.1, 0.2, 1.5, *turn, 0.5, -0.2, 0.3, 5.0, -3.0, 2.0])
    ours, theirs = ThrownModel().rollout(np.array([0.2, 0.0, 0.0]), given), None
    theirs = rival(name).rollout(np.array(STIFF[name]), given)
    t = 0.005 * np.arange(40)
    np.testing.assert_allclose(theirs[:, :2], ours[:, :2], atol=1e-9)
    # a step of dt falls short or too far by g t dt / 2
    assert (np.abs(theirs[:, 2] - ours[:, 2]) <= 0.6 * 9.7 * t * 1e-3 + 1e-12).all()
    turned = Rotation.from_quat(theirs[:, 3:]) * Rotation.from_quat(ours[:, 3:]).inv()
    assert turned.magnitude().max() < 0.01


@pytest.mark.parametrize("name", ["rigid", "mujoco"])
def test_threads_change_no_pose(name: str) -> None:
    values = np.array(STIFF.get(name, [0.2, 0.3, 0.001]))
    turns = Rotation.random(40, rng=0).as_quat()
    given = scene(*([0.0, 0.0, 0.1, *turn, 1.0, 0.0, 0.0, 5.0, -3.0, 2.0] for turn in turns.tolist()))
    if name == "rigid":
        one, many = ThrownModel(), ThrownModel(threads=3)
    else:
        pytest.importorskip(name)
        one, many = MujocoBody(), MujocoBody(threads=3)
    np.testing.assert_array_equal(one.rollout(values, given), many.rollout(values, given))
    with pytest.raises(ProblemError, match="threads"):
        ThrownModel(threads=0)


def test_a_toss_that_blows_up_in_mujoco_is_lost_and_says_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """MuJoCo begins such a simulation anew, and writes of it to stderr and into the working folder."""
    monkeypatch.chdir(tmp_path)
    slow, fast = ([0.1, 0.2, 1.5, 0.0, 0.0, 0.0, 1.0, v, 0.0, 0.0, 0.0, 0.0, 0.0] for v in (0.5, 1e11))
    values, throw = np.array(STIFF["mujoco"]), rival("mujoco").rollout
    both = throw(values, scene(slow, fast)).reshape(2, 40, 7)
    np.testing.assert_array_equal(both[0], throw(values, scene(slow)))
    assert np.isnan(both[1, 1:]).all()
    assert not [*tmp_path.iterdir()]
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("name", RIVALS)
def test_a_lopsided_jointed_bodys_flight_is_the_same(name: str, tmp_path: Path) -> None:
    path = tmp_path / "elbow.urdf"
    path.write_text(ELBOW)
    values = {"com_x": 0.01, "com_z_hinge": -0.008, "mass_hinge": 0.5, "spread_y": 0.05}
    body = thrown_body(path).at(values | {"damping_hinge": 1e-3})
    turn = Rotation.from_rotvec([0.5, 0.2, -0.3]).as_quat()
    start = [0.1, 0.2, 3.0, *turn, 0.4, 0.5, -0.2, 0.3, 5.0, -3.0, 2.0, 4.0]
    given = scene(start, frames=30, body=body)
    ours = ThrownModel(steps=5).rollout(np.array([0.2, 0.0, 0.0]), given)
    theirs = rival(name).rollout(np.array(STIFF[name]), given)
    np.testing.assert_allclose(theirs[:, :2], ours[:, :2], atol=2e-3)
    np.testing.assert_allclose(theirs[:, 7], ours[:, 7], atol=0.02)
    turned = Rotation.from_quat(theirs[:, 3:7]) * Rotation.from_quat(ours[:, 3:7]).inv()
    assert turned.magnitude().max() < 0.02


def test_a_hinge_that_gives_bends_alike_in_mujoco(tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    path = tmp_path / "elbow.urdf"
    path.write_text(ELBOW)
    start = [0.1, 0.2, 3.0, 0.0, 0.0, 0.0, 1.0, 0.4, 0.5, -0.2, 0.3, 8.0, -3.0, 9.0, 4.0]
    poses = {}
    for compliance in (0.0, 3.0):
        given = scene(start, frames=30, body=thrown_body(path).at({"compliance_hinge": compliance}))
        poses[compliance] = ThrownModel(steps=40).rollout(np.array([0.2, 0.0, 0.0]), given)
        theirs = MujocoBody().rollout(np.array(STIFF["mujoco"]), given)
        assert theirs.shape == poses[compliance].shape
        turned = Rotation.from_quat(theirs[:, 3:7]) * Rotation.from_quat(poses[compliance][:, 3:7]).inv()
        assert turned.magnitude().max() < 0.02
    bent = Rotation.from_quat(poses[3.0][:, 3:7]) * Rotation.from_quat(poses[0.0][:, 3:7]).inv()
    assert bent.magnitude().max() > 0.1, "what is compared is not small"


@pytest.mark.parametrize("slope", [0.0, 0.1])
@pytest.mark.parametrize("name", RIVALS)
def test_a_flat_slide_is_the_same(name: str, slope: float) -> None:
    plane = scene([0.0] * 13, slope=slope).plane
    place = np.array([0.0, 0.0, 0.01]) + plane.rotation.apply([0.0, 0.0, Cube().half_side])
    speed = plane.rotation.apply([0.6, 0.1, 0.0])
    given = scene([*place, *plane.rotation.as_quat(), *speed, 0.0, 0.0, 0.0], slope=slope, frames=80)
    ours = ThrownModel().rollout(np.array([0.2, 0.0, 0.0]), given)
    theirs = rival(name).rollout(np.array(STIFF[name]), given)
    assert np.linalg.norm(ours[-1, :2] - ours[0, :2]) > 0.05
    np.testing.assert_allclose(theirs[:, :3], ours[:, :3], atol=4e-3)
