"""The shape of a foot: the spheres with which it touches the ground."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError, shown
from surefoot.contact import Sole
from surefoot.mechanics.robot.catalog import CatalogEntry
from surefoot.mechanics.robot.frames import frame_index
from surefoot.mechanics.robot.outlines import area_of, centroid_of, hull_of, inner_rectangle

EXACT = 1e-6
"""Share by which a sole's area may be more than that of the rectangle in it to be one [-]: rounding."""
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
        (k, 3) centres of its contact spheres in the foot's frame [m]: one for a point foot, three to eight
        corners of a convex polygon for a flat one.
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
        """(3,) centre of the contact in the foot's frame [m].

        Of a sole with a corner in each quadrant it is the middle of `size`, of others the centre of its area.
        """
        if not self.flat:
            return np.array(self.centres[0])
        xy = self.centres[:, :2]
        low, high = self._rectangle
        middle = 0.5 * (low + high) if _in_quadrants(xy) else centroid_of(hull_of(xy))
        return np.array([*middle, float(np.mean(self.centres[:, 2]))])

    @property
    def size(self) -> tuple[float, float]:
        """Length and width along the foot's x and y axes [m] of a rectangle in its sole; zeros for points."""
        if not self.flat:
            return 0.0, 0.0
        low, high = self._rectangle
        return float(high[0] - low[0]), float(high[1] - low[1])

    @property
    def size_words(self) -> str:
        """Its size in words: that of a sole with the rounding of its corners, or a ball's radius."""
        if not self.flat:
            return f"a ball of {1e3 * self.radius:.3g} mm radius"
        length, width = (1e3 * (part + 2.0 * self.radius) for part in self.size)
        return f"a sole of {length:.0f} x {width:.0f} mm"

    @cached_property
    def corners(self) -> FloatArray:
        """(k, 2) corners of the sole from `centre`, along the foot's x and y axes [m]; none for a point."""
        return hull_of(self.centres[:, :2]) - self.centre[:2] if self.flat else np.zeros((0, 2))

    def sole(self, mu: float) -> Sole:
        """Return the sole about `centre`: the convex polygon of the sphere centres, with a friction [-]."""
        length, width = self.size
        rectangle = len(self.corners) == 4 and area_of(self.corners) <= length * width * (1.0 + EXACT)
        return Sole(length, width, mu) if rectangle else Sole.of_corners(self.corners, mu)

    @cached_property
    def _rectangle(self) -> tuple[FloatArray, FloatArray]:
        """Corners of the largest rectangle in the sole; of four spheres, the one in their quadrants."""
        xy = self.centres[:, :2]
        if not _in_quadrants(xy):
            return inner_rectangle(hull_of(xy))
        left, down = (xy < xy.mean(axis=0)).T
        low = np.array([xy[left, 0].max(), xy[down, 1].max()])
        return low, np.array([xy[~left, 0].min(), xy[~down, 1].min()])


def _in_quadrants(xy: FloatArray) -> bool:
    """Return whether (k, 2) points are four, one in each quadrant about their mean."""
    left, down = (xy < xy.mean(axis=0)).T
    return len(xy) == 4 and len({*zip(left.tolist(), down.tolist(), strict=True)}) == 4


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
    return Foot(name, frame_index(model, name), np.array(centres, dtype=np.float64), radius, why)


def catalog_feet(model: Any, entry: CatalogEntry, names: Sequence[str]) -> tuple[Foot, ...]:
    """Return the feet at frames with the shapes that a catalogue entry measured."""
    out = []
    for name in names:
        shape = entry.shapes[entry.feet.index(name)]
        foot = shaped_foot(model, name, shape.centres, shape.radius)
        words = f"{name}: {foot.size_words}, as the catalogue measured it on the robot's meshes"
        out.append(replace(foot, why=words))
    return tuple(out)
