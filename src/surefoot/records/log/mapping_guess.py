"""What fields mean, guessed from their names and their messages' types: tables of rules, nothing else.

A guess is shown (the fact ``mapping``) and doubted (`Log.doubts`); it never asks what the numbers look like.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace
from typing import Any

from surefoot.base.errors import ProblemError
from surefoot.records.log import npz_table
from surefoot.records.log.array_names import ALIASES, PER_FOOT
from surefoot.records.log.channels import CHANNELS
from surefoot.records.log.mapping import UNITS, LogMapping, Take
from surefoot.records.log.source import Source, Topic, full_name

_FOOT = r"(?P<foot>[FRHL][FRHL]|left|right|foot_?\d|leg_?\d)"
_JOINT = r"(?P<joint>\w*?[A-Za-z]\w*?)"
_AXIS = r"(?P<axis>[xyzw])"
_TRUTH = r"(?:mocap|vicon|optitrack|gt|truth|ground_?truth)"
_BASE = r"(?:base|body|root|pelvis|torso|trunk|floating_base)_?"


@dataclass(frozen=True)
class ColumnRule:
    """Columns of a table that make a channel.

    Attributes
    ----------
    channel
        What they are.
    pattern
        Of a column's name, without regard to case, after its unit was taken off; its groups ``foot``,
        ``joint`` and ``axis`` say which number of the channel a column is.
    axes
        Axes that must all be there, in the log's order; empty for none.
    """

    channel: str
    pattern: str
    axes: str = ""


RULES = (
    ColumnRule("time", r"(?:sim_?|ros_?)?(?:time|t|stamp|timestamp)(?:_?stamp)?"),
    ColumnRule("base_orientation", rf"(?:{_BASE})?(?:quaternion|quat|orientation|rot|q)[_.]?{_AXIS}", "xyzw"),
    ColumnRule("base_position", rf"{_BASE}(?:position|pos|p|com)?[_.]?{_AXIS}", "xyz"),
    ColumnRule("base_position", rf"(?:position|pos|p)_{_TRUTH}[_.]?{_AXIS}", "xyz"),
    ColumnRule("base_velocity", rf"{_BASE}(?:linear_?)?(?:velocity|vel|v)(?:_?lin)?[_.]?{_AXIS}", "xyz"),
    ColumnRule(
        "imu_acceleration",
        rf"(?:imu_?|{_BASE})?(?:linear_?)?(?:acceleration|accel|acc|a)[_.]?{_AXIS}",
        "xyz",
    ),
    ColumnRule(
        "imu_angular_velocity",
        rf"(?:imu_?|{_BASE})?(?:angular_?velocity|angular_?vel|ang_?vel|gyroscope|gyro|omega|w)[_.]?{_AXIS}",
        "xyz",
    ),
    ColumnRule(
        "forces",
        rf"(?:{_FOOT}_?(?:foot_?)?(?:contact_?)?(?:force|grf|f)|(?:force|grf|f)_?(?P<foot2>[FRHL]{{2}}))[_.]?{_AXIS}",
        "xyz",
    ),
    ColumnRule("forces", rf"(?:foot_?|contact_?|ground_?)?(?:force|grf|f)[_.]?{_AXIS}", "xyz"),
    ColumnRule("foot_sensors", rf"{_FOOT}_?(?:foot_?)?(?:contact_?)?(?:force|sensor|pressure|load)"),
    ColumnRule("foot_sensors", rf"(?:foot|contact)?_?(?:force|sensor|pressure|load)_?{_FOOT}"),
    ColumnRule("foot_sensors", rf"{_FOOT}_?(?:foot|contact|touch)"),
    ColumnRule("joint_positions", rf"(?:joint_?|motor_?)?(?:position|pos|angle|q)[_.]?{_JOINT}"),
    ColumnRule("joint_positions", rf"{_JOINT}[_.](?:position|pos|angle|ang|q)"),
    ColumnRule("joint_velocities", rf"(?:joint_?|motor_?)?(?:velocity|vel|speed|dq|qd)[_.]?{_JOINT}"),
    ColumnRule("joint_velocities", rf"{_JOINT}[_.](?:velocity|vel|speed|dq|qd)"),
    ColumnRule("torques", rf"(?:joint_?|motor_?)?(?:torque|tau|effort)[_.]?{_JOINT}"),
    ColumnRule("torques", rf"{_JOINT}[_.](?:torque|tau|effort)"),
    ColumnRule("mu", r"mu|friction"),
)
"""Rules for the columns of tables, tried in this order; a column belongs to the first that takes it."""
ARRAY_WORDS = {
    "t": "time", "times": "time", "timestamps": "time", "grf": "forces", "grfs": "forces",
    "contact_forces": "forces", "foot_forces": "forces", "f": "forces", "friction": "mu",
    "contacts": "active", "in_contact": "active", "contact": "active", "foot_positions": "contact_positions",
    "foot_velocities": "contact_velocities", "tau": "torques", "fz": "foot_sensors",
    "normal_forces": "foot_sensors",
}  # fmt: skip
"""What whole arrays are called in people's own loops, in small letters, to the channel."""
FIRST_W = ("qpos", "root_quat_w")
"""Arrays of engines whose quaternions begin with w."""
LEAST_FLOATING = 7
"""Numbers of a configuration that begin with a floating base's position and quaternion, as a guess."""
_FORCE_OF_FOOT = re.compile(rf"{_FOOT}_?(?:foot_?)?(?:contact_?)?(?:force|forces|grf|f)?", re.IGNORECASE)
DROPPED = ("qfrc_actuator",)
"""Arrays that have more than their channel: a mapping cannot take a part of one."""
_BARE = ("deg", "rad", "s", "ms", "us", "ns")
_SPELT = {
    ending: unit
    for unit in UNITS
    if unit != "1"  # an index
    for word in [unit.lower().replace(" ", "")]
    for ending in (f"[{word}]", f"({word})", *([f"_{word}"] if unit in _BARE else []))
}
"""How the names of columns end that tell their unit."""
MESSAGES: dict[str, tuple[tuple[str, str, dict[str, Any]], ...]] = {
    "JointState": (
        ("joint_positions", "position", {}),
        ("joint_velocities", "velocity", {}),
        ("torques", "effort", {}),
    ),
    "Imu": (
        ("imu_acceleration", "linear_acceleration", {}),
        ("imu_angular_velocity", "angular_velocity", {}),
    ),
    "Odometry": (
        ("base_position", "pose.pose.position", {}),
        ("base_orientation", "pose.pose.orientation", {"quaternion": "xyzw"}),
        ("base_velocity", "twist.twist.linear", {"frame": "base"}),
        ("base_angular_velocity", "twist.twist.angular", {}),
    ),
    "PoseStamped": (
        ("base_position", "pose.position", {}),
        ("base_orientation", "pose.orientation", {"quaternion": "xyzw"}),
    ),
    "LowState": (
        ("foot_sensors", "foot_force", {}),
        ("imu_acceleration", "imu_state.accelerometer", {}),
        ("imu_angular_velocity", "imu_state.gyroscope", {}),
        ("base_orientation", "imu_state.quaternion", {"quaternion": "wxyz"}),
    ),
}
"""End of a message type's name to (channel, field, how it is given); Odometry's twist is in base axes."""
_MOTORS = (("joint_positions", "q"), ("joint_velocities", "dq"), ("torques", "tau_est"))
_UNITREE_FEET = ("FR", "FL", "RR", "RL")
_UNITREE_JOINTS = tuple(f"{leg}_{j}_joint" for leg in _UNITREE_FEET for j in ("hip", "thigh", "calf"))


