"""Ground below a robot that goes far: the picture goes with the robot, the ground passes below it."""

from __future__ import annotations

import math

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.errors import ProblemError
from surefoot.lab import drawing as draw
from surefoot.lab.drawing import Mesh, Shape
from surefoot.lab.geometry import ground_surface
from surefoot.terrain import Terrain

AROUND = 2.0
"""How far around a path the ground is drawn [m]."""
LINES = 0.25
"""Distance of the lines on flat ground [m]."""
SQUARE = 1.5
"""Half the side of the piece of flat ground that is drawn [m]."""


class MovingGround:
    """Draws the ground where a robot goes, seen from the robot.

    Parameters
    ----------
    terrain
        That is drawn.
    path
        (k, 2) places that the robot passes [m]; None for flat ground that has no end.
    """

    def __init__(self, terrain: Terrain, path: FloatArray | None = None) -> None:
        self._flat = terrain.planar and not np.any(terrain.gradient(np.zeros(2)))
        self._height = float(terrain.height(np.zeros(2)))
        self._mesh: Mesh | None = None
        if not self._flat and path is not None:
            low, high = path.min(axis=0), path.max(axis=0)
            reach = AROUND + 0.5 * float((high - low).max())
            try:
                self._mesh = Mesh(*ground_surface(terrain, 0.5 * (low + high), reach), draw.GROUND)
            except ProblemError:  # a terrain that has no shapes is not drawn
                self._mesh = None

    def shapes(self, origin: FloatArray) -> dict[str, Shape]:
        """Return the ground with a (2,) place of it in the middle [m]."""
        x, y = origin.tolist()
        if self._mesh is not None:
            m = self._mesh
            return {"/ground": Mesh(m.vertices, m.faces, m.colour, position=(-x, -y, 0.0))}
        if not self._flat:
            return {}
        z = self._height
        corner, count = SQUARE, int(2 * SQUARE / LINES) + 1
        square = np.array(
            [[-corner, -corner, z], [corner, -corner, z], [corner, corner, z], [-corner, corner, z]]
        )
        along = [-corner + LINES * k - math.fmod(p, LINES) for p in (x, y) for k in range(count)]
        lines = [[(s, -corner, z), (s, corner, z)] for s in along[:count]]
        lines += [[(-corner, s, z), (corner, s, z)] for s in along[count:]]
        grid = np.clip(np.array(lines), -corner, corner) + np.array([0.0, 0.0, 1e-3])
        faces = np.array([[0, 1, 2], [0, 2, 3]])
        return {"/ground": Mesh(square, faces, draw.GROUND), "/grid": draw.Lines(grid, draw.GRID, 1.0)}
