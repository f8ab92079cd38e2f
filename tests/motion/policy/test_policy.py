"""Learned policies: what publishers' files mean, what the network is fed with, and what is refused."""

from __future__ import annotations

import importlib.util
import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

import surefoot as sf
from benchmarks.stacks.learned import LearnedStack
from benchmarks.stacks.tasks import TASKS
from benchmarks.stacks.trial import carry_out
from surefoot.app.cli.main import main
from surefoot.base.errors import ProblemError
from surefoot.base.spatial import quaternion_from_rotation, rotation_exp, rotation_from_quaternion
from surefoot.mechanics.robot import Robot
from surefoot.motion.control.controller import RobotState
from surefoot.motion.policy.publishers import read_description
from surefoot.motion.policy.spec_keys import PolicyKeys
from tests.motion.policy.onnx_file import write_onnx
from tests.pages import run_page

pytest.importorskip("onnxruntime")
SHARED = Path(__file__).parents[4] / "shared" / "policies"
MOTORS = [f"{leg}_{part}_joint" for leg in ("FR", "FL", "RR", "RL") for part in ("hip", "thigh", "calf")]
POSE = np.tile([0.0, 0.8, -1.5], 4)
PLAIN: dict[str, Any] = {
    "joints": MOTORS, "default": POSE.tolist(), "stiffness": 20, "damping": 0.5, "action_scale": 0.25,
    "observations": ["angular_velocity", "gravity", "command", "joint_positions", "joint_velocities",
                     "last_action"],
}  # fmt: skip


def net(folder: Path, size: int = 45, actions: int = 12, **more: Any) -> Path:
    """Write a network whose first actions are its last inputs, and 0.1 more."""
    return write_onnx(
        folder / "go2_net.onnx", np.eye(size, actions, k=actions - size), np.full(actions, 0.1), **more
    )


def state(robot: Robot, seed: int = 0, time: float = 0.0) -> RobotState:
    """Return a state like no other, leaning, in motion."""
    r = np.random.default_rng(seed)
    q = robot.nominal + np.concatenate([np.zeros(7), 0.1 * r.normal(size=robot.joints)])
    q[3:7] = quaternion_from_rotation(rotation_exp(0.3 * r.normal(size=3)))
    return RobotState(q, r.normal(size=robot.model.nv), time, np.array([True, False, True, True]))


def terms_of(robot: Robot, one: RobotState, joints: list[str], default: np.ndarray) -> dict[str, np.ndarray]:
    """Return what terms should be, from the rotation matrix and by name."""
    at = [robot.joint_names.index(name) for name in joints]
    R = rotation_from_quaternion(one.q[3:7])
    return {
        "w": one.v[3:6], "g": R.T @ [0.0, 0.0, -1.0], "q": one.q[7:][at] - default,
        "dq": one.v[6:][at], "v": one.v[:3],
    }  # fmt: skip


def test_rl_sar_stacks_time_after_time_the_newest_first(go2: Robot, tmp_path: Path) -> None:
    mapping = [3, 4, 5, 0, 1, 2, 9, 10, 11, 6, 7, 8]
    said = {
        "observations": ["commands", "ang_vel", "gravity_vec", "dof_pos", "dof_vel", "actions"],
        "observations_history": [0, 1, 2], "observations_history_priority": "time", "clip_obs": 0.9,
        "clip_actions_lower": [-0.2] * 12, "clip_actions_upper": [0.2] * 12, "rl_kp": [40] * 12,
        "rl_kd": [1] * 12, "action_scale": [0.125, 0.25, 0.25] * 4, "wheel_indices": [], "lin_vel_scale": 2.0,
        "ang_vel_scale": 0.25, "dof_pos_scale": 1.0, "dof_vel_scale": 0.05,
        "commands_scale": [2.0, 2.0, 0.25], "default_dof_pos": POSE.tolist(), "joint_mapping": mapping,
    }  # fmt: skip
    network = net(tmp_path, 135)
    network.with_suffix(".yaml").write_text(yaml.safe_dump({"go2/x": said}))
    policy = sf.Policy(network, command=(0.3, 0.1, 0.2))
    joints = [MOTORS[k] for k in mapping]
    assert list(policy.spec.joints) == joints
    expected = []
    action = np.zeros(12)
    for k in range(2):
        one = state(go2, k, 0.02 * k)
        t = terms_of(go2, one, joints, POSE)
        now = [[0.6, 0.2, 0.05], 0.25 * t["w"], t["g"], t["q"], 0.05 * t["dq"], action]
        expected.insert(0, np.clip(np.concatenate(now), -0.9, 0.9))
        fed = policy._feed(policy._senses(one))
        policy._action = action = np.linspace(-0.1, 0.1, 12)
    assert fed == pytest.approx(np.concatenate([*expected, np.zeros(45)]), abs=1e-12)


