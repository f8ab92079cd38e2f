"""The shape of a foot: the spheres with which it touches the ground."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError, shown
from surefoot.mechanics.robot.catalog import CatalogEntry

DEFAULT_RADIUS = 0.02
"""Radius of a foot whose file gives it no shape [m]."""


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
    why
        From which geometry it was read, and how much of that it explains: one sentence.
    """

    name: str
    frame: int
    centres: FloatArray
    radius: float
    why: str = ""

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
        raise ProblemError(f"feet must be names of frames, got {shown(feet)}")
    return feet


def shaped_foot(
    model: Any, name: str, centres: Sequence[tuple[float, float, float]], radius: float, why: str = ""
) -> Foot:
    """Return the foot at a frame with the given (k, 3) sphere centres in that frame and radius [m]."""
    return Foot(name, model.getFrameId(name), np.array(centres, dtype=np.float64), radius, why)


def catalog_feet(model: Any, entry: CatalogEntry, names: Sequence[str]) -> tuple[Foot, ...]:
    """Return the feet at frames with the shapes that a catalogue entry measured."""
    out = []
    for name in names:
        shape = entry.shapes[entry.feet.index(name)]
        foot = shaped_foot(model, name, shape.centres, shape.radius)
        length, width = (1e3 * (size + 2.0 * shape.radius) for size in foot.size)
        what = (
            f"a sole of {length:.0f} x {width:.0f} mm"
            if foot.flat
            else f"a ball of {1e3 * shape.radius:.0f} mm radius"
        )
        out.append(replace(foot, why=f"{name}: {what}, as the catalogue measured it on the robot's meshes"))
    return tuple(out)
