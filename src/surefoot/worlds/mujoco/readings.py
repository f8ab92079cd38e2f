"""What is read of MuJoCo: forces and velocities at the feet's spheres, states in Pinocchio's order."""

from __future__ import annotations

import numba
import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import INTEGER, MATRIX, REAL, VECTOR, inline_kernel, kernel
from surefoot.base.spatial import quaternion_xyzw, rotation_from_quaternion

OWN_TYPES = (
    MATRIX, MATRIX, MATRIX, numba.int32[:, :], numba.int32[:], REAL[:, :], VECTOR,
    INTEGER[::1], INTEGER[:, ::1], MATRIX, REAL[:, :, ::1], VECTOR, REAL[:, :, ::1], MATRIX,
)  # fmt: skip
"""Types of what `read_contacts` is given of MuJoCo itself, whose contacts lie apart in memory."""
FACE_TYPES = (
    VECTOR, MATRIX, numba.int32[:, :], numba.int32[:], REAL[:, :], REAL[:], VECTOR, INTEGER[::1],
    numba.boolean,
)  # fmt: skip
"""The same of `face_principal`."""
SAME_FACE = 0.5
"""Least cosine between normals of one surface: facets of a mesh are one, a floor and a riser are two."""
LEAST_FORCE = 1e-6
"""Force [N] up to which what facets push together is their forces added up, but for rounding."""


@inline_kernel
def toward(frame: FloatArray, sign: float, normal: FloatArray) -> float:
    """Return the cosine between a contact's normal, (9,) frame and sign, and a surface's (3,)."""
    along: float = frame[0] * normal[0] + frame[1] * normal[1] + frame[2] * normal[2]
    return sign * along


@inline_kernel
def _is_of_sphere(pairs: IntArray, addresses: IntArray, owner: IntArray, c: int, k: int) -> bool:
    """Return whether contact c presses and is of a foot's sphere k with the ground."""
    first, second = owner[pairs[c, 0]], owner[pairs[c, 1]]
    return bool(addresses[c] >= 0 and min(first, second) == -1 and max(first, second) == k)


@kernel
def face_principal(
    gaps: FloatArray,
    normals: FloatArray,
    pairs: IntArray,
    addresses: IntArray,
    contact_frames: FloatArray,
    distances: FloatArray,
    constraint_forces: FloatArray,
    owner: IntArray,
    moved: bool,
) -> None:
    """Turn gaps and normals to the surface that bears most, of those that a foot touches.

    A foot in a corner touches floor and riser. Which of the two is nearer changes from step to step by less
    than a hair, which bears it does not. On curved ground MuJoCo's normals are those of facets, degrees off
    the terrain's: a foot that bears has the mean of its facets', by their forces.

    Parameters
    ----------
    gaps, normals
        (p,) [m] and (p, 3) of the nearest ground at each sphere; changed.
    pairs, addresses, contact_frames, constraint_forces, owner
        See `read_contacts`.
    distances
        (c,) of MuJoCo's contacts [m].
    moved
        Whether the spheres have moved since gaps were found: those of spheres that touch are MuJoCo's then.
    """
    for k in range(len(gaps)):
        # Of the contacts of sphere k with the ground, the one with the largest normal force.
        best, most = -1, 0.0
        for c in range(len(addresses)):
            if _is_of_sphere(pairs, addresses, owner, c, k) and constraint_forces[addresses[c]] > most:
                best, most = c, constraint_forces[addresses[c]]
        if best < 0:
            continue
        sign, frame = (1.0 if owner[pairs[best, 1]] >= 0 else -1.0), contact_frames[best]
        if moved or toward(frame, sign, normals[k]) < SAME_FACE:
            gaps[k] = distances[best]
        face, mean = sign * frame[:3], np.zeros(3)
        for c in range(len(addresses)):
            if not _is_of_sphere(pairs, addresses, owner, c, k):
                continue
            way = 1.0 if owner[pairs[c, 1]] >= 0 else -1.0
            if toward(contact_frames[c], way, face) >= SAME_FACE:
                for i in range(3):
                    mean[i] += way * constraint_forces[addresses[c]] * contact_frames[c, i]
        length = np.sqrt(mean[0] ** 2 + mean[1] ** 2 + mean[2] ** 2)
        for i in range(3):
            normals[k, i] = mean[i] / length


@inline_kernel
def _turn_tangents(frame: FloatArray, tangential: FloatArray, force: FloatArray, missed: FloatArray) -> None:
    """Fill a force's tangents from (3,) world axes; add what it lacks to the (3,) sum of normal parts."""
    for j in range(2):
        for i in range(3):
            force[j] += frame[i, j] * tangential[i]
    for i in range(3):
        missed[i] += tangential[i]
        for j in range(3):
            missed[i] -= frame[i, j] * force[j]


@inline_kernel
def _velocity_at(twist: FloatArray, centre: FloatArray, place: FloatArray) -> tuple[float, float, float]:
    """Return v + ω x r of a body at a (3,) place; MuJoCo's twist (6,) is that at its tree's centre."""
    x, y, z = place[0] - centre[0], place[1] - centre[1], place[2] - centre[2]
    p, q, r = twist[0], twist[1], twist[2]
    return twist[3] + q * z - r * y, twist[4] + r * x - p * z, twist[5] + p * y - q * x