def test_unitrees_yaml_is_read_without_running_its_tags(tmp_path: Path) -> None:
    g1 = sf.load_robot("g1")
    order = [*range(28, -1, -1)]
    text = yaml.safe_dump({
        "joint_ids_map": order, "step_dt": 0.01, "stiffness": [*range(1, 30)], "damping": [2.0] * 29,
        "default_joint_pos": [0.0] * 29,
        "commands": {"base_velocity": {"ranges": {
            "lin_vel_x": [-0.5, 1.0], "lin_vel_y": [-0.3, 0.3], "ang_vel_z": [-0.2, 0.2]}}},
        "observations": {
            "base_ang_vel": {"params": {}, "clip": [-1, 1], "scale": [0.2] * 3, "history_length": 3},
            "last_action": {"params": {}, "clip": None, "scale": [1.0] * 29, "history_length": 2}},
    }, sort_keys=False)  # fmt: skip
    made = tmp_path / "made-by-a-tag"
    (tmp_path / "g1.yaml").write_text(
        text + "actions:\n  JointPositionAction:\n    clip: null\n    scale: 0.25\n    offset: 0.0\n"
        f"    joint_ids: !!python/object/apply:os.mkdir [{made}]\n"
    )
    network = net(tmp_path, 67, 29)
    policy = sf.Policy(network, tmp_path / "g1.yaml", g1, (2.0, 0.0, 0.0))
    assert not made.exists()
    assert policy.spec.joints == g1.joint_names[::-1]
    assert policy.spec.stiffness.tolist() == [*range(29, 0, -1)]  # the file has them by motor
    assert policy.spec.rate == pytest.approx(100.0)
    assert policy.step(RobotState(policy.posture, np.zeros(35))).wanted.tolist() == [1.0, 0.0, 0.0]
    policy.reset()
    turns = [np.array([0.1 * k, -2.0, 0.0]) for k in range(3)]
    for turn in turns:
        fed = policy._feed(
            policy._senses(RobotState(policy.posture, np.r_[0.0, 0.0, 0.0, turn, np.zeros(29)]))
        )
    assert fed[:9] == pytest.approx(0.2 * np.clip(np.concatenate(turns), -1, 1))  # the oldest first


def test_legged_gyms_clock_and_memory_of_the_first_value(go2: Robot, tmp_path: Path) -> None:
    said = {
        "kps": [20] * 12, "kds": [0.5] * 12, "default_angles": POSE.tolist(), "ang_vel_scale": 0.25,
        "num_obs": 47, "dof_pos_scale": 1.0, "dof_vel_scale": 0.05, "action_scale": 0.25,
        "cmd_scale": [2.0, 2.0, 0.25], "num_actions": 12, "simulation_dt": 0.002, "control_decimation": 10,
    }  # fmt: skip
    spec = tmp_path / "other.yaml"
    spec.write_text(yaml.safe_dump(said))
    policy = sf.Policy(net(tmp_path, 47), spec, "go2")
    fed = policy._feed(policy._senses(state(go2, time=0.3)))
    assert fed[-2:] == pytest.approx([math.sin(0.75 * math.pi), math.cos(0.75 * math.pi)])
    assert policy.spec.joints == go2.joint_names


