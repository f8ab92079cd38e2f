"""The robot and the ground of a recording, where neither its file nor its name is at hand.

A recording keeps bodies, joints and shapes of its model as facts. Written as MJCF they are a robot like any
other, whose feet are the shapes that touched and are feet by the model; links and what else the model had
(actuators' own laws, tendons, other bodies) are no part of it.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics import FlatTerrain, Robot, Terrain, load_robot
from surefoot.records import Log

SPHERE, CAPSULE, ELLIPSOID, CYLINDER, BOX, MESH = 2, 3, 4, 5, 6, 7
"""MuJoCo's numbers of shapes; of a mesh a recording keeps its hull's corners where it may touch."""
SHAPES = {SPHERE: "sphere", CAPSULE: "capsule", ELLIPSOID: "ellipsoid", CYLINDER: "cylinder", BOX: "box"}
"""The plain shapes that a foot may have."""
NEEDED = (
    "model_bodies", "model_parents", "model_masses", "model_inertias", "model_centres", "model_inertia_axes",
    "model_positions", "model_orientations", "model_joint_bodies", "model_joint_axes", "model_joint_places",
    "model_joint_kinds", "model_geoms", "model_geom_bodies", "model_geom_types", "model_geom_sizes",
    "model_geom_positions", "model_geom_orientations", "feet", "contact_foot", "contact_is_foot", "joints",
)  # fmt: skip
"""Facts without which no robot is loaded."""
LEVEL = 2e-3
"""Height above or below zero of points that touch, for a ground that is called level [m]."""


def has_model(log: Log) -> bool:
    """Return whether a log keeps the model that it was recorded with."""
    return "model_bodies" in log.facts


def robot_of_recording(log: Log) -> Robot:
    """Return the robot of the model that a recording keeps.

    Raises
    ------
    ProblemError
        In one line, for a model that is no robot with a free base, hinges and slides, and plain feet.
    """
    lacking = [name for name in NEEDED if name not in log.facts]
    if lacking:
        raise ProblemError(f"its model is not whole: no fact {lacking[0]} (give robot)")
    kinds = [str(kind) for kind in log.fact("model_joint_kinds")]
    if kinds[:1] != ["free"] or not set(kinds[1:]) <= {"hinge", "slide"}:
        raise ProblemError("its model has no free base with hinges and slides behind it (give robot)")
    if "mass" in {str(kind) for kind in log.facts.get("change_kind", ())}:
        raise ProblemError("its loop changed masses of its model (give robot)")
    gravity = np.asarray(log.facts.get("gravity", (0.0, 0.0, -GRAVITY)), dtype=np.float64)
    if np.abs(gravity - (0.0, 0.0, -GRAVITY)).max() > 1e-2:
        raise ProblemError(f"its gravity is {gravity.tolist()}, replays take 9.81 m/s² downwards")
    root, feet = _write(log, kinds)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "recorded.xml"
        path.write_text(ElementTree.tostring(root, encoding="unicode"), encoding="utf-8")
        return load_robot(path, feet)


def ground_of_recording(log: Log) -> Terrain | None:
    """Return level ground where all that a recording touched lay at height zero, else None.

    Other logs are told by whoever ran them what they stood on.
    """
    if log.facts.get("kind") != "recording":
        return None
    if not {"normals", "contact_positions", "forces", "gaps"} <= set(log):
        return None
    loaded = np.asarray(log["forces"])[..., 2] > 0.0
    if not loaded.any() or np.any(log.facts.get("contact_other_moves", 0)):
        return None
    up = np.asarray(log["normals"])[loaded] @ (0.0, 0.0, 1.0)
    heights = np.asarray(log["contact_positions"])[loaded][:, 2] - np.asarray(log["gaps"])[loaded]
    return FlatTerrain() if up.min() > 1.0 - 1e-6 and np.abs(heights).max() < LEVEL else None


def _write(log: Log, kinds: list[str]) -> tuple[ElementTree.Element, list[str]]:
    """Return the model as MJCF, and its links with feet."""
    part = {name: np.asarray(log.fact(name)) for name in NEEDED if name.startswith("model_")}
    bodies, joints = [str(name) for name in part["model_bodies"]], [str(name) for name in log.fact("joints")]
    root = ElementTree.Element("mujoco", model=str(log.facts.get("robot", "")) or "recorded")
    ElementTree.SubElement(root, "compiler", angle="radian", autolimits="true")
    assets = ElementTree.SubElement(root, "asset")
    world = ElementTree.SubElement(root, "worldbody")
    nodes: list[ElementTree.Element] = []
    for k, name in enumerate(bodies):
        parent = int(part["model_parents"][k])
        pose = {"pos": _text(part["model_positions"][k]), "quat": _text(part["model_orientations"][k])}
        node = ElementTree.SubElement(world if parent < 0 else nodes[parent], "body", {"name": name, **pose})
        nodes.append(node)
        _add_inertia(node, part, k)
        if k == 0:
            ElementTree.SubElement(node, "freejoint")
    limits = np.asarray(log.facts.get("model_torque_limits", np.full(len(joints), np.inf)))
    actuators = ElementTree.SubElement(root, "actuator")
    for j, name in enumerate(joints):
        low, high = np.asarray(log.facts.get("model_joint_ranges", np.full((len(joints), 2), np.inf)))[j]
        limited = {"range": _text((low, high))} if np.isfinite((low, high)).all() and low < high else {}
        joint = {
            "name": name, "type": kinds[j + 1], "axis": _text(part["model_joint_axes"][j]),
            "pos": _text(part["model_joint_places"][j]), **limited,
        }  # fmt: skip
        ElementTree.SubElement(nodes[int(part["model_joint_bodies"][j])], "joint", joint)
        if np.isfinite(limits[j]) and limits[j] > 0.0:
            ElementTree.SubElement(actuators, "motor", joint=name, ctrlrange=_text((-limits[j], limits[j])))
    feet = _add_feet(log, part, nodes, assets)
    _add_pose(root, log)
    return root, [bodies[k] for k in feet]


def _add_inertia(node: ElementTree.Element, part: dict[str, Any], k: int) -> None:
    """Give a link its mass; a link may have none."""
    if part["model_masses"][k] > 0.0:
        ElementTree.SubElement(
            node, "inertial", mass=_text([part["model_masses"][k]]), pos=_text(part["model_centres"][k]),
            quat=_text(part["model_inertia_axes"][k]), diaginertia=_text(part["model_inertias"][k]),
        )  # fmt: skip


def recorded_hull(log: Log, geom: int) -> FloatArray:
    """Return the corners (n, 3) of the hull of a shape [m]; none where the log keeps none."""
    owners = np.asarray(log.facts.get("model_hull_geoms", np.zeros(0)))
    corners = np.asarray(log.facts.get("model_hull_corners", np.zeros((0, 3))), dtype=np.float64)
    return np.asarray(corners[owners == geom])


def _add_feet(
    log: Log, part: dict[str, Any], nodes: list[ElementTree.Element], assets: ElementTree.Element
) -> list[int]:
    """Give links the shapes of the feet, and the model their hulls; return the links."""
    names, owner = [str(name) for name in log.fact("feet")], np.asarray(log.fact("contact_foot"), dtype=int)
    own = {names[owner[p]] for p in np.flatnonzero(log.fact("contact_is_foot")).tolist()}
    feet: list[int] = []
    for g, name in enumerate(map(str, part["model_geoms"])):
        kind, link = int(part["model_geom_types"][g]), int(part["model_geom_bodies"][g])
        if name not in own:
            continue
        corners = recorded_hull(log, g) if kind == MESH else np.zeros((0, 3))
        if kind not in SHAPES and not len(corners):
            raise ProblemError(f"its foot {name} is a shape that the log does not keep (give robot)")
        shape = {"type": SHAPES[kind], "size": _text(part["model_geom_sizes"][g])} if kind in SHAPES else {}
        if len(corners):
            shape = {"type": "mesh", "mesh": f"hull {g}"}
            ElementTree.SubElement(assets, "mesh", name=f"hull {g}", vertex=_text(corners.ravel()))
        place = _text(part["model_geom_positions"][g]), _text(part["model_geom_orientations"][g])
        ElementTree.SubElement(
            nodes[link], "geom", {"name": name, "pos": place[0], "quat": place[1], **shape}
        )
        feet += [link] if link not in feet else []
    if not feet:
        raise ProblemError("no foot of its model touched anything (give robot)")
    return feet


def _add_pose(root: ElementTree.Element, log: Log) -> None:
    """Give the model the log's first configuration as its pose."""
    q = np.asarray(log["q"][0], dtype=np.float64)
    key = ElementTree.SubElement(ElementTree.SubElement(root, "keyframe"), "key", name="home")
    key.set("qpos", _text([*q[:3], q[6], *q[3:6], *q[7:]]))


def _text(numbers: Any) -> str:
    """Return numbers as an attribute, to the last bit."""
    return " ".join(repr(float(x)) for x in numbers)