def guess_mapping(source: Source) -> LogMapping:
    """Return a mapping by the names of the fields and the types of the messages.

    Raises
    ------
    ProblemError
        If nothing but the time can be guessed.
    """
    table = list(source.topics) == [""]
    if table and source.topics[""].kind == npz_table.KIND:
        mapping = _of_arrays(source)
    else:
        mapping = _of_table(source.topics[""]) if table else _of_messages(source)
    if not set(mapping.channels) - {"time"}:
        names = source.names()
        raise ProblemError(
            f"no channel can be guessed from the fields {', '.join(names[:12])}{' ...' * (len(names) > 12)}: "
            "give a mapping"
        )
    return mapping


def _of_arrays(source: Source) -> LogMapping:
    """Return a mapping of arrays by their names: channels, what engines call them, or columns of a table."""
    topic = source.topics[""]
    fields = {name: array.reshape(len(array), -1) for name, array in topic.fields.items()}
    columns = _of_table(Topic(None, {name: array for name, array in fields.items() if array.shape[1] == 1}))
    takes = dict(columns.channels)
    for name, array in fields.items():
        channel, frame = ALIASES.get(
            name, (name if name in CHANNELS else ARRAY_WORDS.get(name.lower(), ""), "")
        )
        if not channel or name in DROPPED or (channel in takes and channel != name):
            continue
        if topic.fields[name].ndim == 2 and (array.shape[1] != 3 or channel == "mu"):
            channel = PER_FOOT.get(channel, channel) if array.shape[1] > 1 else channel
        if not CHANNELS[channel].shape and array.shape[1] != 1:
            continue
        turned = channel == "base_orientation" or (channel == "q" and array.shape[1] >= LEAST_FLOATING)
        order = "" if not turned else "wxyz" if name in FIRST_W else "xyzw"
        takes[channel] = Take((name,), frame=frame, quaternion=order)
    feet = {
        m["foot"]: name
        for name in fields
        if (m := _FORCE_OF_FOOT.fullmatch(name)) and fields[name].shape[1] == 3
    }
    if feet and "forces" not in takes:
        takes["forces"] = Take(tuple(feet.values()))
    else:
        feet = dict.fromkeys(columns.feet, "")
    dt = source.facts.get("dt", 0.0)
    rate = 1.0 / dt if "time" not in takes and 0.0 < dt < math.inf else 0.0
    friction = {"mu", "contact_friction"} & set(takes)
    facts = {k: v for k, v in source.facts.items() if k != "dt" and not (k == "mu" and friction)}
    return replace(columns, channels=takes, feet=tuple(feet), facts=facts, rate=rate, guessed=True)