@pytest.mark.parametrize("spelling", ["csv", "json"])
def test_metadata_alone_is_enough(go2: Robot, tmp_path: Path, spelling: str) -> None:
    values: dict[str, list[Any]] = {
        "joint_names": MOTORS, "joint_stiffness": [20.0] * 12, "joint_damping": [0.5] * 12,
        "default_joint_pos": POSE.tolist(), "action_scale": [0.25] * 12,
        "observation_names": ["base_lin_vel", "base_ang_vel", "projected_gravity", "joint_pos", "joint_vel",
                              "actions", "command"],
    }  # fmt: skip
    texts = {k: json.dumps(v) if spelling == "json" else ",".join(map(str, v)) for k, v in values.items()}
    policy = sf.Policy(net(tmp_path, 48, metadata=texts), robot=go2)
    one = state(go2)
    t = terms_of(go2, one, MOTORS, POSE)
    policy._asked = np.array([0.5, 0.0, 0.1])
    parts = [t["v"], t["w"], t["g"], t["q"], t["dq"], np.zeros(12), [0.5, 0.0, 0.1]]
    assert policy._feed(policy._senses(one)) == pytest.approx(np.concatenate(parts))


def test_the_robot_that_is_assumed_is_named(tmp_path: Path, answer: Any, printed: Any) -> None:
    network = write_onnx(tmp_path / "my_net.onnx", np.zeros((45, 12)), np.zeros(12))
    assert answer("policy", "describe", network, code=1)["robot_from"] == "assumed"
    said = " ".join(printed("policy", "describe", network, code=1).split())
    assert "robot: go2, assumed, since the file's name says none; or --robot NAME" in said
    assert "assumed, since" not in printed("policy", "describe", network, "--robot", "go2", code=1)


def test_gains_and_names_recognise_a_convention(tmp_path: Path, answer: Any) -> None:
    g1 = sf.load_robot("g1")
    told = {
        "dof_names": json.dumps(g1.joint_names),
        "kp": json.dumps([40.0] * 29),
        "kd": json.dumps([1.0] * 29),
    }
    network = write_onnx(tmp_path / "g1.onnx", np.zeros((100, 29)), np.zeros(29), told, "actor_obs")
    facts = answer("policy", "describe", network)
    assert (facts["robot"], facts["robot_from"]) == ("g1", "the file's name")
    assert facts["sources"]["stiffness"] == "the network's metadata"
    assert facts["sources"]["observations"] == "assumed: convention holosoma"
    other = write_onnx(tmp_path / "g1_other.onnx", np.zeros((99, 29)), np.zeros(29), told, "actor_obs")
    missing = answer("policy", "describe", other, code=1)["missing"]
    assert missing == ["default", "action_scale", "observations"]
    with pytest.raises(ProblemError, match="nothing says its default, action_scale, observations"):
        sf.Policy(other)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"joints": [*MOTORS[:-1], "tail_joint"]}, "tail_joint"),
        ({"joints": [*MOTORS[:-1], MOTORS[0]]}, "FR_hip_joint twice"),
        ({"joints": MOTORS[:-1], "default": POSE[:-1].tolist()}, "42 numbers .*, go2_net.onnx takes 45"),
        ({"joints": [*MOTORS[2::-1], *MOTORS[3:]]}, "default of FR_calf_joint is 0"),
        ({"default": POSE[:-1].tolist()}, "default has 11 values for 12 joints"),
        ({"stiffness": {".*hip.*": 20}}, "stiffness has no entry for the joint FR_thigh_joint"),
        ({"observations": PLAIN["observations"][1:]}, "42 numbers .gravity 3, .* takes 45"),
        ({"observations": ["smell"]}, "unknown observation 'smell'"),
        ({"observations": [{"command": {"scale": [1, 2]}}]}, "scale of command has 2 values for 3"),
        ({"history": {"order": "random"}}, "unknown order 'random'"),
        ({"gain": 3}, "unknown key 'gain'"),
        ({"rate": 0}, "rate must be"),
        ({"action_scale": None}, "nothing says its action_scale"),
        ({"convention": "mine"}, "unknown convention 'mine'"),
        ({"command_range": [1, 2]}, "command_range must have shape"),
        ({"joints": 3}, "the policy: joints must be a list, got 3"),
        ({"stiffness": True}, "stiffness must be a number, a list or a mapping of names, got True"),
        ({"stiffness": {".*": "stiff"}}, r"stiffness: \.\* must be a number, got 'stiff'"),
        ({"damping": {"*": 1}}, r"damping: '\*' is no pattern of names: nothing to repeat"),
        ({"action_clip": [-1, None]}, r"action_clip\[1\] must be a number, a list or a mapping of names"),
        ({"observations": 3}, "observations must be a list, got 3"),
        ({"observations": [["gravity"]]}, r"observations\[0\] must be a name, or a name with its settings"),
        ({"observations": [{"gravity": {"clip": 1}}]}, "gravity: clip must be a list of 2 entries, got 1"),
        ({"observations": [{"phase": {"waves": ["saw"]}}]}, r"waves\[0\] 'saw'; valid names: cos, sin"),
        ({"observations": [{"gravity": {"scal": 1}}]}, "gravity: unknown key 'scal'; .* did you mean scale"),
        ({"history": [3]}, "history must be a mapping of the keys length, order, by, start"),
        ({"history": {"length": "long"}}, "history: length must be a whole number >= 1, got 'long'"),
        ({"others": {"stifness": 1}}, "others: unknown key 'stifness'; .* did you mean stiffness"),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_named(
    go2: Robot, tmp_path: Path, changed: dict[str, Any], message: str
) -> None:
    with pytest.raises(ProblemError, match=message):
        sf.Policy(net(tmp_path), PLAIN | changed, go2)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (
            {"default_angles": [0], "kps": [1], "num_actions": "many", "num_obs": 3},
            "not as its publisher writes",
        ),
        ({"joint_ids_map": [0] * 12, "actions": {"a": {}, "b": {}}}, "not as its publisher writes"),
        ({"one": {"rl_kp": [1]}}, "not as its publisher writes .*: KeyError"),
        ({"joint_ids_map": [0]}, "joint_ids_map has 1 joints, go2 12 motors"),
    ],
)
def test_a_publishers_file_of_another_form_is_one_line(
    go2: Robot, tmp_path: Path, content: dict[str, Any], message: str
) -> None:
    path = tmp_path / "a.yaml"
    path.write_text(yaml.safe_dump(content))
    with pytest.raises(ProblemError, match=message):
        read_description(path, go2)


