"""The convex hulls that a model's meshes touch with, as plain corners in the axes of their shapes.

MuJoCo makes a hull of every mesh that may touch and keeps it as a graph: numbers of corners and faces, where
each corner's edges begin, and which of the mesh's vertices the corners are.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray


def hull_facts(mujoco: Any, model: Any, geoms: Sequence[int]) -> dict[str, Any]:
    """Return the corners of hulls of geoms, and whose each is, as facts of a log; none without a mesh.

    Geoms are counted in the order that is given, as the log's `model_geoms` are.
    """
    found = {k: corners for k, geom in enumerate(geoms) if len(corners := hull_of(mujoco, model, geom))}
    if not found:
        return {}
    return {
        "model_hull_corners": np.concatenate(list(found.values())),
        "model_hull_geoms": np.repeat(list(found), [len(corners) for corners in found.values()]),
    }


def hull_of(mujoco: Any, model: Any, geom: int) -> FloatArray:
    """Return the corners (n, 3) of the hull of a geom that is a mesh, in its axes [m]; none of another."""
    mesh = int(model.geom_dataid[geom])
    if int(model.geom_type[geom]) != int(mujoco.mjtGeom.mjGEOM_MESH) or mesh < 0:
        return np.zeros((0, 3))
    graph, first = int(model.mesh_graphadr[mesh]), int(model.mesh_vertadr[mesh])
    if graph < 0 or not (model.geom_contype[geom] or model.geom_conaffinity[geom]):  # nothing touches it
        return np.zeros((0, 3))
    count = int(model.mesh_graph[graph])
    corners = np.asarray(model.mesh_graph[graph + 2 + count : graph + 2 + 2 * count])
    return np.array(model.mesh_vert[first + corners], dtype=np.float64)