def _of_table(topic: Topic) -> LogMapping:
    """Return a mapping of a table's columns; a channel whose columns do not fit together is left out."""
    found: dict[str, list[tuple[str, dict[str, str], str]]] = {}
    for column in topic.fields:
        plain, unit = _without_unit(column)
        for rule in RULES:
            match = re.fullmatch(rule.pattern, plain, re.IGNORECASE)
            if match is not None:
                groups = {k.removesuffix("2"): v for k, v in match.groupdict().items() if v}
                found.setdefault(rule.channel, []).append((column, groups, unit))
                break
    axes = {rule.channel: rule.axes for rule in RULES}
    vertical = found.get("forces", [])
    if vertical and "foot_sensors" not in found and {g["axis"].lower() for _, g, _ in vertical} == {"z"}:
        found["foot_sensors"] = found.pop("forces")  # F_z alone, of a foot or of each: how hard it presses
    takes: dict[str, Take] = {}
    names: dict[str, tuple[str, ...]] = {}
    for channel in dict.fromkeys(rule.channel for rule in RULES):
        columns = found.get(channel, [])
        if not columns or (channel in ("time", "mu") and len(columns) > 1):
            columns = columns[:1]
        ordered = _in_axes(columns, axes[channel])
        units = {unit if channel != "foot_sensors" else "" for _, _, unit in ordered}  # raw whatever it is
        if not ordered or len(units) > 1:
            continue
        kind = "foot" if channel in ("forces", "foot_sensors") else "joint"
        own = [g[kind] for _, g, _ in ordered if kind in g]
        if own:
            known = names.setdefault(kind, tuple(dict.fromkeys(own) if kind == "foot" else own))
            if set(known) != set(own):
                continue
            ordered.sort(key=lambda c: known.index(c[1][kind]))
        quaternion = "xyzw" if channel == "base_orientation" else ""
        takes[channel] = Take(tuple(c for c, _, _ in ordered), unit=units.pop(), quaternion=quaternion)
    return LogMapping(takes, names.get("foot", ()), names.get("joint", ()), guessed=True)


def _in_axes(
    columns: list[tuple[str, dict[str, str], str]], axes: str
) -> list[tuple[str, dict[str, str], str]]:
    """Return the columns with all axes of every foot together, in order; empty if an axis is missing."""
    if not axes:
        return columns
    owners: dict[str, dict[str, tuple[str, dict[str, str], str]]] = {}
    for column in columns:
        owners.setdefault(column[1].get("foot", ""), {})[column[1]["axis"].lower()] = column
    if any(set(found) != set(axes) for found in owners.values()):
        return []
    return [found[axis] for found in owners.values() for axis in axes]


def _without_unit(column: str) -> tuple[str, str]:
    """Return a column's name without the unit that it ends in, and the unit."""
    for ending, unit in _SPELT.items():
        if column.lower().endswith(ending) and len(column) > len(ending):
            return column[: -len(ending)].strip(" _"), unit
    return column.strip(), ""


def _of_messages(source: Source) -> LogMapping:
    """Return a mapping by the types of the messages; the first topic that brings a channel has it."""
    takes: dict[str, Take] = {}
    feet: tuple[str, ...] = ()
    joints: tuple[str, ...] = ()
    for name, topic in source.topics.items():
        kind = re.split(r"[/.]", topic.kind)[-1]
        if kind == "LowState":
            count = sum(f"motor_state[{k}].q" in topic.fields for k in range(12))
            feet, joints = _UNITREE_FEET, _UNITREE_JOINTS
            for channel, part in _MOTORS if count == 12 else ():
                fields = tuple(full_name(name, f"motor_state[{k}].{part}") for k in range(12))
                takes.setdefault(channel, Take(fields))
        for channel, where, how in MESSAGES.get(kind, ()):
            if where in topic.fields or f"{where}.x" in topic.fields:
                takes.setdefault(channel, Take((full_name(name, where),), **how))
    return LogMapping(takes, feet, joints, guessed=True)
