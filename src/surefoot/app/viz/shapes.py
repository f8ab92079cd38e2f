"""Outlines that several pictures draw: closed polygons, cones, bones."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from surefoot.base.arrays import FloatArray

if TYPE_CHECKING:
    from surefoot.mechanics import Robot


def ring(corners: FloatArray) -> FloatArray:
    """Return (k + 1, d) corners of a polygon with the first one once more at the end."""
    return np.vstack([corners, corners[:1]])


def cone_rim(mu: float, height: float, rotation_world_contact: FloatArray, edges: int) -> FloatArray:
    """Return (edges + 1, 3) points of a friction cone's rim about its apex, world axes, closed.

    Parameters
    ----------
    mu
        Friction coefficient.
    height
        Of the rim above the apex, along the normal [m].
    rotation_world_contact
        (3, 3), its third column the normal.
    edges
        Sides of the polygon that stands for the circle.
    """
    angle = np.linspace(0.0, 2.0 * np.pi, edges + 1)
    circle = np.column_stack([mu * np.cos(angle), mu * np.sin(angle), np.ones(edges + 1)])
    return np.asarray(height * circle @ rotation_world_contact.T)


def along_path(places: FloatArray) -> FloatArray:
    """Return the (2,) direction from the first to the last of (n, 2) places; x where they are the same."""
    way = places[-1] - places[0]
    length = float(np.linalg.norm(way))
    return np.asarray(way / length) if length > 1e-9 else np.array([1.0, 0.0])


def bones(robot: Robot, q: FloatArray) -> FloatArray:
    """Return the (m, 2, 3) ends of a robot's bones at (nq,) q [m]: joint to joint, and to contact points.

    A joint without mass, such as the slides on which a ball moves, carries no bone.
    """
    import pinocchio

    model, points, data = robot.model, robot.contact_points, robot.model.createData()
    pinocchio.forwardKinematics(model, data, np.asarray(q, dtype=np.float64))
    places = np.array([pose.translation for pose in data.oMi])
    parents = [int(k) for k in model.parents]
    moved = [k for k in range(2, model.njoints) if model.inertias[parents[k]].mass > 0.0]
    lines = [(places[parents[k]], places[k]) for k in moved]
    for joint, place in zip(points.joints, points.places, strict=True):
        lines.append((places[int(joint)], np.array(data.oMi[int(joint)].act(place))))
    return np.array(lines).reshape(-1, 2, 3)
