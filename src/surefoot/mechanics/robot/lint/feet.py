"""Rules on feet: those that are none, that differ, that do not stand lowest or start in the ground."""

from __future__ import annotations

from collections.abc import Iterator
from statistics import median_low
from typing import Any

import numpy as np

from surefoot.mechanics.robot.lint.facts import side_twin
from surefoot.mechanics.robot.lint.finding import Offence, Rule
from surefoot.mechanics.robot.lint.shapes import lowest_point
from surefoot.mechanics.robot.lint.subject import Subject

DEEP = 5e-3
"""Depth in the ground that is no rounding of a mesh [m]; a share of small robots' height, see `_depth`."""
MOST_ENDS = 8
"""How many ends of limbs a finding names."""
SIZES = 0.1
"""Difference of a foot's size from its twin's that is no rounding [-]."""


def _depth(subject: Subject) -> float:
    return min(DEEP, 0.02 * subject.reach)


def _unknown_feet(subject: Subject) -> Iterator[Offence]:
    robot = subject.robot
    if robot is not None and robot.floating and not robot.feet:
        ends = ", ".join(list(subject.ends)[:MOST_ENDS])
        yield Offence(
            "robot", "no feet named", f"rules on feet and legs did not run; its limbs end in {ends}"
        )


def _shapeless_feet(subject: Subject) -> Iterator[Offence]:
    robot = subject.robot
    if robot is None or subject.described:
        return
    shaped = {name for item in robot.collision.geometryObjects for name in _owners(robot, item)}
    lacking = {
        shape.link for shape in subject.facts.shapes if shape.text and shape.file is None and shape.collides
    }
    for foot in robot.feet:
        if foot.name not in shaped:
            severity = "error" if foot.name in lacking else ""
            why = "its mesh is missing" if foot.name in lacking else "its link has no collision shape"
            yield Offence(f"foot {foot.name}", foot.size_words, f"a guess: {why}", severity)


def _owners(robot: Any, item: Any) -> tuple[str, ...]:
    """Return the names of a shape's frame and, where it is its own (named shapes of an MJCF), of its link.

    By name, as a sole that was read from its link's shapes has another frame, level, beside the link's.
    """
    own = robot.model.frames[item.parentFrame]
    link = robot.model.frames[own.parentFrame] if own.type.name == "OP_FRAME" else own
    return str(own.name), str(link.name)


def _unlike_feet(subject: Subject) -> Iterator[Offence]:
    robot = subject.robot
    if robot is None or len(robot.feet) < 2:
        return
    twins: dict[str, Any] = {}
    for foot in robot.feet:
        other = twins.setdefault(side_twin(foot.name) or foot.name, foot)
        own, usual = _sizes(foot), _sizes(other)
        if foot.flat != other.flat or not np.allclose(own, usual, rtol=SIZES, atol=1e-4):
            yield Offence(
                f"foot {foot.name}", foot.size_words, f"{other.name} has {other.size_words}",
                "error" if foot.flat != other.flat else "",
            )  # fmt: skip
    heights: list[float] = []
    bottoms = robot.sphere_bottoms(robot.nominal)
    for foot in robot.feet:
        mine, bottoms = bottoms[: len(foot.centres)], bottoms[len(foot.centres) :]
        heights.append(min(mine))
    level = median_low(heights)
    for foot, height in zip(robot.feet, heights, strict=True):
        if abs(height - level) > 2.0 * _depth(subject) and robot.floating:
            side = "above" if height > level else "below"
            value = f"{1e3 * abs(height - level):.3g} mm {side} the others"
            yield Offence(f"foot {foot.name}", value, "in the nominal pose, in which all should stand")


def _sizes(foot: Any) -> tuple[float, float, float]:
    return (*foot.size, foot.radius)


def _bodies_in_ground(subject: Subject) -> Iterator[Offence]:
    robot = subject.robot
    if robot is None or not robot.feet or not robot.floating:
        return
    robot.sphere_bottoms(robot.nominal)
    standing = {int(robot.model.frames[foot.frame].parentJoint) for foot in robot.feet}
    lowest: dict[tuple[str, bool], float] = {}
    for item in robot.collision.geometryObjects:
        if int(item.parentJoint) == 0:
            continue
        height = lowest_point(item.geometry, robot.data.oMi[item.parentJoint] * item.placement)
        key = str(robot.model.frames[item.parentFrame].name), int(item.parentJoint) in standing
        if height is not None:
            lowest[key] = min(height, lowest.get(key, np.inf))
    for (name, of_foot), height in lowest.items():
        if height < -_depth(subject):
            value = f"{-1e3 * height:.3g} mm in the ground"
            # a walk lets feet alone touch unless it is told otherwise, so others' shapes do no harm there
            severity = "" if of_foot and not subject.described else "warning"
            yield Offence(
                f"link {name}", value, "in the nominal pose, in which the feet stand on it", severity
            )


def _starts_in_ground(subject: Subject) -> Iterator[Offence]:
    compiled = subject.compiled
    if compiled is None:
        return
    mujoco = subject.mujoco
    data = mujoco.MjData(compiled)
    plane = int(mujoco.mjtGeom.mjGEOM_PLANE)
    for k in range(compiled.nkey) or [-1]:
        mujoco.mj_resetData(compiled, data)
        if k >= 0:
            data.qpos[:] = compiled.key_qpos[k]
        if not np.isfinite(data.qpos).all():
            continue
        mujoco.mj_kinematics(compiled, data)
        mujoco.mj_comPos(compiled, data)
        mujoco.mj_collision(compiled, data)
        floors = [c for c in data.contact[: data.ncon] if plane in compiled.geom_type[list(c.geom)]]
        deepest = min(floors, key=lambda c: c.dist, default=None)
        if deepest is not None and deepest.dist < -_depth(subject):
            geom = (
                int(deepest.geom[0]) if compiled.geom_type[deepest.geom[0]] != plane else int(deepest.geom[1])
            )
            body = compiled.body(int(compiled.geom_bodyid[geom])).name
            pose = "pose of the file" if k < 0 else f"keyframe {compiled.key(k).name or k}"
            value = f"{-1e3 * float(deepest.dist):.3g} mm in the floor"
            yield Offence(
                f"{pose}, body {body}", value, "MuJoCo throws it out of the floor at the first step"
            )


FEET_RULES = (
    Rule("feet-unknown", "feet", "note", "Name them with --feet.", _unknown_feet),
    Rule(
        "foot-without-shape",
        "collision shapes of feet",
        "warning",
        "Give the foot's link a sphere, or a sole's box or corners.",
        _shapeless_feet,
    ),
    Rule(
        "feet-differ",
        "feet, left and right, in the nominal pose",
        "warning",
        "Give both sides the same shape, and a pose in which all feet stand.",
        _unlike_feet,
    ),
    Rule(
        "body-in-ground",
        "collision shapes in the nominal pose",
        "error",
        "The feet are not what stands lowest: name those that do, or mend the shape or the pose.",
        _bodies_in_ground,
    ),
    Rule(
        "start-in-ground",
        "file's pose and keyframes over its floor",
        "warning",
        "Raise the base by as much.",
        _starts_in_ground,
    ),
)
"""The family."""
