"""Recordings of MuJoCo loops that know nothing of Surefoot, against MuJoCo's own numbers and Newton's law."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.errors import ModelError, ProblemError
from surefoot.mechanics.terrain.frames import surface_frames
from tests.worlds.mujoco.recordings import recorded

mujoco = pytest.importorskip("mujoco")

SCENE = """<mujoco><option timestep='0.002' cone='{cone}'/><worldbody>
<geom name='floor' type='plane' size='5 5 1' friction='{mu} 0.005 0.0001'/>
<body name='trunk' pos='0 0 0.25' euler='10 20 30'><freejoint/>
 <geom name='shell' type='box' size='.1 .15 .05' mass='2'/>
 <body name='arm' pos='0.1 0 0'><joint name='elbow' axis='0 1 0' damping='0.1'/>
  <geom type='capsule' fromto='0.05 0 0 .2 0 .1' size='0.02' mass='.5'/></body></body>{more}
</worldbody><actuator><motor joint='elbow'/></actuator></mujoco>"""
BALL = "<body name='ball' pos='1.5 0 .2'><freejoint/><geom name='skin' size='.05' mass='.3'/></body>"


def made(cone: str = "elliptic", mu: float = 0.7, more: str = "") -> tuple[object, object]:
    model = mujoco.MjModel.from_xml_string(SCENE.format(cone=cone, mu=mu, more=more))
    data = mujoco.MjData(model)
    data.qvel[:3] = [1.0, 0.5, 0.0]
    return model, data


def world_forces(log: sf.Log) -> np.ndarray:
    T, p = log["gaps"].shape
    frames = np.empty((T * p, 3, 3))
    surface_frames(np.ascontiguousarray(log["normals"].reshape(-1, 3)), frames)
    return np.einsum("tpij,tpj->tpi", frames.reshape(T, p, 3, 3), log["forces"])


@pytest.mark.parametrize("cone", ["elliptic", "pyramidal"])
@pytest.mark.parametrize("more", ["", BALL])
def test_forces_are_mujocos_and_change_the_momentum(cone: str, more: str) -> None:
    model, data = made(cone, more=more)
    robot = int(model.body("trunk").id)
    shell, floor = int(model.geom("shell").id), int(model.geom("floor").id)
    own, momentum, states = [], [], []
    with sf.record(model, data) as log:
        for k in range(800):
            data.ctrl[:] = 0.2 * np.sin(0.01 * k)
            states.append((data.qpos.copy(), data.qvel.copy()))
            mujoco.mj_step(model, data)
            total, force = np.zeros(3), np.zeros(6)
            for c in range(data.ncon):
                pair = set(data.contact[c].geom.tolist())
                if pair == {floor, shell}:
                    mujoco.mj_contactForce(model, data, c, force)
                    assert data.contact[c].geom[1] == shell
                    total += data.contact[c].frame.reshape(3, 3).T @ force[:3]
            own.append(total)
    assert len(log) == 800
    forces = world_forces(log)
    feet, foot = log.facts["feet"], np.array(log.facts["contact_foot"])
    np.testing.assert_allclose(forces[:, foot == feet.index("shell")].sum(axis=1), own, atol=1e-10)
    assert set(log.facts["contact_with"]) == {"floor"}
    # Newton: the contact forces and m g change the momentum from step to step
    mass, dt = log.fact("mass"), log.fact("dt")
    assert mass == pytest.approx(2.5)
    for qpos, qvel in states:
        data.qpos[:], data.qvel[:] = qpos, qvel
        mujoco.mj_forward(model, data)
        mujoco.mj_subtreeVel(model, data)
        momentum.append(mass * data.subtree_linvel[robot].copy())
    change = np.diff(momentum, axis=0) / dt
    wanted = forces[:-1].sum(axis=1) - np.array([0.0, 0.0, 9.81 * mass])
    rest = slice(600, None)  # settled: the centre moves with the body, so one step is exact to its order
    assert np.abs(change - wanted)[rest].max() < 0.05 * 9.81 * mass
    assert forces[rest, :, 2].sum(axis=1).mean() == pytest.approx(9.81 * mass, rel=5e-3)
    for t in (0, 400, 799):
        np.testing.assert_allclose(log["q"][t, :3], states[t][0][:3])
        np.testing.assert_allclose(log["q"][t, 3:7], states[t][0][[4, 5, 6, 3]])
        assert log["time"][t] == pytest.approx(0.002 * t)
    assert (len(log.doubts) == 1) == bool(more), log.doubts
    assert log.facts["joints"] == ["elbow"]
    np.testing.assert_allclose(log["torques"][:, 0], 0.2 * np.sin(0.01 * np.arange(800)), atol=1e-12)


def test_gaps_and_velocities_are_those_of_the_surface() -> None:
    """A sphere that falls, bounces and slides: all is known in closed form from its state."""
    xml = (
        "<mujoco><worldbody><geom name='floor' type='plane' size='5 5 1'/><body name='ball' pos='0 0 .3'>"
        "<freejoint/><geom name='skin' size='.1' mass='1'/></body></worldbody></mujoco>"
    )
    model = mujoco.MjModel.from_xml_string(xml)
    data = mujoco.MjData(model)
    data.qvel[:] = [0.4, 0.0, 0.0, 0.0, 3.0, 1.0]
    log = recorded(model, 500, data)
    height = log["q"][:, 2]
    np.testing.assert_allclose(log["gaps"][:, 0], height - 0.1, atol=1e-12)
    from surefoot.base.spatial import rotation_from_quaternion

    R = rotation_from_quaternion(log["q"][:, 3:7])
    linear, angular = (np.einsum("tij,tj->ti", R, log["v"][:, at]) for at in (slice(0, 3), slice(3, 6)))
    arm = np.stack(
        [0 * height, 0 * height, np.where(log["gaps"][:, 0] > 0, -0.1, -0.1 - 0.5 * log["gaps"][:, 0])]
    )
    np.testing.assert_allclose(log["contact_velocities"][:, 0], linear + np.cross(angular, arm.T), atol=1e-9)
    assert (log["mu"] == 1.0).all()
    loaded = log["forces"][:, 0, 2] > 0
    assert loaded.any()
    assert (log["gaps"][loaded, 0] <= 0).all()
    assert log.doubts == ()
    np.testing.assert_allclose(log["normals"], np.tile([0, 0, 1.0], (500, 1, 1)), atol=1e-12)


def test_a_robot_is_chosen_and_the_signs_turn_with_it() -> None:
    stack = (
        "<body name='lid' pos='0 0 .6'><freejoint/>"
        "<geom name='slab' type='box' size='.05 .05 .02' mass='.4'/></body>"
    )
    model, data = made(more=stack)
    data.qpos[3:7] = [1, 0, 0, 0]
    data.qpos[2] = 0.06
    data.qvel[:3] = 0.0
    other = mujoco.MjData(model)
    other.qpos[:], other.qvel[:] = data.qpos, data.qvel
    with sf.record(model, data) as trunk, sf.record(model, other, robot="lid") as lid:
        for _ in range(1500):
            mujoco.mj_step(model, data)
            mujoco.mj_step(model, other)
    assert lid.facts["robot"] == "lid"
    assert set(lid.facts["contact_with"]) <= {"shell", "arm:3", "floor"}
    up = world_forces(lid)[-200:].sum(axis=1).mean(axis=0)
    np.testing.assert_allclose(up, [0, 0, 0.4 * 9.81], atol=0.05)
    on_trunk = world_forces(trunk)[-200:].sum(axis=1).mean(axis=0)
    np.testing.assert_allclose(on_trunk, [0, 0, 2.5 * 9.81], atol=0.3)  # its own weight in all


def test_what_cannot_be_recorded_is_told(tmp_path: Path) -> None:
    model, data = made()
    step = mujoco.mj_step
    with pytest.raises(ProblemError, match="no step was seen"), sf.record(model, data):
        pass
    with pytest.raises(ProblemError, match="unknown body 'leg'; valid names: arm, trunk, world"):
        sf.record(model, data, robot="leg")
    with pytest.raises(ProblemError, match="record takes an MjModel and its MjData"):
        sf.record(data, model)
    fixed = mujoco.MjModel.from_xml_string("<mujoco><worldbody><geom size='1'/></worldbody></mujoco>")
    with pytest.raises(ModelError, match="nothing moves"):
        sf.record(fixed, mujoco.MjData(fixed))
    log = sf.record(model, data)
    with suppress(KeyError), log:
        mujoco.mj_step(model, data)
        raise KeyError("mine")
    assert log.facts["outcome"] == "interrupted"
    assert len(log) == 1
    assert mujoco.mj_step is step
    again = sf.read_log(log.save(tmp_path / "log.npz"))
    assert again.facts["error"] == "KeyError: 'mine'"


def test_a_step_told_by_hand_is_recorded_once() -> None:
    model, data = made()
    with sf.record(model, data) as log:
        for _ in range(20):
            mujoco.mj_step1(model, data)
            mujoco.mj_step2(model, data)
            log.step()
    assert len(log) == 20
    with (
        sf.record(model, mujoco.MjData(model)) as other,
        pytest.raises(ProblemError, match="no step was seen"),
        sf.record(model, data),
    ):
        mujoco.mj_step(model, other._data)
    assert len(other) == 1
