"""What a recording keeps of its model: the equations of motion come out of it, feet, torques, changes."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
import pinocchio
import pytest

import surefoot as sf
from surefoot.base.spatial import quaternion_xyzw
from surefoot.records.audit.logged_robot import LoggedRobot, from_recording
from surefoot.worlds.mujoco.record_tree import BodyTree
from tests.worlds.mujoco.strangers import QUADRUPED, STANCE, crate, quadruped


@pytest.fixture(scope="module")
def stood() -> sf.Log:
    return quadruped(400)


def test_the_kept_model_moves_as_mujoco_s(stood: sf.Log) -> None:
    """Mass matrix, weight and gyroscopic forces of random states, by Pinocchio from the log, by MuJoCo."""
    robot = from_recording(stood, np.asarray(stood.facts["contact_foot"]))
    assert isinstance(robot, LoggedRobot)
    model = mujoco.MjModel.from_xml_string(QUADRUPED)
    data, rng = mujoco.MjData(model), np.random.default_rng(3)
    for _ in range(5):
        data.qpos[:3], data.qpos[7:] = rng.normal(size=3), rng.normal(size=12)
        turn = rng.normal(size=4)
        data.qpos[3:7] = turn / np.linalg.norm(turn)
        data.qvel[:] = rng.normal(size=18)
        mujoco.mj_forward(model, data)
        R = data.xmat[1].reshape(3, 3)
        q = np.concatenate([data.qpos[:3], quaternion_xyzw(data.qpos[3:7]), data.qpos[7:]])
        to_world = np.eye(18)
        to_world[:3, :3] = R  # MuJoCo's linear velocity is the world's, Pinocchio's the base's
        full = np.zeros((18, 18))
        for k in range(18):
            mujoco.mj_mulM(model, data, full[k], np.eye(18)[k])
        full -= np.diag(model.dof_armature)
        own = robot.model.createData()
        M = pinocchio.crba(robot.model, own, q)
        M = np.triu(M) + np.triu(M, 1).T
        assert np.allclose(M, to_world.T @ full @ to_world, atol=1e-9)
        com = pinocchio.centerOfMass(robot.model, own, q)
        assert np.allclose(com, data.subtree_com[1], atol=1e-12)


def test_motion_is_judged_without_a_robot_s_file(stood: sf.Log) -> None:
    report = sf.audit_log(stood)
    assert not report.coverage["motion"]
    assert report.lawful, report.sentence


def test_a_fall_is_judged_on_all_that_touches(tmp_path: Any) -> None:
    """Links that are no feet touch in a fall: with the file, by name, and alone the motion is judged."""

    def cut(model: Any, data: Any, step: int) -> None:
        data.ctrl[:] *= step < 200

    log = quadruped(800, cut)
    assert not np.asarray(log.facts["contact_is_foot"]).all()
    (tmp_path / "stray.xml").write_text(QUADRUPED)
    for robot in (None, sf.load_robot(tmp_path / "stray.xml")):
        report = sf.audit_log(log, robot)
        assert not report.coverage["motion"], report.coverage["motion"]
        assert report.verdict == "lawful", report.sentence
        assert report.task != "attained"


def test_feet_are_the_ends_of_limbs(stood: sf.Log) -> None:
    touched = {str(stood.facts["feet"][k]) for k in stood.facts["contact_foot"]}
    assert touched == {"fl", "fr", "rl", "rr"}
    assert np.asarray(stood.facts["contact_is_foot"]).all()
    assert set(map(str, stood.facts["contact_body"])) == {f"{n}_shin" for n in touched}


def test_what_is_asked_for_is_kept_beyond_the_limit() -> None:
    def shout(model: Any, data: Any, step: int) -> None:
        data.ctrl[3] = 50.0

    log = quadruped(5, shout)
    assert np.allclose(log["torques_commanded"][:, 3], 50.0)
    assert np.allclose(log["torques"][:, 3], 30.0)
    assert np.allclose(log.facts["model_torque_limits"], 30.0)


@pytest.mark.parametrize(
    ("change", "kind", "name"),
    [
        (lambda m: m.body_mass.__setitem__(1, 2.0 * m.body_mass[1]), "mass", "torso"),
        (lambda m: m.actuator_gainprm.__setitem__((2, 0), 0.5), "gain", "m_fl_knee"),
        (lambda m: m.geom_friction.__setitem__((0, 0), 0.2), "friction", "floor"),
    ],
    ids=["mass", "gain", "friction"],
)  # fmt: skip
def test_changes_of_the_model_are_dated(change: Any, kind: str, name: str) -> None:
    def hook(model: Any, data: Any, step: int) -> None:
        if step == 30:
            change(model)

    log = quadruped(60, hook)
    assert [str(k) for k in log.facts["change_kind"]] == [kind]
    assert [str(n) for n in log.facts["change_name"]] == [name]
    assert log.facts["change_time"][0] == pytest.approx(0.06)


def test_weight_that_is_put_on_breaks_no_law() -> None:
    def load(model: Any, data: Any, step: int) -> None:
        if step == 200:
            model.body_mass[1] += 2.0

    report = sf.audit_log(quadruped(400, load))
    assert report.lawful, report.sentence
    assert "changed masses" in report.coverage["centre of mass"]


@pytest.mark.long
def test_the_robot_is_what_actuators_drive() -> None:
    text = QUADRUPED.replace(
        "</worldbody>",
        "<body name='sack' pos='0 0 2'><freejoint/><geom size='.1' mass='90'/></body></worldbody>",
    )
    model = mujoco.MjModel.from_xml_string(text)
    assert BodyTree(mujoco, model, None).name == "torso"
    assert crate(steps=3).facts["model_bodies"] == ["crate"]
    assert len(STANCE) == 12


def test_hulls_of_meshes_are_kept_where_they_may_touch() -> None:
    """The farthest corner in every direction is the mesh's own; shapes that touch nothing keep none."""
    points = np.random.default_rng(5).normal(size=(60, 3)) * (0.1, 0.2, 0.05)
    vertices = " ".join(f"{x:.6f}" for x in points.ravel())
    model = mujoco.MjModel.from_xml_string(f"""<mujoco>
<asset><mesh name='rock' vertex='{vertices}'/><mesh name='veil' vertex='{vertices}' scale='2 2 2'/></asset>
<worldbody><geom type='plane' size='5 5 1'/><body pos='0 0 .4'><freejoint/>
<geom name='ball' size='.02' pos='0 0 .3' mass='.1'/>
<geom name='shell' type='mesh' mesh='rock' pos='.1 0 0' euler='30 0 20' mass='2'/>
<geom type='mesh' mesh='veil' mass='0' contype='0' conaffinity='0'/></body></worldbody></mujoco>""")
    data = mujoco.MjData(model)
    with sf.record(model, data) as log:
        for _ in range(5):
            mujoco.mj_step(model, data)
    kept, owners = np.asarray(log.facts["model_hull_corners"]), np.asarray(log.facts["model_hull_geoms"])
    assert list(log.facts["model_geoms"])[int(owners[0])] == "shell"
    assert (owners == owners[0]).all()
    mesh = int(model.geom("shell").dataid[0])
    own = model.mesh_vert[model.mesh_vertadr[mesh] :][: model.mesh_vertnum[mesh]]
    ways = np.random.default_rng(6).normal(size=(200, 3))
    np.testing.assert_allclose((ways @ kept.T).max(axis=1), (ways @ own.T).max(axis=1), atol=1e-6)
