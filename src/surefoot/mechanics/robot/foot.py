"""The shape of a foot: the spheres with which it touches the ground."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError

DEFAULT_RADIUS = 0.02
"""Radius of a foot whose URDF draws none [m]."""


@dataclass(frozen=True)
class Foot:
    """A foot fixed to a frame of the robot.

    Attributes
    ----------
    name
        Name of its frame.
    frame
        Pinocchio's index of the frame.
    centres
        (k, 3) centres of its contact spheres in the foot's frame [m]: one for a point foot, four
        corners for a flat one.
    radius
        Radius of the spheres [m].
    """

    name: str
    frame: int
    centres: FloatArray
    radius: float

    @property
    def flat(self) -> bool:
        """Whether it is a flat foot, whose contact is a sole."""
        return len(self.centres) >= 3

    @property
    def centre(self) -> FloatArray:
        """(3,) centre of the contact (of the sole's rectangle, for a flat foot) in the foot's frame [m]."""
        if not self.flat:
            return np.array(self.centres[0])
        low, high = self._rectangle()
        return np.array([*(0.5 * (low + high)), float(np.mean(self.centres[:, 2]))])

    @property
    def size(self) -> tuple[float, float]:
        """Full length and width of the sole along the foot's x and y axes [m]; zeros for a point foot."""
        if not self.flat:
            return 0.0, 0.0
        low, high = self._rectangle()
        return float(high[0] - low[0]), float(high[1] - low[1])

    def _rectangle(self) -> tuple[FloatArray, FloatArray]:
        """Return the corners of the largest rectangle that the four sphere centres hold, about their middle.

        Soles are rarely exact rectangles; what lies inside all four corners is surely sole.
        """
        xy = self.centres[:, :2]
        middle = xy.mean(axis=0)
        left, right = xy[xy[:, 0] < middle[0], 0].max(), xy[xy[:, 0] >= middle[0], 0].min()
        down, up = xy[xy[:, 1] < middle[1], 1].max(), xy[xy[:, 1] >= middle[1], 1].min()
        return np.array([left, down]), np.array([right, up])


def frame_names(feet: str | Sequence[str] | None) -> Sequence[str] | None:
    """Return the names of feet, of a text those between its commas; None stays.

    Raises
    ------
    ProblemError
        For what are no names.
    """
    if isinstance(feet, str):
        return [name.strip() for name in feet.split(",")]
    if feet is not None and not (isinstance(feet, Sequence) and all(isinstance(f, str) for f in feet)):
        raise ProblemError(f"feet must be names of frames, got {feet!r:.60}")
    return feet


def shaped_foot(model: Any, name: str, centres: Sequence[tuple[float, float, float]], radius: float) -> Foot:
    """Return the foot at a frame with the given (k, 3) sphere centres in that frame and radius [m]."""
    return Foot(name, model.getFrameId(name), np.array(centres, dtype=np.float64), radius)


def read_foot(model: Any, geometry: Any, name: str, rotation_world_foot: FloatArray) -> Foot:
    """Return the foot at a frame, its shape read from the collision geometry.

    Spheres are taken as they are (four or more make a flat foot); a mesh counts as a sphere that
    reaches down to its lowest vertex in the nominal pose; no geometry at all gives a sphere of
    `DEFAULT_RADIUS`.

    Parameters
    ----------
    model, geometry
        Pinocchio's Model and its collision GeometryModel.
    name
        The foot's frame, which must exist.
    rotation_world_foot
        (3, 3) rotation of the frame in the nominal pose.
    """
    frame = model.getFrameId(name)
    joint_from_foot = model.frames[frame].placement
    spheres, lowest = [], None
    for item in geometry.geometryObjects:
        if item.parentFrame != frame:
            continue
        foot_from_item = joint_from_foot.actInv(item.placement)
        shape = item.geometry
        if type(shape).__name__ == "Sphere":
            spheres.append((foot_from_item.translation.copy(), float(shape.radius)))
        elif type(shape).__name__.startswith("BVHModel"):
            points = np.array([shape.vertex(k) for k in range(shape.num_vertices)])
            points = points @ foot_from_item.rotation.T + foot_from_item.translation
            lowest = float((points @ rotation_world_foot.T)[:, 2].min())
    if len(spheres) >= 3:
        return Foot(name, frame, np.array([c for c, _ in spheres]), min(r for _, r in spheres))
    if spheres:
        centre, radius = spheres[0]
        return Foot(name, frame, centre[None, :], radius)
    radius = -lowest if lowest is not None and lowest < -1e-3 else DEFAULT_RADIUS
    return Foot(name, frame, np.zeros((1, 3)), radius)
