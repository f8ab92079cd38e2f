"""Feet read from a robot's collision geometry: which shapes a foot has, and what is told of the reading."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ModelError
from surefoot.mechanics.robot.foot import DEFAULT_RADIUS, Foot
from surefoot.mechanics.robot.foot_parts import FootPart, disc_points, foot_part
from surefoot.mechanics.robot.foot_shape import BAND, SHADOW, FootShapeReading, foot_shape
from surefoot.mechanics.robot.frames import frame_index
from surefoot.mechanics.robot.outlines import area_of, hull_of

SHOWN = 3
"""How many missing meshes are named before the rest is counted."""
UP = np.array([0.0, 0.0, 1.0])
LEAST_EXPLAINED = 0.3
"""Share of the shape's area that a reading must explain; less is a guess."""


class FootUnread(ModelError):
    """A foot whose shape is not known."""


class FootGuess(FootUnread):
    """A foot whose shape says too little of where it stands."""


@dataclass(frozen=True, eq=False)
class FootSource:
    """A robot's files, as far as feet are read from them.

    Attributes
    ----------
    model, collision
        Pinocchio's Model and collision GeometryModel.
    visual
        Loader of what the robot looks like; feet without collision geometry are read from it.
    missing
        Meshes that were not found, by the link whose collision geometry they are.
    """

    model: Any
    collision: Any
    visual: Callable[[], Any]
    missing: Mapping[str, Sequence[str]] = field(default_factory=dict)


def read_feet(source: FootSource, names: Sequence[str], q: FloatArray) -> tuple[Foot, ...]:
    """Return the feet at frames, their shapes read from the collision geometry at a pose (nq,) [m, -, rad].

    A frame's own shapes count, else those of the body that it is fixed to, else what is drawn of it. A sole
    whose frame is not level with it gets a frame of its own, which is added to the model.

    Raises
    ------
    ModelError
        For a foot whose shape is missing, explained by less than `LEAST_EXPLAINED`, or of no shape
        beside a sole.
    """
    if not names:
        return ()
    import pinocchio

    data = source.model.createData()
    pinocchio.framesForwardKinematics(source.model, data, q)
    feet = tuple(_foot(source, name, data) for name in names)
    bare = [foot for foot in feet if foot.why == _describe_ball(foot.name)]
    soles = [foot for foot in feet if foot.flat]
    if bare and soles:
        raise FootUnread(
            f"the foot {bare[0].name} has no shape, while {soles[0].name} is {soles[0].size_words}: a ball "
            "would be a guess. Give it the shape of the other, or name the link that touches the ground"
        )
    return feet


def _describe_ball(name: str) -> str:
    return f"{name}: a ball of {1e3 * DEFAULT_RADIUS:.0f} mm radius is assumed, as nothing there has a shape"


def reading_notes(
    feet: Sequence[Foot], missing: Mapping[str, Sequence[str]], ranged: Sequence[str] = ()
) -> tuple[str, ...]:
    """Return what a run tells of a reading: feet that are alike, missing meshes, joints without a range."""
    alike: dict[str, list[str]] = {}
    for foot in feet:
        alike.setdefault(foot.why.removeprefix(f"{foot.name}: "), []).append(foot.name)
    lines = [f"read from the file: {', '.join(names)}: {words}" for words, names in alike.items()]
    lost = list(dict.fromkeys(name for names in missing.values() for name in names))
    if lost:
        more = f" and {len(lost) - SHOWN} more" if len(lost) > SHOWN else ""
        lines.append(f"meshes that are not there, whose shapes are left out: {', '.join(lost[:SHOWN])}{more}")
    if ranged:
        more = f" and {len(ranged) - SHOWN} more" if len(ranged) > SHOWN else ""
        joints = ", ".join(ranged[:SHOWN])
        lines.append(f"joints without a range in the file, taken for half a turn either way: {joints}{more}")
    return tuple(lines)


def _foot(source: FootSource, name: str, data: Any) -> Foot:
    """Return the foot at a frame, placed as Pinocchio's Data has it."""
    model = source.model
    rotation_world_foot = np.array(data.oMf[frame_index(model, name)].rotation)
    up = rotation_world_foot[2]
    items, whose = _items(source, name)
    lost = _missing_of(source, name)
    if not items:
        if lost:
            raise FootUnread(
                f"the foot {name} cannot be read: its shape is {_mesh_names(lost)}, which is not there. Put "
                "the file where the model looks for it, or give the foot spheres or a box"
            )
        return Foot(name, frame_index(model, name), np.zeros((1, 3)), DEFAULT_RADIUS, _describe_ball(name))
    place = model.frames[frame_index(model, name)].placement

    def parts_at(vertical: FloatArray) -> list[FootPart]:
        return [p for item in items if (p := foot_part(item, place.actInv(item.placement), vertical))]

    shape = foot_shape(parts_at, up, rotation_world_foot[0])
    beyond, share = _neighbours(source, name, data, parts_at(up), shape)
    without = f"; without {_mesh_names(lost)}, which is not there" if lost else ""
    why = f"{name}: {shape.words}{whose} ({100.0 * share:.0f} % of its area){without}{beyond}"
    if share < LEAST_EXPLAINED:
        raise FootGuess(
            f"the foot {name} would be a guess: {shape.words}{whose} explains {100.0 * share:.0f} % of the "
            f"shape's area, less than {100.0 * LEAST_EXPLAINED:.0f} %{beyond}. Give it spheres or a box "
            "where it touches the ground"
        )
    return Foot(name, _frame(model, name, shape), shape.centres, shape.radius, why)


