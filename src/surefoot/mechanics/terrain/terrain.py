"""The ground as a height field: height, slope, frame and gap at a place, and its shapes for engines."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError
from surefoot.base.spatial import rotation_from_normal
from surefoot.mechanics.terrain.surface_shapes import Shape

STEP = 1e-5
"""Step of the central differences of a terrain that does not write its own gradient [m]."""


class Terrain(ABC):
    """The ground as a height field z = height(x, y), world axes; methods take batches (..., 2 or 3).

    A terrain of its own writes `height`, and `shapes` to be simulated by an engine or drawn. What else is
    known exactly is better written too: `gradient` above all.

    Attributes
    ----------
    planar
        Whether the ground is one plane, so that normal and frame are the same everywhere.
    learns
        Whether it is a belief that changes with what a robot senses (see `motion.ground.terrain_knowledge`).
    noise
        Height differences between neighbouring places that mean nothing [m]; zero for ground that is known.
    """

    planar: ClassVar[bool] = False
    learns: ClassVar[bool] = False
    noise: float = 0.0

    @property
    def text(self) -> str:
        """What `terrain.read_terrain` reads back to the last bit; empty where no text says it."""
        return ""

    @property
    def steepness(self) -> float:
        """Rise over way that a body follows: of a slope, of stairs; 0 on level or rough ground [-]."""
        return 0.0

    @property
    def unsure(self) -> bool:
        """Whether there are steps and it is not known where."""
        return False

    @property
    def highest_step(self) -> float:
        """Largest height that a single step may have to climb or descend [m]."""
        return 0.0

    @abstractmethod
    def height(self, xy: ArrayLike) -> FloatArray:
        """Return the ground height under (..., 2) places [m]: (...)."""

    def gradient(self, xy: ArrayLike) -> FloatArray:
        """Return the slope along x and y [-] at (..., 2) places [m]: (..., 2), here by differences."""
        places, ahead = np.asarray(xy, dtype=np.float64)[..., None, :], STEP * np.eye(2)
        return np.asarray((self.height(places + ahead) - self.height(places - ahead)) / (2.0 * STEP))

    def steps_until(self, place: FloatArray, along: FloatArray) -> float:
        """Return how far ahead of a (2,) place [m] along (2,) the last edge of steps is that is known [m].

        Infinite for ground that is known, minus infinite where no edge is.
        """
        return np.inf

    def noise_at(self, xy: FloatArray) -> float:
        """Return `noise` at a (2,) place [m]: [m]."""
        return self.noise

    def normal(self, xy: ArrayLike) -> FloatArray:
        """Return the unit normals [-] out of the ground at (..., 2) places [m], world axes: (..., 3)."""
        slope = self.gradient(xy)
        out = np.concatenate([0.0 - slope, np.ones((*slope.shape[:-1], 1))], axis=-1)
        return np.asarray(out / np.linalg.norm(out, axis=-1, keepdims=True))

    def gap(self, points: ArrayLike) -> FloatArray:
        """Return the signed distance of (..., 3) points to the tangent plane below them [m]: (...).

        Exact on planes; elsewhere to first order in the curvature.
        """
        p = np.asarray(points, dtype=np.float64)
        above = p[..., 2] - self.height(p[..., :2])
        return np.asarray(above * self.normal(p[..., :2])[..., 2])

    def nearest(self, points: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return the signed distance of (..., 3) points to the ground [m], and the normal there.

        What a sphere touches first. Here `gap` and the normal below the point, right where the ground is
        smooth; a ground with edges and faces says better.

        Returns
        -------
        Distances (...) [m], negative inside the ground, and unit normals (..., 3) out of the ground, world
        axes [-].
        """
        return self.gap(points), self.normal(np.asarray(points, dtype=np.float64)[..., :2])

    def frame(self, xy: ArrayLike, heading: ArrayLike = (1.0, 0.0, 0.0)) -> FloatArray:
        """Return the rotation rotation_world_contact (3, 3) of the ground at one (2,) place [m].

        Its x axis follows the heading (3,), in any unit, world axes.
        """
        return rotation_from_normal(self.normal(xy), heading)

    def levels(self) -> tuple[FloatArray, FloatArray] | None:
        """Return edges and heights of ground in steps along x, see `LevelsTerrain`; None for other ground."""
        return None

    def shapes(self) -> tuple[Shape, ...]:
        """Return the ground as values that engines and renderers build: planes, boxes, grids.

        Raises
        ------
        ProblemError
            If the terrain does not say; ``(Grid(self.height, origin, size),)`` does for any smooth one.
        """
        raise ProblemError(f"an engine has no shape for {self!r}: the terrain has no shapes()")

    def approach(self, clearance: float) -> FloatArray:
        """Return a (2,) place to start from [m], at least `clearance` [m] before the first step."""
        del clearance
        return np.zeros(2)
