"""A published policy on its publisher's model: what it sees, when it is asked, and what it drives."""

from __future__ import annotations

import json
from pathlib import Path

import mujoco
import numpy as np
import pytest

import surefoot as sf
from benchmarks.publisher_loop import PublisherLoop, main, on_a_floor, walked
from surefoot.base.errors import ProblemError
from surefoot.base.spatial import rotation_from_quaternion
from surefoot.mechanics import Robot
from tests.motion.policy.onnx_file import write_onnx

pytest.importorskip("onnxruntime")
MOTORS = [f"{leg}_{part}_joint" for leg in ("FR", "FL", "RR", "RL") for part in ("hip", "thigh", "calf")]
POSE = np.tile([0.0, 0.8, -1.5], 4)
SPEC = {
    "joints": MOTORS, "default": POSE.tolist(), "stiffness": 20, "damping": 0.5, "action_scale": 0.25,
    "observations": ["angular_velocity", "gravity", "command", "joint_positions", "joint_velocities",
                     "last_action"],
}  # fmt: skip


def robot_file(folder: Path, drive: str, names: list[str] = MOTORS, mesh: str = "drawn") -> Path:
    """Write a trunk with twelve joints in a file of its own order, and what drives them."""
    legs = "".join(
        f'<body pos="{0.01 * k} 0 0"><joint name="{name}" armature="0.1"/>'
        '<geom size="0.01" mass="0.01"/></body>'
        for k, name in enumerate(names)
    )
    gain = 'kp="1"' if drive == "position" else ""
    drives = "".join(f'<{drive} joint="{name}" {gain}/>' for name in names[::-1])
    touches = 'contype="0" conaffinity="0"' if mesh == "drawn" else ""
    path = folder / "robot.xml"
    path.write_text(f"""<mujoco><option timestep="0.004" gravity="0 0 0"/>
<asset><mesh name="m" file="missing.stl"/></asset>
<worldbody><body name="trunk"><freejoint/><geom size="0.1" mass="5"/>
<geom type="mesh" mesh="m" {touches}/>{legs}</body></worldbody><actuator>{drives}</actuator></mujoco>""")
    return path


@pytest.fixture
def policy(go2: Robot, tmp_path: Path) -> sf.Policy:
    """A policy whose first action is 0.1 and grows by as much whenever it is asked."""
    network = write_onnx(tmp_path / "go2_net.onnx", np.eye(45, 12, k=-33), np.full(12, 0.1))
    return sf.Policy(network, SPEC, go2, dt=4e-3)


@pytest.mark.parametrize("mesh", ["drawn", "touching"])
def test_a_model_without_its_meshes_stands_on_a_floor(
    tmp_path: Path, mesh: str, capsys: pytest.CaptureFixture[str]
) -> None:
    model = on_a_floor(robot_file(tmp_path, "motor", mesh=mesh), 0.7)
    assert model.nmesh == 0
    floor = model.geom("floor")
    assert (floor.contype, floor.conaffinity, floor.condim, floor.friction[0]) == (1, 0, 3, 0.7)
    assert ("left out" in capsys.readouterr().err) is (mesh == "touching")


def test_a_policy_sees_its_own_axes_and_joints(tmp_path: Path, policy: sf.Policy) -> None:
    """Whatever the order of the file; joints that it lacks are where the policy wants them."""
    names = ["spare", *MOTORS[::-1]]
    model = on_a_floor(robot_file(tmp_path, "motor", names), 0.7)
    data, loop = mujoco.MjData(model), PublisherLoop(model, policy)
    data.qpos[:] = loop.start
    data.qpos[3:7] = np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)  # turned to the left
    data.qvel[:6] = 1.0, 0.0, 0.0, 0.0, 0.3, 0.0
    data.joint("RR_calf_joint").qpos, data.joint("FL_hip_joint").qvel = -1.3, 0.7
    state, robot = loop.state(data), policy.robot
    np.testing.assert_allclose(state.v[:6], [0.0, -1.0, 0.0, 0.0, 0.3, 0.0], atol=1e-12)
    np.testing.assert_allclose(rotation_from_quaternion(state.q[3:7])[:, 0], [0.0, 1.0, 0.0], atol=1e-12)
    joints = dict(zip(robot.joint_names, state.q[7:], strict=True))
    assert joints.pop("RR_calf_joint") == -1.3
    assert [joints[name] for name in MOTORS if name in joints] == pytest.approx(np.delete(POSE, 8))
    np.testing.assert_allclose(state.v[6:], 0.7 * (np.array(robot.joint_names) == "FL_hip_joint"))


@pytest.mark.parametrize("drive", ["motor", "position"])
def test_servos_get_targets_and_motors_torques_of_each_step(
    tmp_path: Path, policy: sf.Policy, drive: str
) -> None:
    model = on_a_floor(robot_file(tmp_path, drive), 0.7)
    data, loop = mujoco.MjData(model), PublisherLoop(model, policy)
    data.qpos[:] = loop.start
    for k in range(11):
        loop(model, data)
        targets = POSE + 0.25 * 0.1 * (1 + k // 5)  # every 20 ms, of steps of 4
        joint = [data.joint(name) for name in MOTORS]
        pull = 20.0 * (targets - [j.qpos[0] for j in joint]) - 0.5 * np.array([j.qvel[0] for j in joint])
        asked = {model.joint(model.actuator_trnid[a, 0]).name: data.ctrl[a] for a in range(model.nu)}
        found = [asked[name] for name in MOTORS]
        np.testing.assert_allclose(found, pull if drive == "motor" else targets, atol=1e-6)
        mujoco.mj_step(model, data)
    loop.reset()
    data.time = 0.0
    loop(model, data)
    if drive == "position":
        np.testing.assert_allclose(data.ctrl[::-1], POSE + 0.025, atol=1e-6)


def test_a_model_of_another_robot_is_refused(tmp_path: Path, policy: sf.Policy) -> None:
    other = on_a_floor(robot_file(tmp_path, "motor", [f"j{k}" for k in range(12)]), 0.7)
    with pytest.raises(ProblemError, match="the model has no joint FR_hip_joint, FR_thigh_joint"):
        PublisherLoop(other, policy)


def test_a_walk_succeeds_that_is_upright_and_went_half_the_way(tmp_path: Path) -> None:
    model = on_a_floor(robot_file(tmp_path, "motor"), 0.7)
    data = mujoco.MjData(model)
    for x, z, expected in ((1.2, 0.28, True), (0.8, 0.28, False), (1.2, 0.1, False)):
        data.qpos[0], data.qpos[2] = x, z
        assert walked(4.0, 0.28)(model, data) is expected


@pytest.mark.parametrize("wrong", ["model", "network", "both"])
def test_wrong_files_are_one_line(
    tmp_path: Path, wrong: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    network = write_onnx(tmp_path / "go2_net.onnx", np.eye(45, 12, k=-33), np.full(12, 0.1))
    (tmp_path / "go2_net.yaml").write_text(json.dumps(SPEC))
    text = tmp_path / "text.xml"
    text.write_text("no model")
    files = {"model": (text, network), "network": (robot_file(tmp_path, "motor"), text)}
    model, given = files.get(wrong, (tmp_path / "none.xml", tmp_path / "none.onnx"))
    monkeypatch.setattr("sys.argv", ["publisher_loop", str(model), str(given)])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 2
    last = capsys.readouterr().err.strip().splitlines()[-1]
    assert "error: " in last
    assert (text.name if wrong != "both" else "none.xml") in last
