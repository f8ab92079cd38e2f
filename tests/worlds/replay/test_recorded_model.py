"""Replays of recordings from the model that they hold: nobody names a robot."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio
import pytest

import surefoot as sf
from surefoot.base.errors import ProblemError
from surefoot.worlds.replay.recorded_model import ground_of_recording, robot_of_recording
from tests.records.audit.logs import changed

mujoco = pytest.importorskip("mujoco")
SERVOS = Path(__file__).parents[3] / "examples" / "models" / "quadruped_servos.xml"
FEET = ["FL", "FR", "RL", "RR"]


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """Return the log of a loop in which servos hold a quadruped that sways, written and read again."""
    model = mujoco.MjModel.from_xml_path(str(SERVOS))
    data, q = mujoco.MjData(model), sf.place(sf.load_robot(SERVOS, feet=FEET))
    data.qpos[:] = q
    data.qpos[3:7] = [1.0, 0.0, 0.0, 0.0]
    with sf.record(model, data) as log:
        for k in range(350):
            data.ctrl[:] = q[7:] + 0.03 * np.sin(0.02 * k) * np.tile([0.0, 1.0, -2.0], 4)
            mujoco.mj_step(model, data)
    path = tmp_path_factory.mktemp("log") / "loop.npz"
    log.save(path)
    return sf.read_log(path)


def test_the_robot_of_recording_is_that_of_the_file(recording: Any) -> None:
    """Masses, joints and places of links, against the robot that is loaded from the file itself."""
    own, loaded = sf.load_robot(SERVOS, feet=FEET), robot_of_recording(recording)
    assert loaded.joint_names == own.joint_names
    assert loaded.mass == pytest.approx(own.mass, rel=1e-12)
    np.testing.assert_allclose(loaded.effort_limits, own.effort_limits)
    rng = np.random.default_rng(2)
    for _ in range(5):
        q, v = own.nominal.copy(), rng.normal(size=18)
        q[7:] += 0.2 * rng.normal(size=12)
        one, two = (pinocchio.rnea(r.model, r.model.createData(), q, v, np.ones(18)) for r in (own, loaded))
        np.testing.assert_allclose(one, two, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(loaded.foot_positions(q), own.foot_positions(q), atol=1e-9)
    assert ground_of_recording(recording) is not None


def test_a_recording_is_replayed_without_a_name(recording: Any) -> None:
    report = sf.replay_log(recording, "mujoco-exact")
    assert report.survives, report.sentence
    assert (report.world, report.own) == ("mujoco-exact", "mujoco")
    assert {w.outcome for w in report.windows} == {"done"}
    assert report.logs[0].fact("unsolved_steps") == 0


@pytest.mark.parametrize(
    ("facts", "told"),
    [
        ({"model_inertias": None}, "no fact model_inertias"),
        ({"model_joint_kinds": ["free", *["other"] * 12]}, "no free base with hinges"),
        ({"gravity": np.array([0.0, 0.0, -1.6])}, "gravity"),
        ({"model_geom_types": 7.0}, "does not keep"),
        ({"change_kind": ["mass"]}, "changed masses"),
    ],
)
def test_a_model_that_is_no_robot_is_refused_in_a_line(
    recording: Any, facts: dict[str, Any], told: str
) -> None:
    other = changed(recording)
    for name, value in facts.items():
        if value is None:
            del other.facts[name]
        elif name == "model_geom_types":
            other.facts[name] = np.full(len(other.facts["model_geoms"]), value)
        else:
            other.facts[name] = value
    with pytest.raises(ProblemError, match=told):
        sf.replay_log(other, "mujoco-exact")


def test_ground_that_is_not_level_is_asked_for(recording: Any) -> None:
    tilted = np.asarray(recording["normals"]) + np.array([0.2, 0.0, 0.0])
    other = changed(recording, normals=tilted / np.linalg.norm(tilted, axis=-1, keepdims=True))
    assert ground_of_recording(other) is None
    with pytest.raises(ProblemError, match="give terrain"):
        sf.replay_log(other, "mujoco-exact")


def test_feet_that_are_meshes_come_back_as_their_hulls(tmp_path: Path) -> None:
    """Bricks of twelve vertices, four of them inside: the log's robot stands on the other eight."""
    corners = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    inner = [(x, 0.3, 0.2) for x in (-0.4, -0.1, 0.2, 0.5)]
    vertices = " ".join(str(number) for corner in [*corners, *inner] for number in corner)
    mesh = f'<asset><mesh name="brick" vertex="{vertices}" scale="0.03 0.02 0.02"/></asset>\n  <worldbody>'
    text = SERVOS.read_text().replace("<worldbody>", mesh, 1)
    text, count = re.subn(r'type="sphere" size="0.0\d+"', 'type="mesh" mesh="brick"', text)
    assert count == 1  # the class of all four
    path = tmp_path / "bricks.xml"
    path.write_text(text)
    own = sf.load_robot(path, feet=FEET)
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    data.qpos[2] = 0.5
    with sf.record(model, data) as log:  # it falls, and touches with all feet
        for _ in range(400):
            mujoco.mj_step(model, data)
    log.save(tmp_path / "loop.npz")
    read = sf.read_log(tmp_path / "loop.npz")
    assert len(read.facts["model_hull_corners"]) == 32
    loaded = robot_of_recording(read)
    np.testing.assert_allclose(loaded.foot_positions(own.nominal), own.foot_positions(own.nominal), atol=1e-6)
