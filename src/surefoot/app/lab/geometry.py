"""Surfaces of what pages draw: cones, polygons, and the ground, which passes below a robot that goes far."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np

from surefoot.app.lab import drawing as draw
from surefoot.app.viz.shapes import cone_rim
from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.spatial import quaternion_from_rotation, quaternion_wxyz
from surefoot.contact import FrictionCone
from surefoot.mechanics import Terrain

SIDES = 32
"""Sides of the polygon that stands for a circle."""
CORNERS = 48
"""Corners that every polygon's mesh has: a polygon with fewer repeats its last one."""
CELLS = 160
"""Cells along a side of ground that is no plane: a riser is as steep as one."""


@cache
def fan(count: int) -> IntArray:
    """Return the (m, 3) triangles from vertex 0 to those of a ring 1 .. count."""
    first = np.arange(1, count + 1)
    second = np.where(first == count, 1, first + 1)
    return np.column_stack([np.zeros(len(first), dtype=np.int64), first, second])


def cone_surface(mu: float, height: float, rotation_world_contact: FloatArray) -> FloatArray:
    """Return the (SIDES + 1, 3) vertices of a friction cone about its apex, for `fan(SIDES)` [m].

    Parameters
    ----------
    mu
        Friction coefficient.
    height
        Of the rim above the apex, along the normal [m].
    rotation_world_contact
        (3, 3), its third column the normal.
    """
    rim = cone_rim(FrictionCone(mu).mu, height, rotation_world_contact, SIDES)[:-1]
    return np.vstack([np.zeros((1, 3)), rim])


def polygon_surface(corners: FloatArray) -> FloatArray:
    """Return the (CORNERS + 1, 3) vertices of a convex polygon with (k, 3) corners, for `fan(CORNERS)`.

    A polygon of more corners than that loses some, so that what is drawn lies inside.
    """
    k = len(corners)
    if k == 0:
        return np.zeros((CORNERS + 1, 3))
    taken = np.minimum(np.arange(CORNERS), k - 1) if k <= CORNERS else np.arange(CORNERS) * k // CORNERS
    return np.vstack([corners.mean(axis=0, keepdims=True), corners[taken]])


def pose_of(rotation: FloatArray) -> tuple[float, float, float, float]:
    """Return the quaternion (w, x, y, z) of a (3, 3) rotation."""
    w, x, y, z = quaternion_wxyz(quaternion_from_rotation(rotation)).tolist()
    return w, x, y, z


def join_surfaces(parts: Sequence[tuple[FloatArray, IntArray]]) -> tuple[FloatArray, IntArray]:
    """Return several surfaces, (n, 3) vertices [m] and (m, 3) triangles each, as one."""
    offsets = np.cumsum([0, *(len(vertices) for vertices, _ in parts[:-1])])
    faces = [faces + offset for (_, faces), offset in zip(parts, offsets, strict=True)]
    return np.vstack([vertices for vertices, _ in parts]), np.vstack(faces)


def ground_surface(terrain: Terrain, middle: FloatArray, reach: float) -> tuple[FloatArray, IntArray]:
    """Return (n, 3) vertices [m] and (m, 3) triangles of the ground within `reach` of a (2,) place [m]."""
    cells = 1 if terrain.planar else CELLS
    steps = reach * np.linspace(-1.0, 1.0, cells + 1)
    x, y = np.meshgrid(middle[0] + steps, middle[1] + steps, indexing="ij")
    places = np.column_stack([x.ravel(), y.ravel()])
    k = np.arange((cells + 1) ** 2).reshape(cells + 1, cells + 1)
    a, b, c, d = k[:-1, :-1].ravel(), k[1:, :-1].ravel(), k[1:, 1:].ravel(), k[:-1, 1:].ravel()
    faces = np.vstack([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    return np.column_stack([places, terrain.height(places)]), faces


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
        (k, 2) places that the robot passes [m]; flat ground has no end.
    """

    def __init__(self, terrain: Terrain, path: FloatArray) -> None:
        self._flat = terrain.planar and not np.any(terrain.gradient(np.zeros(2)))
        low, high = path.min(axis=0), path.max(axis=0)
        reach = SQUARE if self._flat else AROUND + 0.5 * float((high - low).max())
        middle = np.zeros(2) if self._flat else 0.5 * (low + high)
        self._mesh = draw.Mesh(*ground_surface(terrain, middle, reach), draw.GROUND)

    def shapes(self, origin: FloatArray) -> dict[str, draw.Shape]:
        """Return the ground with a (2,) place of it in the middle [m]."""
        if not self._flat:
            x, y = origin.tolist()
            return {"/ground": replace(self._mesh, position=(-x, -y, 0.0))}
        above = float(self._mesh.vertices[0, 2]) + 1e-3
        places = np.arange(-SQUARE, SQUARE + LINES, LINES) - np.fmod(origin, LINES)[:, None]
        across, along = np.clip(places, -SQUARE, SQUARE).tolist()
        lines = [[(x, -SQUARE, above), (x, SQUARE, above)] for x in across]
        lines += [[(-SQUARE, y, above), (SQUARE, y, above)] for y in along]
        return {"/ground": self._mesh, "/grid": draw.Lines(np.array(lines), draw.GRID, 1.0)}
