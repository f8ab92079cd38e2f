"""How place, normal and gap of a contact move with the two shapes that touch.

Both cores touch in points of a vertex, an edge or a face, which may slide along the feature's own axes T. The
distance x = n d of those points stays the shortest: along each T the normal turns with the body that T is of,
across all of them it follows the points. Where a box's face gave the normal (`manifold`), it turns with that
box alone, and the place is where the features cross.
"""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.spatial import skew

ON_FEATURE = 1e-6
"""How far a point may be from a face's border and still be on it [m]."""
ON_FACE = 1e-12
"""How far the cosine of a normal with a face's may be below one: a face's own is handed on as it is."""
SHARP = 1e-5
"""Radius that touching vertices and edges are given, see `pairs.INSET` [m]."""
PARALLEL = 1e-4
"""Singular values below this share of the largest are none: features that run side by side."""


def contact_rates(
    rotations: FloatArray, centres: FloatArray, cores: FloatArray, radii: FloatArray, points: FloatArray,
    normals: FloatArray, gaps: FloatArray,
) -> FloatArray:  # fmt: skip
    """Return the derivatives (k, 7, 12) of places, normals and gaps of k contacts, see `PairSearch`.

    Rows are those of the place [m], of the normal and of the gap [m]; columns the displacement [m] of the
    body's point there and its turn [rad], of the first body, then of the second; world axes.

    `rotations` (k, 2, 3, 3), `centres` (k, 2, 3), `cores` (k, 2, 3) and `radii` (k, 2) are the two shapes',
    `points` (k, 3), `normals` (k, 3) and `gaps` (k,) the contacts'.
    """
    n, k = normals, len(gaps)
    flat, spin = np.eye(3) - n[:, :, None] * n[:, None, :], skew(n)
    # the place lies halfway between the surfaces: each core's nearest point
    # is half a gap and its radius from it
    far = 0.5 * gaps[:, None] + radii  # of the cores' points from the place, along the normal
    cored = points[:, None] + np.array([[-1.0], [1.0]]) * (far[:, :, None] * n[:, None])
    local = np.einsum("ksji,ksj->ksi", rotations, cored - centres)
    # along the axes in which a core's point lies within its feature (an
    # edge, a face) it may slide as bodies move
    free = rotations * (np.abs(local) < cores - ON_FEATURE)[:, :, None, :]
    # whose face the normal is
    cosines = np.abs(np.einsum("ksji,kj->ksi", rotations, n)).max(axis=2)
    face = (cosines > 1.0 - ON_FACE) & (cores > 0.0).all(axis=2)
    # of two faces that agree the first gives the normal, as `manifolds` decides
    face[:, 1] &= ~face[:, 0]
    edges = free * ~face.any(axis=1)[:, None, None, None]
    guides = np.where(face[:, :, None, None], rotations, edges)
    # displacements (k, 3, 12) of the cores' points, and of their distance
    moves = np.zeros((k, 2, 3, 12))
    for side, sign in ((0, 1.0), (1, -1.0)):
        moves[:, side, :, 6 * side : 6 * side + 3] = np.eye(3)
        moves[:, side, :, 6 * side + 3 : 6 * side + 6] = sign * far[:, side, None, None] * spin
    apart = moves[:, 1] - moves[:, 0]
    # the normal: with the guides' bodies along them, with the points across
    # along a guide T the normal keeps its right angle: T·dn = -dT·n, with dT = ω x T
    rows = np.concatenate([guides[:, 0], guides[:, 1]], axis=2).swapaxes(1, 2) @ flat
    turned = np.zeros((k, 6, 12))
    turned[:, :3, 3:6], turned[:, 3:, 9:] = -rows[:, :3] @ spin, -rows[:, 3:] @ spin
    back, distance = np.linalg.pinv(rows, rcond=PARALLEL), gaps + radii.sum(axis=1)
    # over the distance of the cores' points; a touching pair of sharp ones is given a
    # radius, or it would turn at any move
    across = (flat - back @ rows) / np.maximum(np.abs(distance), SHARP)[:, None, None]
    normal = back @ turned + across @ apart
    # the place: both points slide until they lie across from each other
    # T_1 a - T_2 b = what apart - x dn leaves in the tangent plane; of sliding along
    # parallel features the least is taken
    slides = flat @ np.concatenate([free[:, 0], -free[:, 1]], axis=2)
    way = np.linalg.pinv(slides, rcond=PARALLEL) @ (flat @ apart - distance[:, None, None] * normal)
    moves += np.stack([free[:, 0] @ way[:, :3], free[:, 1] @ way[:, 3:]], axis=1)
    place = 0.5 * moves.sum(axis=1) + 0.5 * (radii[:, 0] - radii[:, 1])[:, None, None] * normal
    return np.concatenate([place, normal, n[:, None] @ (moves[:, 1] - moves[:, 0])], axis=1)
