"""Rules on joints: ranges, efforts, speeds, axes and places."""

from __future__ import annotations

import math
from collections.abc import Iterator
from statistics import median

import numpy as np

from surefoot.base.spatial import GRAVITY
from surefoot.mechanics.robot.lint.facts import JointFacts, side_twin
from surefoot.mechanics.robot.lint.finding import Offence, Rule
from surefoot.mechanics.robot.lint.subject import Subject, kin_of

TURNS = 4.0 * math.pi
"""Angle beyond which no limit of a hinge limits a limb [rad]."""
LONGEST = 10.0
"""Way beyond which no limit of a slide limits a limb, times the robot's reach [-]."""
DEGREES = (10.0, 400.0)
"""Sizes of limits that are angles of joints in degrees, and no joint's in radians."""
NARROW = math.radians(6.0)
"""Range that every hinge of a robot stays under where radians were read as degrees [rad]: 2π deg is 0.11."""
STRONG = 20.0
"""Effort over m g times the robot's reach, or over m g, that no motor has [-]."""
WEAK = 1e-3
"""Effort over m g times the robot's reach, or over m g, that holds no leg [-]."""
TWIN = 0.1
"""Difference of a joint's effort or speed from its twin's that is no rounding [-]."""
OFFSET = 30.0
"""Joint offset over its twin's, or over all others' together, that is a unit and not a design [-]."""


def _place(joint: JointFacts) -> str:
    return f"joint {joint.name}"


def _unit(joint: JointFacts) -> str:
    return "m" if joint.kind == "prismatic" else "rad"


def _hinges(subject: Subject) -> list[JointFacts]:
    return [joint for joint in subject.facts.joints if joint.kind in ("revolute", "prismatic")]


def _crossed_limits(subject: Subject) -> Iterator[Offence]:
    for joint in _hinges(subject):
        if joint.lower > joint.upper:
            value = f"lower {joint.lower:g} > upper {joint.upper:g} {_unit(joint)}"
            yield Offence(_place(joint), value, "no angle is within both")


def _absurd_limits(subject: Subject) -> Iterator[Offence]:
    for joint in _hinges(subject):
        size = max(abs(x) for x in (joint.lower, joint.upper, 0.0) if not math.isnan(x))
        most = TURNS if joint.kind == "revolute" else LONGEST * max(subject.reach, 1e-3)
        if joint.limited and size > most and not _in_degrees(joint):
            value = f"range {joint.lower:g} to {joint.upper:g} {_unit(joint)}"
            yield Offence(_place(joint), value, f"beyond {most:.3g} {_unit(joint)} it limits nothing")


def _in_degrees(joint: JointFacts) -> bool:
    sizes = [abs(joint.lower), abs(joint.upper)]
    if not np.isfinite(sizes).all():
        return False
    whole = all(abs(size - round(size)) < 1e-9 for size in sizes)
    return joint.kind == "revolute" and whole and DEGREES[0] < max(sizes) <= DEGREES[1]


def _limits_in_degrees(subject: Subject) -> Iterator[Offence]:
    for joint in _hinges(subject):
        if joint.limited and _in_degrees(joint):
            severity = "error" if joint.name in subject.leg_joints else ""
            value = f"range {joint.lower:g} to {joint.upper:g} rad"
            yield Offence(_place(joint), value, "whole numbers of that size are degrees", severity)
    hinges = [j for j in subject.facts.joints if j.kind == "revolute" and j.limited and j.upper > j.lower]
    if len(hinges) >= 4 and all(max(abs(j.lower), abs(j.upper)) < NARROW for j in hinges):
        first = hinges[0]
        value = f"range {first.lower:.3g} to {first.upper:.3g} rad"
        detail = (
            f"all {len(hinges)} hinges turn less than 6 deg: MJCF reads degrees unless compiler angle=radian"
        )
        yield Offence(_place(first), value, detail, "error")


def _missing_limits(subject: Subject) -> Iterator[Offence]:
    bare = [joint for joint in _hinges(subject) if not joint.limited]
    if subject.facts.format == "urdf":
        for joint in bare:
            yield Offence(_place(joint), "no <limit>", "URDF has none to leave out there", "error")
        return
    for joint in bare:
        if joint.name in subject.leg_joints:
            yield Offence(_place(joint), "no range", "the leg may fold through itself")


