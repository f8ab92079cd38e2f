"""Facts of a URDF file, read as XML: what Pinocchio would refuse, or silently leave out, stays in sight."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.mechanics.robot.lint.facts import (
    ActuatorFacts,
    Fault,
    JointFacts,
    LinkFacts,
    ModelFacts,
    ShapeFacts,
)
from surefoot.mechanics.robot.urdf_geometry import mesh_file

KINDS = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")
_MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


def urdf_facts(path: Path, root: ET.Element, folders: Sequence[Path]) -> ModelFacts:
    """Return the facts of a URDF file.

    Parameters
    ----------
    path, root
        The file, and its ``<robot>``.
    folders
        Where packages are looked for.
    """
    return _Reader(path, folders).read(root)


class _Reader:
    """Reads one file; what is no number goes into the faults."""

    def __init__(self, path: Path, folders: Sequence[Path]) -> None:
        self.facts, self.folders = ModelFacts(path, "urdf"), folders

    def read(self, root: ET.Element) -> ModelFacts:
        """Return the facts."""
        for link in root.findall("link"):
            self.facts.links.append(self._link(link))
            for tag, collides in (("collision", True), ("visual", False)):
                for item in link.findall(tag):
                    self._shape(link.get("name", ""), item.find("geometry"), collides)
        for joint in root.findall("joint"):
            self.facts.joints.append(self._joint(joint))
        for transmission in root.findall("transmission"):
            for joint in transmission.findall("joint"):
                name = transmission.get("name", "") or "transmission"
                self.facts.actuators.append(ActuatorFacts(name, joint.get("name", "")))
        return self.facts

    def _numbers(
        self, place: str, element: ET.Element | None, key: str, default: str, count: int
    ) -> FloatArray:
        """Return the numbers of an attribute; NaN, and a fault, where they are none."""
        text = default if element is None else element.get(key, default)
        try:
            values = [float(word) for word in text.split()]
        except ValueError:
            values = []
        if len(values) != count or not np.isfinite(values).all():
            where = f"{place}, {element.tag if element is not None else ''} {key}"
            self.facts.faults.append(Fault("not-a-number", where, text.strip() or "nothing"))
            return np.full(count, math.nan)
        return np.array(values)

    def _number(self, place: str, element: ET.Element | None, key: str, default: str = "0") -> float:
        return float(self._numbers(place, element, key, default, 1)[0])

    def _optional(self, place: str, element: ET.Element | None, key: str) -> float:
        """Return a number that may be left out, or be infinite, as limits are."""
        text = "" if element is None else element.get(key, "")
        if not text or text.strip().lower().lstrip("+-") in ("inf", "infinity"):
            return float(text) if text else math.nan
        return self._number(place, element, key)

    def _link(self, element: ET.Element) -> LinkFacts:
        """Return a link with its inertial."""
        name = element.get("name", "")
        inertial = element.find("inertial")
        if inertial is None:
            return LinkFacts(name)
        place, origin = f"link {name}", inertial.find("origin")
        com = self._numbers(place, origin, "xyz", "0 0 0", 3)
        turn = _rotation(self._numbers(place, origin, "rpy", "0 0 0", 3))
        mass = self._number(place, inertial.find("mass"), "value")
        tensor = inertial.find("inertia")
        xx, xy, xz, yy, yz, zz = (self._number(place, tensor, key) for key in _MOMENTS)
        inertia = turn @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ turn.T
        return LinkFacts(name, mass, com, inertia, True)

    def _shape(self, link: str, geometry: ET.Element | None, collides: bool) -> None:
        """Add a shape; a mesh is looked for where the loader does."""
        if geometry is None or len(geometry) == 0:
            return
        item, place = geometry[0], f"link {link}"
        if item.tag == "mesh":
            text = item.get("filename", "")
            scale = tuple(self._numbers(place, item, "scale", "1 1 1", 3).tolist())
            found = _find_mesh(text, self.facts.path, self.folders)
            self.facts.shapes.append(ShapeFacts(link, "mesh", scale, collides, text, found))
            return
        keys = {"box": (("size", 3),), "sphere": (("radius", 1),)}.get(
            item.tag, (("radius", 1), ("length", 1))
        )
        size = tuple(x for key, n in keys for x in self._numbers(place, item, key, "", n).tolist())
        self.facts.shapes.append(ShapeFacts(link, item.tag, size, collides))

    def _joint(self, element: ET.Element) -> JointFacts:
        """Return a joint with its limits."""
        name, kind = element.get("name", ""), element.get("type", "")
        place = f"joint {name}"
        if kind not in KINDS:
            self.facts.faults.append(Fault("tree-broken", place, kind or "nothing", "no kind of joint"))
        ends = [element.find(tag) for tag in ("parent", "child")]
        parent, child = ("" if end is None else end.get("link", "") for end in ends)
        origin, limit = element.find("origin"), element.find("limit")
        dynamics, mimic = element.find("dynamics"), element.find("mimic")
        return JointFacts(
            name, kind, parent, child,
            self._numbers(place, origin, "xyz", "0 0 0", 3),
            self._numbers(place, element.find("axis"), "xyz", "1 0 0", 3),
            self._optional(place, limit, "lower"), self._optional(place, limit, "upper"),
            self._optional(place, limit, "effort"), self._optional(place, limit, "velocity"),
            damping=self._number(place, dynamics, "damping") if dynamics is not None else 0.0,
            mimics="" if mimic is None else mimic.get("joint", ""),
            limited=limit is not None,
        )  # fmt: skip


def _rotation(rpy: FloatArray) -> FloatArray:
    """Return Rz(yaw) Ry(pitch) Rx(roll), URDF's order (3, 3) of angles (3,) [rad]."""
    (r, p, y), (a, b, c) = np.sin(rpy), np.cos(rpy)
    about_x = np.array([[1, 0, 0], [0, a, -r], [0, r, a]])
    about_y = np.array([[b, 0, p], [0, 1, 0], [-p, 0, b]])
    about_z = np.array([[c, -y, 0], [y, c, 0], [0, 0, 1]])
    return np.asarray(about_z @ about_y @ about_x, dtype=np.float64)


def _find_mesh(text: str, path: Path, folders: Sequence[Path]) -> Path | None:
    """Return where a mesh's file is, None if it is nowhere that the loader looks."""
    try:
        return mesh_file(text, path, folders) if text else None
    except (OSError, ValueError):
        return None
