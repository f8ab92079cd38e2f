"""How publishers describe their policies, turned into the keys of `surefoot.motion.policy.spec`.

rl_sar's config.yaml, Unitree's deploy.yaml, the configurations of legged_gym's deploy scripts, metadata of
ONNX files as exporters of Isaac Lab, mjlab and holosoma write it, and conventions by name for what no file
says. Nothing of a file is executed. What is taken from a convention is noted as assumed.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from surefoot.base.errors import ProblemError, check_name, shown
from surefoot.base.text_files import parse_yaml, read_text, read_yaml, table_of
from surefoot.mechanics import Robot, robot_names
from surefoot.motion.policy.network import Network

LEGS = ("FR", "FL", "RR", "RL")
"""Order of the legs in Unitree's motors, joints from the hip down."""
SPECS = (".yaml", ".yml")
CONVENTIONS = Path(__file__).with_name("conventions.yaml")
METADATA = {
    "joints": ("joint_names", "dof_names"),
    "default": (
        "default_joint_pos", "default_dof_pos", "default_joint_angles", "default_dof_angles",
        "default_angles",
    ),
    "stiffness": ("joint_stiffness", "kp", "stiffness", "kps"),
    "damping": ("joint_damping", "kd", "damping", "kds"),
    "action_scale": ("action_scale", "policy_action_scale"),
    "action_offset": ("action_offset",),
    "rate": ("rate", "rl_rate", "control_rate", "policy_rate", "control_frequency"),
}  # fmt: skip
"""What exporters call the keys in ONNX metadata."""
RANGES = (("lin_vel_x",), ("lin_vel_y",), ("ang_vel_yaw", "ang_vel_z"))


@dataclass(frozen=True)
class Description:
    """What files say of a policy.

    Attributes
    ----------
    table
        In the keys of `surefoot.motion.policy.spec_keys.PolicyKeys`.
    sources
        Of each key: where it was read.
    """

    table: dict[str, Any]
    sources: dict[str, str]


def describe(network: Network, spec: Path | Mapping[str, Any] | None, robot: Robot) -> Description:
    """Return what a description, the network's metadata and a convention say, the first that says a key.

    Raises
    ------
    ProblemError
        For a description that is none, or that names other joints than the metadata.
    """
    stated: list[tuple[str, Mapping[str, Any]]] = []
    if isinstance(spec, Mapping):
        stated.append(("the description", table_of("the description", dict(spec))))
    elif spec is not None:
        stated.append((spec.name, read_description(spec, robot)))
    stated.append(("the network's metadata", from_metadata(network.metadata)))
    names = [(where, [*t["joints"]]) for where, t in stated if isinstance(t.get("joints"), (list, tuple))]
    if len(names) == 2 and names[0][1] != names[1][1]:
        pairs = [*zip(names[0][1], names[1][1], strict=False), (len(names[0][1]), len(names[1][1]))]
        k = next(k for k, (a, b) in enumerate(pairs) if a != b)
        raise ProblemError(
            f"joint {k} of the policy is {pairs[k][0]} in {names[0][0]} and {pairs[k][1]} in its metadata"
        )
    convention = next((t["convention"] for _, t in stated if t.get("convention")), _recognise(network))
    if convention is not None:
        known = read_yaml(CONVENTIONS)
        check_name("convention", convention, known)
        stated.append((f"assumed: convention {convention}", known[convention]))
    table, sources = dict[str, Any](), dict[str, str]()
    for where, part in stated:
        for key, value in part.items():
            if value is not None and key not in table and key != "convention":
                table[key], sources[key] = value, where
    return Description(table, sources)


def beside(network: Path) -> Path | None:
    """Return the description of the same stem beside a network."""
    return next((p for p in (network.with_suffix(s) for s in SPECS) if p.is_file()), None)


def robot_of(network: Path) -> str | None:
    """Return the robot that a file's name says, as ``go2`` in ``go2_himloco.onnx``.

    >>> robot_of(Path("unitree_rl_lab_g1.onnx"))
    'g1'
    """
    words = network.stem.lower().replace("-", "_").split("_")
    return next((word for word in words if word in robot_names()), None)