def _shut_limits(subject: Subject) -> Iterator[Offence]:
    for joint in _hinges(subject):
        low, high = (0.0 if math.isnan(x) else x for x in (joint.lower, joint.upper))
        if joint.limited and low == high:
            detail = "it cannot move by its file, and worlds here take it as without limit"
            yield Offence(_place(joint), f"range {low:g} to {high:g} {_unit(joint)}", detail)


def _missing_efforts(subject: Subject) -> Iterator[Offence]:
    if subject.facts.format != "urdf":
        return
    for joint in subject.facts.joints:
        if joint.moves and joint.limited and (joint.effort == 0.0 or math.isnan(joint.effort)):
            value = "no effort" if math.isnan(joint.effort) else "effort 0"
            yield Offence(_place(joint), value, "taken as without limit: no verdict counts its motor")


def _absurd_efforts(subject: Subject) -> Iterator[Offence]:
    weight = subject.facts.mass * GRAVITY
    for joint in subject.facts.joints:
        if not joint.moves or math.isnan(joint.effort):
            continue
        scale = weight * (1.0 if joint.kind == "prismatic" else subject.reach)
        unit = "N" if joint.kind == "prismatic" else "N m"
        value = f"effort {joint.effort:g} {unit}"
        if joint.effort < 0.0:
            yield Offence(_place(joint), value, "no motor has a limit below zero", "error")
        elif joint.effort > STRONG * scale > 0.0 and math.isfinite(joint.effort):
            yield Offence(
                _place(joint), value, f"{joint.effort / scale:.3g} times what lifts the robot: no limit"
            )
        elif 0.0 < joint.effort < WEAK * scale and joint.name in subject.leg_joints:
            yield Offence(
                _place(joint), value, f"{joint.effort / scale:.2g} of what lifts the robot: it holds no leg"
            )


def _missing_speeds(subject: Subject) -> Iterator[Offence]:
    for joint in subject.facts.joints:
        if subject.facts.format == "urdf" and joint.moves and joint.limited and not abs(joint.speed) > 0.0:
            value = "no velocity" if math.isnan(joint.speed) else "velocity 0"
            yield Offence(_place(joint), value, "taken as without limit")


def _negative_speeds(subject: Subject) -> Iterator[Offence]:
    for joint in subject.facts.joints:
        if joint.speed < 0.0:
            yield Offence(_place(joint), f"velocity {joint.speed:g}", "no speed limit is below zero")


def _zero_axes(subject: Subject) -> Iterator[Offence]:
    for joint in subject.facts.joints:
        length = float(np.linalg.norm(joint.axis))
        if joint.moves and length < 1e-6:
            yield Offence(_place(joint), "axis " + _list(joint.axis), "it points nowhere")


def _poses_outside(subject: Subject) -> Iterator[Offence]:
    robot = subject.robot
    if robot is None or (robot.floating and not robot.feet):  # the pose of no feet is the file's zero
        return
    model = robot.model
    for name, joint in zip(list(model.names)[1:], list(model.joints)[1:], strict=True):
        if joint.nq != 1:
            continue
        q = float(robot.nominal[joint.idx_q])
        low, high = (float(x[joint.idx_q]) for x in (model.lowerPositionLimit, model.upperPositionLimit))
        out = max(low - q, q - high)
        if out > 1e-3 and low < high:
            value = f"{q:.4g} outside {low:.4g} to {high:.4g}"
            detail = f"the nominal pose is {out:.3g} beyond the range, against which an engine would push"
            yield Offence(f"joint {name}", value, detail)