def test_another_order_than_the_metadatas_is_named(go2: Robot, tmp_path: Path) -> None:
    network = net(tmp_path, metadata={"joint_names": ",".join(go2.joint_names)})
    with pytest.raises(ProblemError, match=r"joint 0 of the policy is FR_hip_joint .* FL_hip_joint"):
        sf.Policy(network, PLAIN, go2)


def test_actions_become_targets_at_the_policys_rate(go2: Robot, tmp_path: Path) -> None:
    policy = sf.Policy(net(tmp_path), PLAIN, go2, dt=1e-4)
    at = [go2.joint_names.index(name) for name in MOTORS]
    action, seen = np.zeros(12), []
    for k in range(50):
        one = state(go2, k, 1e-3 * k)._replace(v=np.zeros(18))
        command = policy.step(one)
        if k % 20 == 0:
            action = action + 0.1  # the network's last inputs are its last answer
        targets = command.joint_targets
        assert targets is not None
        assert targets.positions[at] == pytest.approx(POSE + 0.25 * action, abs=1e-6)
        pull = np.clip(20.0 * (targets.positions - one.q[7:]), -go2.effort_limits, go2.effort_limits)
        assert command.torques == pytest.approx(pull)
        seen.append(command.attained)
    assert all(seen)
    blind = policy.step(state(go2, time=0.05)._replace(q=np.full(19, np.nan)))
    assert not blind.attained
    assert np.isfinite(blind.torques).all()
    policy.reset()
    assert policy.step(state(go2)).joint_targets.positions[at] == pytest.approx(POSE + 0.025)  # type: ignore[union-attr]


