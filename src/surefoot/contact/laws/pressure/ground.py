"""The ground as flat convex pieces under a body."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.errors import ProblemError
from surefoot.terrain import Grid, Plane, Terrain

CELL = 0.005
"""Largest cell of a height field [m]; each is two triangles."""
MOST_CELLS = 250_000


class Facet(NamedTuple):
    """A flat convex piece of ground: corners (k, 3) counter-clockwise from above [m], unit normal (3,)."""

    corners: FloatArray
    normal: FloatArray


def facets(terrain: Terrain, points: FloatArray) -> list[Facet]:
    """Return the pieces of ground below and about (k, 3) points, those of a body [m].

    Raises
    ------
    ProblemError
        If the ground is not of planes and smooth height fields.
    """
    out: list[Facet] = []
    for shape in terrain.shapes():
        if type(shape) not in _PIECES:
            raise ProblemError(
                f"a pressure field takes planes and height fields; {terrain!r} has a {type(shape).__name__}"
            )
        out += _PIECES[type(shape)](shape, points)
    return out


def _plane(plane: Plane, points: FloatArray) -> list[Facet]:
    """Return a square of the plane that reaches beyond the points."""
    local = (points - plane.point) @ plane.rotation
    low, high = local[:, :2].min(axis=0), local[:, :2].max(axis=0)
    reach = np.linalg.norm(high - low) + np.abs(local[:, 2]).max() + 1e-9
    middle = 0.5 * (low + high)
    square = middle + reach * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    corners = plane.point + np.pad(square, ((0, 0), (0, 1))) @ plane.rotation.T
    return [Facet(corners, plane.rotation[:, 2])]


def _grid(grid: Grid, points: FloatArray) -> list[Facet]:
    """Return the triangles of the cells that lie under the points' bounding box."""
    counts = grid.counts(CELL)
    size = grid.size / (counts - 1)
    low = np.floor((points[:, :2].min(axis=0) - grid.origin) / size)
    high = np.ceil((points[:, :2].max(axis=0) - grid.origin) / size)
    low, high = (np.clip(i, 0, counts - 1).astype(np.int64) for i in (low, high))
    nx, ny = high - low
    if nx * ny > MOST_CELLS:
        raise ProblemError(f"the body covers {nx * ny} cells of {CELL:g} m, more than {MOST_CELLS}")
    if nx < 1 or ny < 1:
        return []
    x, y = (grid.origin[a] + size[a] * np.arange(low[a], high[a] + 1) for a in range(2))
    places = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)
    field = np.concatenate([places, grid.height(places)[..., None]], axis=-1)
    a, b, c, d = field[:-1, :-1], field[1:, :-1], field[1:, 1:], field[:-1, 1:]
    triangles = np.concatenate([np.stack(t, axis=2).reshape(-1, 3, 3) for t in ((a, b, c), (a, c, d))])
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    touched = triangles[..., 2].max(axis=1) >= points[:, 2].min()
    return [Facet(t, n) for t, n in zip(triangles[touched], normals[touched], strict=True)]


_PIECES: dict[type, Any] = {Plane: _plane, Grid: _grid}
