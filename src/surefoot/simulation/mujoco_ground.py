"""Shapes of ground for MuJoCo: planes, stairs of boxes, and height fields."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from surefoot.errors import ProblemError
from surefoot.simulation.walk_terrain import PitTerrain
from surefoot.spatial import quaternion_from_rotation, quaternion_wxyz
from surefoot.stance import HeightfieldTerrain, SlopeTerrain, StairsTerrain, Terrain

HALF_SIZE = 50.0
"""Half the size of what has no size of its own [m]."""
DEPTH = 1.0
"""How far solid ground reaches below its lowest point [m]."""
CELL = 0.0125
"""Largest cell of a height field [m]: MuJoCo's surface is flat within it, the terrain's is smooth."""
MOST_CELLS = 4_000_000


def add_shapes(mujoco: Any, spec: Any, terrain: Terrain, common: dict[str, Any]) -> None:
    """Add a terrain to an MjSpec as geoms named ``ground...`` with the `common` attributes.

    Raises
    ------
    ProblemError
        If there is no shape for the terrain.
    """
    if isinstance(terrain, SlopeTerrain):
        spec.worldbody.add_geom(
            name="ground",
            type=mujoco.mjtGeom.mjGEOM_PLANE,
            size=[HALF_SIZE, HALF_SIZE, 1.0],
            quat=quaternion_wxyz(quaternion_from_rotation(terrain.frame([0.0, 0.0]))),
            **common,
        )
    elif isinstance(terrain, StairsTerrain):
        last = terrain.tread * terrain.steps + HALF_SIZE
        edges = [-HALF_SIZE, *(terrain.tread * np.arange(terrain.steps)).tolist(), last]
        tops = (terrain.rise * np.arange(terrain.steps + 1)).tolist()
        _add_levels(mujoco, spec, edges, tops, common)
    elif isinstance(terrain, PitTerrain):
        end = terrain.start + terrain.length
        _add_levels(
            mujoco, spec, [-HALF_SIZE, terrain.start, end, HALF_SIZE], [0.0, -terrain.depth, 0.0], common
        )
    elif isinstance(terrain, HeightfieldTerrain):
        _add_field(mujoco, spec, terrain, common)
    else:
        raise ProblemError(f"the MuJoCo world has no shape for {terrain!r}")


def _add_levels(
    mujoco: Any, spec: Any, edges: Sequence[float], tops: Sequence[float], common: dict[str, Any]
) -> None:
    """Add boxes across the way: level k from x = edges[k] to edges[k + 1], up to tops[k]."""
    bottom = min(tops) - DEPTH
    for k, ((low, high), top) in enumerate(zip(pairwise(edges), tops, strict=True)):
        spec.worldbody.add_geom(
            name=f"ground:{k}",
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=[0.5 * (high - low), HALF_SIZE, 0.5 * (top - bottom)],
            pos=[0.5 * (low + high), 0.0, 0.5 * (top + bottom)],
            **common,
        )


def _add_field(mujoco: Any, spec: Any, terrain: HeightfieldTerrain, common: dict[str, Any]) -> None:
    """Add a height field that samples the terrain's smooth surface finely."""
    spans = terrain.spacing * (np.array(terrain.heights.shape) - 1.0)
    counts = np.ceil(spans / CELL - 1e-9).astype(int) + 1
    if counts.prod() > MOST_CELLS:
        raise ProblemError(
            f"the MuJoCo world takes height fields of up to {MOST_CELLS * CELL**2:.0f} m², "
            f"got {spans[0]:g} x {spans[1]:g} m"
        )
    x = terrain.origin[0] + np.linspace(0.0, spans[0], counts[0])
    y = terrain.origin[1] + np.linspace(0.0, spans[1], counts[1])
    heights = terrain.height(np.stack(np.meshgrid(x, y, indexing="xy"), axis=-1))  # rows along y
    low, high = float(heights.min()), float(heights.max())
    rise = max(high - low, 1e-6)
    spec.add_hfield(
        name="ground",
        nrow=int(counts[1]),
        ncol=int(counts[0]),
        size=[0.5 * spans[0], 0.5 * spans[1], rise, DEPTH],
        userdata=((heights - low) / rise).astype(np.float32).ravel(),
    )
    middle = terrain.origin + 0.5 * spans
    spec.worldbody.add_geom(
        name="ground",
        type=mujoco.mjtGeom.mjGEOM_HFIELD,
        hfieldname="ground",
        pos=[middle[0], middle[1], low],
        **common,
    )
