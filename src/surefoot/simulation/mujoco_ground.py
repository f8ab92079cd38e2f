"""The shapes of a terrain as MuJoCo's geoms: planes, boxes and height fields."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from surefoot.arrays import FloatArray, finite_array
from surefoot.contact.laws.soft import MujocoLaw
from surefoot.errors import ProblemError
from surefoot.simulation.mujoco_robot import import_mujoco
from surefoot.spatial import quaternion_from_rotation, quaternion_wxyz
from surefoot.terrain import Box, Grid, Plane, Terrain
from surefoot.terrain.shapes import DEPTH, EXTENT

CELL = 0.0125
"""Largest cell of a height field [m]: MuJoCo's surface is flat within it, the terrain's is smooth."""
MOST_CELLS = 4_000_000
CONTACT_TIME = 0.003
"""Time constant of MuJoCo's soft contact [s]: three steps of 1 ms, where it takes two at least.

Divided by `MujocoWorld.substeps`: the ground gets harder as the steps get shorter.
"""
IMPEDANCE = (0.9, 0.95, 0.001, 0.5, 2.0)
"""MuJoCo's contact impedance (d_min, d_max, width, midpoint, power).

Not closer to one: a foot that turns with its shank at a rate w leaves the ground by itself, since MuJoCo's
constraint leaves out the acceleration w² r at which its surface turns away. The force presses it back by
its share 1 - d: at d = 0.97 a fast foot hops every 20 ms, with 170 N after nothing.
"""


def add_ground(
    spec: Any,
    terrain: Terrain,
    mu: float,
    solref: Sequence[float] | None = None,
    solimp: Sequence[float] | None = None,
) -> None:
    """Add the terrain to an MjSpec as geoms named ``ground...``; see `MujocoWorld` for the softness.

    Raises
    ------
    ProblemError
        If this world has no shape for the terrain, or for numbers that are no softness.
    """
    common = {"contype": 1, "conaffinity": 0, "condim": 3, "priority": 1, "rgba": [0.91, 0.89, 0.85, 1.0]}
    add_shapes(import_mujoco(), spec, terrain, {**common, **surface_of(mu, solref, solimp)})


def surface_of(mu: float, solref: Sequence[float] | None, solimp: Sequence[float] | None) -> dict[str, Any]:
    """Return the attributes of a geom that say its friction and its softness."""
    softness = MujocoLaw(
        (CONTACT_TIME, 1.0) if solref is None else tuple(solref),  # type: ignore[arg-type]
        IMPEDANCE if solimp is None else tuple(solimp),
    )
    return {
        "friction": [max(mu, 1e-5), 0.0, 0.0],
        "solref": list(softness.solref),
        "solimp": list(softness.solimp),
    }


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