def test_scan_contacts_and_terms_of_the_users(go2: Robot, tmp_path: Path) -> None:
    grid = {"x": [0.0, 0.4], "y": [-0.1, 0.1], "offset": 0.2}
    spec = PLAIN | {"observations": [{"height_scan": grid}, "foot_contact", {"mine": {"scale": 2}}]}
    slope = sf.SlopeTerrain(0.2)
    policy = sf.Policy(net(tmp_path, 9, 12), spec, go2, terrain=slope, terms={"mine": lambda s: s.v[2:3]})
    q = go2.nominal.copy()
    q[:3], q[3:7] = [1.0, 2.0, 0.9], quaternion_from_rotation(rotation_exp(np.array([0.0, 0.0, math.pi / 2])))
    one = RobotState(q, np.arange(18.0), contact=np.array([True, False, True, True]))
    places = [(1.1, 2.0), (0.9, 2.0), (1.1, 2.4), (0.9, 2.4)]  # turned a quarter to the left
    heights = [0.9 - float(slope.height(place)) - 0.2 for place in places]
    assert policy._feed(policy._senses(one)) == pytest.approx([*heights, 1.0, 0.0, 1.0, 1.0, 4.0])


def test_the_page_lists_every_key() -> None:
    page = (Path(__file__).parents[3] / "docs" / "policies.md").read_text(encoding="utf-8")
    assert [key for key in PolicyKeys.__annotations__ if f"`{key}`" not in page] == []


def test_the_page_runs_with_its_own_description(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    page = (Path(__file__).parents[3] / "docs" / "policies.md").read_text(encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    Path("my_policy.yaml").write_text(page.split("```yaml\n")[1].split("```")[0])
    write_onnx(Path("my_policy.onnx"), np.zeros((141, 12)), np.zeros(12))
    names = run_page("policies.md")
    assert names["log"].fact("outcome") == "done"
    assert names["policy"].spec.default.tolist() == POSE.tolist()


def test_code_runs_only_for_who_trusts_it(tmp_path: Path, printed: Any) -> None:
    (tmp_path / "go2.pt").write_bytes(b"x")
    assert "--trust" in printed("walk", "--policy", tmp_path / "go2.pt", "--out", tmp_path, code=2)
    if importlib.util.find_spec("torch") is None:
        assert ".[torch]" in printed("policy", "describe", tmp_path / "go2.pt", "--trust", code=2)


@pytest.mark.shared
@pytest.mark.parametrize(
    ("name", "spec"),
    [("go2_robot_lab", None), ("go2_himloco", None), ("unitree_rl_lab_g1", None),
     ("playground_go1", "playground_go1.yaml")],
)  # fmt: skip
@pytest.mark.sampled(2)
def test_published_policies_walk_from_their_files(name: str, spec: str | None, tmp_path: Path) -> None:
    network = SHARED / f"{name}.onnx"
    if not network.exists():
        pytest.skip("needs the networks beside the checkout")
    own = (
        []
        if spec is None
        else ["--policy-spec", str(Path(__file__).parents[3] / "examples" / "policies" / spec)]
    )
    arguments = ["walk", "--policy", str(network), *own, "--duration", "3", "--no-video", "--no-report"]
    assert main([*arguments, "--out", str(tmp_path)]) in (0, 1)
    log = sf.read_log(next(tmp_path.glob("*/log.npz")))
    assert log.fact("outcome") == "done"
    assert log["q"][-1, 0] > 0.8
    broken = {one.law for one in sf.audit_log(log).violations}
    assert not broken or (name == "unitree_rl_lab_g1" and broken == {"restitution"})  # of MuJoCo's, at times


def test_a_policy_is_a_stack_among_others(tmp_path: Path) -> None:
    network = net(tmp_path)
    network.with_suffix(".yaml").write_text(yaml.safe_dump(PLAIN | {"action_scale": 0.0}))
    stack = LearnedStack(network)
    assert stack.walks("go2")
    assert stack.missing() == ""
    trial = carry_out(stack, replace(TASKS["speed-0.5"], duration=0.3), 0)
    assert trial.upright
    assert 0.25 < trial.measures.load < 1.0  # a foot of a standing robot carries a quarter at least
