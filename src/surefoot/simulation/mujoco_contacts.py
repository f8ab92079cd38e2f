"""What is read of MuJoCo: forces and velocities at the feet's spheres, states in Pinocchio's order."""

from __future__ import annotations

import numpy as np

from surefoot.arrays import FloatArray, IntArray
from surefoot.kernels import kernel
from surefoot.spatial import quaternion_xyzw, rotation_from_quaternion


@kernel
def read_contacts(
    centres: FloatArray,
    frames: FloatArray,
    radii: FloatArray,
    body_twists: FloatArray,
    body_origins: FloatArray,
    pairs: IntArray,
    addresses: IntArray,
    contact_frames: FloatArray,
    constraint_forces: FloatArray,
    geoms: IntArray,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return forces [N] and velocities [m/s] in contact frames, positions [m] in world axes, all (p, 3).

    A force's normal part is that along MuJoCo's own contact normals, its tangential part what is left,
    turned into the terrain's tangents: on curved ground MuJoCo's normal is a facet's, a degree or so off
    the terrain's, which would otherwise look like a broken cone.

    Parameters
    ----------
    centres, frames, radii
        (p, 3) [m], (p, 3, 3), (p,) [m] of the spheres: centres and terrain frames in world axes.
    body_twists, body_origins
        (p, 6) MuJoCo's cvel [angular; linear] of each sphere's body, and (p, 3) the point it refers
        to: the centre of mass of the kinematic tree.
    pairs, addresses, contact_frames
        MuJoCo's contacts: (c, 2) geoms, (c,) first constraint row (-1: none), (c, 9) frames, the first
        row of which points from the first geom to the second.
    constraint_forces
        MuJoCo's efc_force; with elliptic cones a contact's rows are its force (normal, tangent, tangent).
    geoms
        (p,) geom of each sphere.
    """
    count = centres.shape[0]
    normal, tangential = np.zeros(count), np.zeros((count, 3))
    for c in range(pairs.shape[0]):
        at = addresses[c]
        if at < 0:
            continue
        for k in range(count):
            # MuJoCo's frame points from the first geom to the second
            sign = 1.0 if pairs[c, 1] == geoms[k] else (-1.0 if pairs[c, 0] == geoms[k] else 0.0)
            if sign != 0.0:
                normal[k] += constraint_forces[at]
                for i in range(1, 3):
                    for j in range(3):
                        tangential[k, j] += sign * constraint_forces[at + i] * contact_frames[c, 3 * i + j]
    forces, velocities, positions = np.zeros((count, 3)), np.zeros((count, 3)), np.empty((count, 3))
    for k in range(count):
        forces[k, 2] = normal[k]
        for i in range(3):
            positions[k, i] = centres[k, i] - radii[k] * frames[k, i, 2]
        x = positions[k, 0] - body_origins[k, 0]
        y = positions[k, 1] - body_origins[k, 1]
        z = positions[k, 2] - body_origins[k, 2]
        p, q, r = body_twists[k, 0], body_twists[k, 1], body_twists[k, 2]
        a = body_twists[k, 3] + q * z - r * y
        b = body_twists[k, 4] + r * x - p * z
        c_ = body_twists[k, 5] + p * y - q * x
        for j in range(3):
            velocities[k, j] = frames[k, 0, j] * a + frames[k, 1, j] * b + frames[k, 2, j] * c_
            if j < 2:
                for i in range(3):
                    forces[k, j] += frames[k, i, j] * tangential[k, i]
    return forces, velocities, positions


def pinocchio_state(qpos: FloatArray, qvel: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return a MuJoCo state in Pinocchio's order: q (nq,) [m, -, rad], v (nv,) [m/s, rad/s]."""
    q, v = qpos.copy(), qvel.copy()
    q[3:7] = quaternion_xyzw(qpos[3:7])
    v[:3] = rotation_from_quaternion(q[3:7]).T @ qvel[:3]
    return q, v