def read_description(path: Path, robot: Robot) -> dict[str, Any]:
    """Return what a YAML file says in our keys, whoever wrote it.

    Raises
    ------
    ProblemError
        If it cannot be read, or is nobody's that is known.
    """
    content = parse_yaml(read_text(path, "the policy's description"), path, foreign_tags=True)
    said = table_of(str(path), content)
    inner = next(iter(said.values())) if len(said) == 1 else None
    try:
        if isinstance(inner, dict) and "rl_kp" in inner:
            return _from_rl_sar(inner, robot)
        if "joint_ids_map" in said:
            return _from_deploy(said, robot)
        if "default_angles" in said and "kps" in said:
            return _from_legged_gym(said, robot)
    except ProblemError:
        raise
    except (LookupError, TypeError, AttributeError, ValueError, ArithmeticError) as error:
        raise ProblemError(f"{path} is not as its publisher writes such files: {shown(error)}") from error
    return said


def motor_names(robot: Robot) -> list[str]:
    """Return joints in the order of Unitree's motors: legs FR, FL, RR, RL; the model's for others."""
    legs = {leg: [name for name in robot.joint_names if name.startswith(f"{leg}_")] for leg in LEGS}
    if sum(map(len, legs.values())) != robot.joints:
        return list(robot.joint_names)
    return [name for leg in LEGS for name in legs[leg]]


def _from_rl_sar(said: Mapping[str, Any], robot: Robot) -> dict[str, Any]:
    """Return what rl_sar's config.yaml says: joints as its motors in `joint_mapping`, gravity unscaled.

    Its base.yaml has a step of 5 ms and a decimation of 4.
    """
    scales = {
        "ang_vel": said["ang_vel_scale"], "lin_vel": said["lin_vel_scale"], "dof_pos": said["dof_pos_scale"],
        "dof_vel": said["dof_vel_scale"], "commands": said["commands_scale"],
    }  # fmt: skip
    ages, motors = list(said.get("observations_history") or [0]), motor_names(robot)
    newest = ages == sorted(ages)
    if sorted(ages) != list(range(len(ages))) or not (newest or ages == sorted(ages, reverse=True)):
        raise ProblemError(f"observations_history {ages}: only whole histories in order are read")
    if said.get("wheel_indices"):
        raise ProblemError("wheel_indices: policies that turn wheels are not read")
    return {
        "joints": [motors[k] for k in said["joint_mapping"]],
        "default": said["default_dof_pos"],
        "stiffness": said["rl_kp"],
        "damping": said["rl_kd"],
        "action_scale": said["action_scale"],
        "action_clip": [said["clip_actions_lower"], said["clip_actions_upper"]],
        "observations": [{name: {"scale": scales.get(name, 1.0)}} for name in said["observations"]],
        "observation_clip": said["clip_obs"],
        "history": {
            "length": len(ages), "order": "newest" if newest else "oldest",
            "by": said.get("observations_history_priority", "time"), "start": "zeros",
        },
        "rate": 1.0 / (said.get("dt", 0.005) * said.get("decimation", 4)),
    }  # fmt: skip


def _from_deploy(said: Mapping[str, Any], robot: Robot) -> dict[str, Any]:
    """Return what Unitree's deploy.yaml says: gains in the motors' order, all else in the policy's."""
    motors, order = motor_names(robot), said["joint_ids_map"]
    if len(order) != len(motors):
        raise ProblemError(
            f"joint_ids_map has {len(order)} joints, {robot.name} {len(motors)} motors: {', '.join(motors)}"
        )
    (action,) = said["actions"].values()
    (commands,) = said.get("commands", {"none": {}}).values()
    observations = []
    for name, own in said["observations"].items():
        period = (own.get("params") or {}).get("period")
        entry = {"scale": own.get("scale") or 1.0, "clip": own.get("clip"), "history": own["history_length"]}
        observations.append({name: entry | ({} if period is None else {"period": period})})
    clip = action.get("clip")
    return {
        "joints": [motors[k] for k in order],
        "default": said["default_joint_pos"],
        "stiffness": [said["stiffness"][k] for k in order],
        "damping": [said["damping"][k] for k in order],
        "action_scale": action["scale"],
        "action_offset": action["offset"],
        "target_clip": None if clip is None else [list(bound) for bound in zip(*clip, strict=True)],
        "observations": observations,
        "command_range": _ranges(commands.get("ranges")),
        "rate": 1.0 / said["step_dt"],
    }