@kernel
def read_contacts(
    geom_places: FloatArray,
    body_twists: FloatArray,
    tree_centres: FloatArray,
    pairs: IntArray,
    addresses: IntArray,
    contact_frames: FloatArray,
    constraint_forces: FloatArray,
    owner: IntArray,
    spheres: IntArray,
    sizes: FloatArray,
    frames: FloatArray,
    gaps: FloatArray,
    out: FloatArray,
    missed: FloatArray,
) -> bool:
    """Fill in what the ground did to the feet's spheres; return whether any other contact pushed.

    A force's normal part is that along MuJoCo's own contact normals, its tangential part what is left,
    turned into the frame's tangents: of several facets under one foot each has a normal of its own, some
    degrees off their mean, which would otherwise look like a broken cone. Facets that lean towards each other
    push less together than their forces added up: the motion needs what that makes too much, `missed`. A
    contact whose normal is far from the frame's is one with another surface (a foot in a corner has two), and
    counts among the others.

    Parameters
    ----------
    geom_places, body_twists, tree_centres
        MuJoCo's geom_xpos (geoms, 3) [m], cvel (bodies, 6) [angular; linear] and subtree_com (bodies, 3) [m].
    pairs, addresses, contact_frames
        MuJoCo's contacts: (c, 2) geoms, (c,) first constraint row (-1: none), (c, 9) frames, the first
        row of which points from the first geom to the second.
    constraint_forces
        MuJoCo's efc_force; with elliptic cones a contact's rows are its force (normal, tangent, tangent).
    owner
        (geoms,) number of a foot's sphere, -1 for the ground, -2 for anything else.
    spheres
        (p, 3) geom, body, and root of the body's tree.
    sizes
        (p, 2) radius, and the offset of a plane along its normal [m].
    frames
        (p, 3, 3) of the terrain at the spheres, world axes.
    gaps
        (p,) to the planes [m]; filled.
    out
        (3, p, 3) forces [N] and velocities [m/s] in contact frames, positions [m] in world axes; filled.
    missed
        (p, 3) the sum of each sphere's forces less the force that is told, world axes [N]; filled.
    """
    count = len(spheres)
    forces, velocities, positions = out[0], out[1], out[2]
    tangential = out[1]  # in world axes, until the velocities are known
    forces[:], tangential[:], missed[:] = 0.0, 0.0, 0.0
    beside = False
    for c in range(len(addresses)):
        at, first, second = addresses[c], owner[pairs[c, 0]], owner[pairs[c, 1]]
        if at < 0:
            continue
        if min(first, second) != -1 or max(first, second) < 0:
            beside = beside or constraint_forces[at] > 0.0
            continue
        # MuJoCo's frame points from the first geom to the second
        k, sign = max(first, second), (1.0 if second >= 0 else -1.0)
        if toward(contact_frames[c], sign, frames[k, :, 2]) < SAME_FACE:
            beside = beside or constraint_forces[at] > 0.0
            continue
        # MuJoCo's force acts on the second geom along +frame: its sign is turned where the foot is the first
        # one.
        forces[k, 2] += constraint_forces[at]
        for j in range(3):
            missed[k, j] += sign * constraint_forces[at] * contact_frames[c, j]
        for i in range(1, 3):
            for j in range(3):
                tangential[k, j] += sign * constraint_forces[at + i] * contact_frames[c, 3 * i + j]
    for k in range(count):
        geom, body, root = spheres[k, 0], spheres[k, 1], spheres[k, 2]
        height = 0.0
        for i in range(3):
            height += geom_places[geom, i] * frames[k, i, 2]
            positions[k, i] = geom_places[geom, i] - sizes[k, 0] * frames[k, i, 2]
        gaps[k] = height - sizes[k, 1] - sizes[k, 0]
        a, b, c_ = _velocity_at(body_twists[body], tree_centres[root], positions[k])
        _turn_tangents(frames[k], tangential[k], forces[k], missed[k])
        for j in range(3):
            velocities[k, j] = frames[k, 0, j] * a + frames[k, 1, j] * b + frames[k, 2, j] * c_
    return beside


@kernel
def to_pinocchio(q: FloatArray, v: FloatArray) -> None:
    """Turn MuJoCo's q (nq,) [m, -, rad] and v (nv,) [m/s, rad/s] of a floating robot into Pinocchio's."""
    w, x, y, z = q[3], q[4], q[5], q[6]
    q[3], q[4], q[5], q[6] = x, y, z, w
    a, b, c = v[0], v[1], v[2]
    # world to base axes: rotate by the conjugate quaternion, t = -2 (r x u), u + w t - r x t
    s, t, r = -2.0 * (y * c - z * b), -2.0 * (z * a - x * c), -2.0 * (x * b - y * a)
    v[0] = a + w * s - (y * r - z * t)
    v[1] = b + w * t - (z * s - x * r)
    v[2] = c + w * r - (x * t - y * s)


def pinocchio_state(qpos: FloatArray, qvel: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return a MuJoCo state in Pinocchio's order: q (nq,) [m, -, rad], v (nv,) [m/s, rad/s]."""
    q, v = qpos.copy(), qvel.copy()
    q[3:7] = quaternion_xyzw(qpos[3:7])
    v[:3] = rotation_from_quaternion(q[3:7]).T @ qvel[:3]
    return q, v