def _frame(model: Any, name: str, shape: FootShapeReading) -> int:
    """Return the frame in whose axes a contact is, which is made where the foot's own is not level."""
    import pinocchio

    frame = frame_index(model, name)
    if np.array_equal(shape.axes, np.eye(3)):
        return int(frame)
    own, title = model.frames[frame], f"{name} sole"
    if model.existFrame(title):
        return frame_index(model, title)
    place = own.placement * pinocchio.SE3(shape.axes, np.zeros(3))
    return int(
        model.addFrame(pinocchio.Frame(title, own.parentJoint, frame, place, pinocchio.FrameType.OP_FRAME))
    )


def _neighbours(
    source: FootSource, name: str, data: Any, parts: Sequence[FootPart], shape: FootShapeReading
) -> tuple[str, float]:
    """Return what is told of links across a joint that touch the ground too, and the share that is explained.

    A contact moves with one joint: of a heel and a toe it has the part that the foot's name is on.
    """
    model = source.model
    frame = frame_index(model, name)
    joint, pose = int(model.frames[frame].parentJoint), data.oMf[frame]
    near = [k for k in range(1, model.njoints) if joint in (int(model.parents[k]), k)]
    near = [k for k in {*near, int(model.parents[joint])} if k not in (0, joint)]
    up = np.array(pose.rotation)[2]
    low = _lowest(parts, up, np.inf)[0]
    others: dict[int, list[FootPart]] = {}
    for item in source.collision.geometryObjects:
        if int(item.parentJoint) in near:
            place = pose.actInv(data.oMi[int(item.parentJoint)] * item.placement)
            part = foot_part(item, place, up)
            if part is not None and _lowest([part], up, np.inf)[0] <= low + BAND:
                others.setdefault(int(item.parentJoint), []).append(part)
    if not others or len(shape.centres) < 2:
        return "", shape.explained
    own = _lowest(parts, up, low + SHADOW)[1]
    rest = sum(_lowest(found, up, low + SHADOW)[1] for found in others.values())
    across = [model.names[k if int(model.parents[k]) == joint else joint] for k in others]
    told = f"; what touches the ground across the joint {' and '.join(across)} is not part of it"
    return told, shape.explained * own / max(own + rest, 1e-12)


def _lowest(parts: Sequence[FootPart], up: FloatArray, height: float) -> tuple[float, float]:
    """Return how low parts reach [m], and the area of the outline of what lies below a height [m²]."""
    points = np.vstack([part.points for part in parts])
    radii = np.concatenate([np.full(len(part.points), part.radius) for part in parts])
    bottoms = points @ up - radii
    side = np.linalg.svd(up[None, :])[2][1:]
    below = bottoms <= height
    return float(bottoms.min()), area_of(hull_of(disc_points(points[below] @ side.T, radii[below])))


def _items(source: FootSource, name: str) -> tuple[list[Any], str]:
    """Return the GeometryObjects that are a foot, and whose they are in words."""
    model = source.model
    frame = frame_index(model, name)
    joint = int(model.frames[frame].parentJoint)

    def is_own(item: Any) -> bool:
        at = int(item.parentFrame)
        named = model.frames[at].type.name == "OP_FRAME" and int(model.frames[at].parentFrame) == frame
        return bool(at == frame or named)

    def is_fixed(item: Any) -> bool:
        return int(item.parentJoint) == joint

    drawn = "as it has no collision shape"
    choices: list[tuple[Callable[[], Any], Callable[[Any], bool], str]] = [
        (lambda: source.collision, is_own, ""),
        (lambda: source.collision, is_fixed, " of the body that it is fixed to"),
        (source.visual, is_own, f" as drawn, {drawn}"),
        (source.visual, is_fixed, f" as its body is drawn, {drawn}"),
    ]
    if _missing_of(source, name):
        choices = choices[::2]  # a neighbour's shape says nothing of it
    for geometry, chosen, whose in choices:
        place = model.frames[frame].placement
        found = [item for item in geometry().geometryObjects if chosen(item)]
        found = [item for item in found if foot_part(item, place.actInv(item.placement), UP) is not None]
        if found:
            return found, whose
    return [], ""


def _missing_of(source: FootSource, name: str) -> list[str]:
    """Return the meshes that were not found of a foot's own link, or of the one that a bare frame is on."""
    own = source.missing.get(name, ())
    if own or not source.missing:
        return list(own)
    model, frame = source.model, frame_index(source.model, name)
    if any(int(item.parentFrame) == frame for item in source.collision.geometryObjects):
        return []
    joint = int(model.frames[frame].parentJoint)
    above = int(model.frames[frame].parentFrame)
    while above and model.frames[above].type.name != "BODY":
        above = int(model.frames[above].parentFrame)
    same = above and int(model.frames[above].parentJoint) == joint
    return list(source.missing.get(str(model.frames[above].name), ())) if same else []


def _mesh_names(names: Sequence[str]) -> str:
    return f"the mesh {names[0]}" if len(names) == 1 else f"the meshes {', '.join(names)}"