def _from_legged_gym(said: Mapping[str, Any], robot: Robot) -> dict[str, Any]:
    """Return what a configuration of legged_gym's deploy script says: terms and clock are the script's."""
    k, size, fastest = int(said["num_actions"]), int(said["num_obs"]), said.get("max_cmd")
    motors = motor_names(robot) if "leg_joint2motor_idx" in said else robot.joint_names
    terms: list[Any] = [
        {"angular_velocity": {"scale": said["ang_vel_scale"]}}, "gravity",
        {"command": {"scale": said["cmd_scale"]}}, {"joint_positions": {"scale": said["dof_pos_scale"]}},
        {"joint_velocities": {"scale": said["dof_vel_scale"]}}, "last_action",
    ]  # fmt: skip
    extra = {0: terms, 2: [*terms, {"phase": {"period": said.get("period", 0.8)}}]}
    extra[3] = [{"linear_velocity": {"scale": said.get("lin_vel_scale", 2.0)}}, *terms]
    return {
        "joints": [motors[m] for m in said.get("leg_joint2motor_idx", range(k))],
        "default": said["default_angles"],
        "stiffness": said["kps"],
        "damping": said["kds"],
        "action_scale": said["action_scale"],
        "observations": extra.get(size - 9 - 3 * k),
        "command_range": None if fastest is None else [[-v, v] for v in fastest],
        "rate": 1.0 / (said.get("control_dt") or said["simulation_dt"] * said["control_decimation"]),
    }


def from_metadata(said: Mapping[str, Any]) -> dict[str, Any]:
    """Return what metadata of an ONNX file says in our keys."""
    out = {key: next((said[n] for n in names if n in said), None) for key, names in METADATA.items()}
    if isinstance(out["joints"], str):
        out["joints"] = [out["joints"]]
    for name in ("step_dt", "control_dt", "policy_dt"):
        if out["rate"] is None and isinstance(said.get(name), (int, float)):
            out["rate"] = 1.0 / said[name]
    names = next((said[n] for n in ("observation_names", "obs_names") if n in said), None)
    if names is not None:
        names = [names] if isinstance(names, str) else names
        columns = {
            "scale": said.get("observation_scales", said.get("obs_scales")),
            "history": said.get("observation_history_lengths", said.get("history_length")),
        }
        out["observations"] = [
            {name: {key: _entry(v, k, name) for key, v in columns.items() if v is not None}}
            for k, name in enumerate(names)
        ]
    out["command_range"] = _ranges(said.get("command_ranges"))
    return {key: value for key, value in out.items() if value is not None}


def _entry(column: Any, k: int, name: str) -> Any:
    """Return a term's value in a column of metadata: by name, by number, or one for all."""
    if isinstance(column, Mapping):
        return column.get(name, 1)
    value = column[k] if isinstance(column, list) else column
    return int(value) if isinstance(value, float) and value.is_integer() else value


def _ranges(said: Any) -> list[list[float]] | None:
    """Return three (low, high) pairs of a table of command ranges, None where it does not have them."""
    found = [next((said[n] for n in names if n in said), None) for names in RANGES] if said else []
    return [list(pair) for pair in found if pair] if found and all(found) else None


def _recognise(network: Network) -> str | None:
    """Return the convention that a network's own marks say."""
    marks = {"dof_names", "kp", "kd"} <= network.metadata.keys()
    fits = marks and network.inputs == 3 * len(network.metadata["dof_names"]) + 13
    return "holosoma" if fits and network.input_name == "actor_obs" else None
