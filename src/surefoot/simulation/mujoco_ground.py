"""The shapes of a terrain as MuJoCo's geoms: planes, boxes and height fields."""

from __future__ import annotations

from typing import Any

import numpy as np

from surefoot.arrays import FloatArray, finite_array
from surefoot.errors import ProblemError
from surefoot.spatial import quaternion_from_rotation, quaternion_wxyz
from surefoot.terrain import Box, Grid, Plane, Terrain
from surefoot.terrain.shapes import DEPTH, EXTENT

CELL = 0.0125
"""Largest cell of a height field [m]: MuJoCo's surface is flat within it, the terrain's is smooth."""
MOST_CELLS = 4_000_000


def add_shapes(mujoco: Any, spec: Any, terrain: Terrain, common: dict[str, Any]) -> None:
    """Add a terrain to an MjSpec as geoms named ``ground...`` with the `common` attributes.

    Raises
    ------
    ProblemError
        If the terrain has no shapes, or others than these, or a grid is too large.
    """
    shapes = terrain.shapes()
    for k, shape in enumerate(shapes):
        name = f"ground:{k}" if len(shapes) > 1 else "ground"
        if type(shape) not in _GEOMS:
            raise ProblemError(
                f"the MuJoCo world takes planes, boxes and grids, a {type(terrain).__name__} is made of a "
                f"{type(shape).__name__}"
            )
        geom = _GEOMS[type(shape)](mujoco, spec, name, shape)
        spec.worldbody.add_geom(name=name, **geom, **common)


def _plane(mujoco: Any, spec: Any, name: str, plane: Plane) -> dict[str, Any]:
    half = 0.5 * EXTENT
    return {
        "type": mujoco.mjtGeom.mjGEOM_PLANE,
        "size": [half, half, 1.0],
        "pos": plane.point,
        "quat": quaternion_wxyz(quaternion_from_rotation(plane.rotation)),
    }


def _box(mujoco: Any, spec: Any, name: str, box: Box) -> dict[str, Any]:
    return {"type": mujoco.mjtGeom.mjGEOM_BOX, "size": 0.5 * box.size, "pos": box.centre}


def _grid(mujoco: Any, spec: Any, name: str, grid: Grid) -> dict[str, Any]:
    """Sample the surface finely into a height field of the same name."""
    nx, ny = (int(n) for n in grid.counts(CELL))
    if nx * ny > MOST_CELLS:
        raise ProblemError(
            f"the MuJoCo world takes height fields of up to {MOST_CELLS * CELL**2:.0f} m², "
            f"got {grid.size[0]:g} x {grid.size[1]:g} m"
        )
    heights = grid.heights(CELL).T  # MuJoCo's rows go along y
    low, high = float(heights.min()), float(heights.max())
    rise = max(high - low, 1e-6)
    half = 0.5 * grid.size
    spec.add_hfield(
        name=name,
        nrow=ny,
        ncol=nx,
        size=[*half, rise, DEPTH],
        userdata=((heights - low) / rise).astype(np.float32).ravel(),
    )
    middle = grid.origin + half
    return {"type": mujoco.mjtGeom.mjGEOM_HFIELD, "hfieldname": name, "pos": [*middle, low]}


_GEOMS: dict[type, Any] = {Plane: _plane, Box: _box, Grid: _grid}


def set_point_friction(world: Any, mu: FloatArray) -> None:
    """Change the friction [-] under each of a MuJoCo world's (p,) contact points, from the next step on.

    What else touches the ground has the friction of `set_friction`.
    """
    model, ground = world.model, world.ground_geoms[0]
    feet = [int(model.geom(f"foot:{name}").id) for name in world.robot.contact_points.names]
    if model.geom_priority[feet[0]] <= model.geom_priority[ground]:  # from now on the feet's own counts
        model.geom_priority[feet] = model.geom_priority[ground] + 1
        model.geom_solref[feet], model.geom_solimp[feet] = (
            model.geom_solref[ground],
            model.geom_solimp[ground],
        )
    model.geom_friction[feet, 0] = np.maximum(finite_array("mu", mu, (len(feet),)), 1e-5)