def _offsets(subject: Subject) -> Iterator[Offence]:
    joints = [joint for joint in subject.facts.joints if np.isfinite(joint.origin).all()]
    named = set[str]()
    lengths = [_size(joint) for joint in joints if _size(joint) > 0.0]
    middle = median(lengths) if lengths else 0.0
    for joint, usual, kin in kin_of(joints, side_twin, _size):
        own = _size(joint)
        if usual <= 0.0 or own <= 0.0 or 1.0 / OFFSET < own / usual < OFFSET:
            continue
        if abs(math.log(own / middle)) < abs(math.log(usual / middle)):
            continue
        named.add(joint.name)
        yield Offence(
            _place(joint), f"origin {_list(joint.origin)} m", f"{own / usual:.3g} times that of {kin[0].name}"
        )
    total = sum(lengths)
    for joint in joints:
        own = _size(joint)
        first = joint.kind == "floating" or joint.parent in ("world", "")
        if joint.name not in named and not first and len(lengths) > 2 and own > OFFSET * (total - own) > 0.0:
            detail = f"{own / (total - own):.3g} times all others together; is it in millimetres?"
            yield Offence(_place(joint), f"origin {_list(joint.origin)} m", detail)


def _size(joint: JointFacts) -> float:
    return float(np.linalg.norm(joint.origin))


def _unlike_sides(subject: Subject) -> Iterator[Offence]:
    joints = [joint for joint in subject.facts.joints if joint.moves]
    for key, unit in (("effort", "N m"), ("speed", "rad/s")):
        known = [joint for joint in joints if 0.0 < getattr(joint, key) < math.inf]
        for joint, usual, kin in kin_of(known, side_twin, lambda joint, key=key: float(getattr(joint, key))):  # type: ignore[misc]
            own = float(getattr(joint, key))
            if usual / OFFSET < own < usual / (1.0 + TWIN):
                yield Offence(_place(joint), f"{key} {own:g} {unit}", f"{kin[0].name} has {usual:g}")
    ranged = [joint for joint in joints if joint.limited and joint.upper > joint.lower]
    for joint, usual, kin in kin_of(ranged, side_twin, lambda joint: joint.upper - joint.lower):
        if joint.upper - joint.lower < usual / (1.0 + TWIN) and usual < 2.0 * TURNS:
            value = f"range {joint.lower:g} to {joint.upper:g} {_unit(joint)}"
            yield Offence(_place(joint), value, f"{kin[0].name} has {kin[0].lower:g} to {kin[0].upper:g}")


def _list(values: object) -> str:
    return "(" + ", ".join(f"{x:.3g}" for x in np.asarray(values, dtype=float)) + ")"


JOINT_RULES = (
    Rule("limits-crossed", "ranges of joints", "error", "Swap lower and upper.", _crossed_limits),
    Rule(
        "limits-absurd",
        "ranges of joints",
        "warning",
        "Give the range that the part has, or make the joint continuous.",
        _absurd_limits,
    ),
    Rule("limits-in-degrees", "ranges of joints", "warning", "Write radians.", _limits_in_degrees),
    Rule("limits-missing", "ranges of joints", "warning", "Add the range.", _missing_limits),
    Rule(
        "limits-shut", "ranges of joints", "warning", "Give a range, or make the joint fixed.", _shut_limits
    ),
    Rule(
        "effort-missing",
        "efforts of joints",
        "warning",
        "Add the motor's peak torque to <limit effort>.",
        _missing_efforts,
    ),
    Rule(
        "effort-absurd",
        "efforts of joints beside the robot's weight",
        "warning",
        "Give the motor's peak torque at the joint [N m].",
        _absurd_efforts,
    ),
    Rule(
        "speed-missing",
        "speeds of joints",
        "note",
        "Add the motor's speed to <limit velocity>.",
        _missing_speeds,
    ),
    Rule("speed-negative", "speeds of joints", "error", "Give the motor's speed.", _negative_speeds),
    Rule("axis-zero", "axes of joints", "error", "Give the axis a direction.", _zero_axes),
    Rule(
        "pose-outside-limits",
        "nominal pose and ranges",
        "warning",
        "Widen the range, or give a pose (SRDF, keyframe) within it.",
        _poses_outside,
    ),
    Rule(
        "offset-unlike-kin",
        "places of joints beside their twins and each other",
        "error",
        "Check the unit of the joint's <origin> (body pos in MJCF): metres.",
        _offsets,
    ),
    Rule(
        "sides-differ",
        "efforts, speeds and ranges, left and right",
        "warning",
        "Give both sides the same figures, if the robot has the same parts there.",
        _unlike_sides,
    ),
)
"""The family."""
