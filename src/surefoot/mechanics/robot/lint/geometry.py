"""Rules on shapes: mesh files, sizes, and parts that are inside each other."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from surefoot.mechanics.robot.lint.finding import Offence, Rule
from surefoot.mechanics.robot.lint.shapes import largest_size
from surefoot.mechanics.robot.lint.subject import Subject

LARGE = 20.0
"""Size of a shape over the robot's reach that is a unit and not a design [-]."""
TINY = 2e-3
"""Size of a mesh over the robot's reach below which nothing of it can touch anything [-]."""
OVERLAP = 0.01
"""Depth of two links in each other that is no rounding of their shapes, times the robot's reach [-]."""
MOST_PAIRS = 4000
"""Pairs of shapes that are looked at, nearest names first: a model of more is not searched through [-]."""


def _missing_meshes(subject: Subject) -> Iterator[Offence]:
    facts = subject.facts
    feet = set() if subject.robot is None else set(subject.robot.foot_names)
    for shape in facts.shapes:
        if not shape.text or shape.file is not None:
            continue
        fatal = facts.format == "mjcf" or (shape.collides and shape.link in feet and not subject.described)
        severity = "error" if fatal else "" if shape.collides else "note"
        what = "its collision shape is left out" if shape.collides else "it is not drawn"
        what = "MuJoCo refuses the file without it" if facts.format == "mjcf" else what
        yield Offence(f"link {shape.link}", shape.text, f"no such file; {what}", severity)


def _impossible_sizes(subject: Subject) -> Iterator[Offence]:
    for shape in subject.facts.shapes:
        sizes = np.array(shape.size)
        scaled = shape.kind == "mesh"
        if np.isfinite(sizes).all() and ((sizes == 0.0).any() if scaled else (sizes <= 0.0).any()):
            value = f"{shape.kind} {'scale ' if scaled else ''}{_list(sizes)}"
            point = shape.kind == "sphere" and not sizes.any() and subject.facts.format == "urdf"
            severity = "error" if shape.collides and not point else "warning"
            detail = "some engines take it for a point, others refuse it" if point else "no shape has it"
            yield Offence(f"link {shape.link}", value, detail, severity)


def _sizes_off(subject: Subject) -> Iterator[Offence]:
    reach = subject.reach
    if reach <= 0.0:
        return
    for shape in subject.facts.shapes:
        size = max(shape.size, default=0.0)
        if shape.kind not in ("mesh", "plane") and np.isfinite(size) and size > LARGE * reach:
            detail = f"{size / reach:.3g} times the reach of the robot; is it in millimetres?"
            severity = "" if shape.collides else "warning"
            yield Offence(f"link {shape.link}", f"{shape.kind} of {size:g} m", detail, severity)
    robot = subject.robot
    if robot is None:
        return
    for item in robot.collision.geometryObjects:
        if not hasattr(item.geometry, "num_vertices"):
            continue
        size, name = largest_size(item.geometry), str(robot.model.frames[item.parentFrame].name)
        if size > LARGE * reach:
            detail = (
                f"{size / reach:.3g} times the reach of the robot: a mesh in millimetres needs scale 0.001"
            )
            yield Offence(f"link {name}", f"mesh of {size:.3g} m", detail)
        elif size < TINY * reach:
            detail = f"{size / reach:.2g} of the reach of the robot: is it scaled twice?"
            yield Offence(f"link {name}", f"mesh of {1e3 * size:.3g} mm", detail, "warning")


def _overlaps(subject: Subject) -> Iterator[Offence]:
    robot = subject.robot
    if robot is None:
        return
    import coal
    import pinocchio

    pinocchio.forwardKinematics(robot.model, robot.data, robot.nominal)
    items = [item for item in robot.collision.geometryObjects if int(item.parentJoint) > 0]
    places = [robot.data.oMi[item.parentJoint] * item.placement for item in items]
    worst: dict[tuple[str, str], float] = {}
    for a, b in _pairs(robot.model, items, places):
        depth = _depth(coal, items[a], places[a], items[b], places[b])
        first, second = (str(robot.model.names[items[k].parentJoint]) for k in (a, b))
        worst[first, second] = max(depth, worst.get((first, second), 0.0))
    for (first, second), depth in worst.items():
        if depth > OVERLAP * subject.reach:
            value = f"{1e3 * depth:.3g} mm deep"
            yield Offence(f"links of {first} and {second}", value, "in each other in the nominal pose")


def _pairs(model: Any, items: list[Any], places: list[Any]) -> Iterator[tuple[int, int]]:
    """Yield pairs of shapes of joints that are not neighbours, whose bounding balls meet."""
    for item in items:
        item.geometry.computeLocalAABB()
    centres = np.array(
        [place.act(np.asarray(item.geometry.aabb_center)) for place, item in zip(places, items, strict=True)]
    )
    radii = np.array([float(item.geometry.aabb_radius) for item in items])
    count = 0
    for a in range(len(items)):
        near = np.linalg.norm(centres[a + 1 :] - centres[a], axis=1) < radii[a + 1 :] + radii[a]
        for b in (a + 1 + np.flatnonzero(near)).tolist():
            if count < MOST_PAIRS and not _neighbours(
                model, int(items[a].parentJoint), int(items[b].parentJoint)
            ):
                count += 1
                yield a, b


def _neighbours(model: Any, first: int, second: int) -> bool:
    """Tell whether two joints are at most three apart in the tree, or branch from one."""
    ways = []
    for joint in (first, second):
        way = [joint]
        while way[-1] > 0:
            way.append(int(model.parents[way[-1]]))
        ways.append(way)
    shared = next((joint for joint in ways[0] if joint in ways[1]), 0)
    return ways[0].index(shared) + ways[1].index(shared) <= 3


def _depth(coal: Any, a: Any, place_a: Any, b: Any, place_b: Any) -> float:
    """Return how deep two shapes are in each other [m], 0 where they are apart; meshes by their hulls."""
    ends = [coal.Transform3s(np.asarray(p.rotation), np.asarray(p.translation)) for p in (place_a, place_b)]
    hulls = [_hull(item.geometry) for item in (a, b)]
    if hulls[0] is None or hulls[1] is None:
        return 0.0
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    return max(0.0, -float(coal.distance(hulls[0], ends[0], hulls[1], ends[1], request, result)))


def _hull(shape: Any) -> Any:
    """Return the convex hull of a mesh, None where it has none that coal can hold; another shape stays."""
    if not hasattr(shape, "buildConvexHull"):
        return shape
    try:
        if shape.convex is None:
            shape.buildConvexHull(True, "Qt")
    except RuntimeError:
        return None
    return shape.convex


def _list(values: object) -> str:
    return "(" + ", ".join(f"{x:.3g}" for x in np.asarray(values, dtype=float)) + ")"


GEOMETRY_RULES = (
    Rule(
        "mesh-missing",
        "mesh files",
        "warning",
        "Put the file beside the model, where its path points, or mend the path.",
        _missing_meshes,
    ),
    Rule("shape-empty", "sizes of shapes", "error", "Give it its size.", _impossible_sizes),
    Rule(
        "shape-unlike-robot",
        "sizes of shapes beside the robot's reach",
        "error",
        "Check the unit: metres; a mesh in millimetres needs scale 0.001.",
        _sizes_off,
    ),
    Rule(
        "self-collision",
        "collision shapes in the nominal pose",
        "warning",
        "Shrink the shapes or mend the pose; --collision full never tests pairs that begin so.",
        _overlaps,
    ),
)
"""The family."""
