"""Contact points of two shapes that are near each other, from the normal and distance that coal gives.

Where the normal is that of a box's face, the feature of the other shape that faces it is cut to that face,
and every vertex of what is left is a contact with its own gap: up to eight of two boxes, two of a capsule, so
that a body at rest has all that carries it, however small its tilt. Otherwise the nearest points are the
contact, and for two lines that are nearly parallel (capsules, edges) the ends of their overlap as well.

coal's own contact patches lay all points of a pair into one plane at one depth, within a tolerance: a box
that tips by less than that would have contacts under its raised side.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import kernel

TILT = 1e-3
"""Angle up to which a normal is taken for that of a face."""
ALIGNED = 1.0 - 0.5 * TILT * TILT
AGREED = 2e-7
"""How far the least gap on a face may be above coal's distance [m], besides the share `TILT` of it."""
SLACK = 1e-7
"""How far outside a face a vertex still counts as on it [m]: edges that lie on edges stay what they are."""
PARALLEL = 0.1
"""Sine of the angle up to which two lines are looked at in more than one place."""


@kernel
def manifolds(
    pairs: IntArray, slots: IntArray, half: FloatArray, radius: FloatArray, rotation: FloatArray,
    centre: FloatArray, seen: FloatArray, gaps: FloatArray, points: FloatArray, normals: FloatArray,
) -> None:  # fmt: skip
    """Write gaps (p,), points (p, 3) and normals (p, 3) of the contacts of pairs of shapes; others are left.

    `pairs` (k, 2) index the shapes and `slots` (k,) the first contact of each pair; `half` (s, 3), `radius`
    (s,), `rotation` (s, 3, 3) and `centre` (s, 3) are the shapes' cores and poses. `seen` (k, 10) is normal
    from the first to the second, distance, and nearest points. A point lies halfway between the surfaces.
    """
    table, sheet = np.empty((16, 4)), np.empty((16, 4))
    for i in range(pairs.shape[0]):
        a, b, first = pairs[i, 0], pairs[i, 1], slots[i]
        n = seen[i, :3]
        face_a, fit_a = _face(half[a], rotation[a], n)
        face_b, fit_b = _face(half[b], rotation[b], n)
        done = False
        if max(fit_a, fit_b) >= ALIGNED:
            # on a tie, up to rounding, the first shape's face
            flip = fit_b > fit_a + 1e-12
            ref, inc, face = (b, a, face_b) if flip else (a, b, face_a)
            # which of the two sides of that axis looks at the other shape
            out = 1.0
            for sign in (-1.0, 1.0):
                along = 0.0
                for k in range(3):
                    along += sign * rotation[ref, k, face] * n[k] * (-1.0 if flip else 1.0)
                if along > 0.0:
                    out = sign
            # the other's side that looks back, cut to the face
            count = _facing(
                half[inc], rotation[inc], centre[inc], rotation[ref], centre[ref], face, out, table
            )
            count = _clip_polygon(table, sheet, count, half[ref], face)
            lift, least = half[ref, face] + radius[ref], np.inf
            for k in range(count):
                least = min(least, table[k, 2] - lift - radius[inc])
            # else what is nearest lies beside the face
            done = least - seen[i, 3] <= AGREED + TILT * abs(seen[i, 3])
            if done:
                _place(
                    table, count, lift, radius[inc], rotation[ref], centre[ref], face, out, flip, first,
                    gaps, points, normals,
                )  # fmt: skip
        if not done:
            _nearest(a, b, half, radius, rotation, centre, seen[i], first, gaps, points, normals)


@kernel
def _face(half: FloatArray, R: FloatArray, n: FloatArray) -> tuple[int, float]:
    """Return the axis of a box that is best aligned with n, and the cosine; -1 for what has no faces."""
    # spheres and capsules have cores without volume, and no faces
    if half[0] * half[1] * half[2] == 0.0:
        return 0, -1.0
    best, cosine = 0, -1.0
    for j in range(3):
        along = abs(R[0, j] * n[0] + R[1, j] * n[1] + R[2, j] * n[2])
        if along > cosine:
            best, cosine = j, along
    return best, cosine


@kernel
def _facing(
    half: FloatArray, R: FloatArray, c: FloatArray, R_ref: FloatArray, c_ref: FloatArray, face: int,
    out: float, table: FloatArray,
) -> int:  # fmt: skip
    """Write the vertices of a core that face a box's face: x, y in it, height from its middle, index.

    Returns how many: a point, the ends of a line, or the corners of the side that looks at the face.
    """
    side, cosine, sense = 0, -1.0, 1.0
    for j in range(3):
        along = out * (R[0, j] * R_ref[0, face] + R[1, j] * R_ref[1, face] + R[2, j] * R_ref[2, face])
        # the side most against the face's normal
        if abs(along) > cosine:
            side, cosine, sense = j, abs(along), -1.0 if along > 0.0 else 1.0
    u, v = (side + 1) % 3, (side + 2) % 3
    count = 0
    for corner in range(4):
        s, t = (1.0 if corner in (0, 3) else -1.0), (1.0 if corner < 2 else -1.0)
        # an edge or a point is a side of no width: each vertex once
        if (half[u] == 0.0 and s < 0.0) or (half[v] == 0.0 and t < 0.0):
            continue
        x = y = z = 0.0
        for k in range(3):
            w = (
                c[k]
                - c_ref[k]
                + sense * half[side] * R[k, side]
                + s * half[u] * R[k, u]
                + t * half[v] * R[k, v]
            )
            x += w * R_ref[k, (face + 1) % 3]
            y += w * R_ref[k, (face + 2) % 3]
            z += out * w * R_ref[k, face]
        table[count, 0], table[count, 1], table[count, 2], table[count, 3] = x, y, z, count
        count += 1
    return count


@kernel
def _clip_polygon(table: FloatArray, sheet: FloatArray, count: int, half: FloatArray, face: int) -> int:
    """Cut a polygon, line or point in `table` to a rectangle (Sutherland and Hodgman); return its vertices.

    Vertices that the cut makes have the index -1.
    """
    for edge in range(4):
        axis, sense = edge // 2, (1.0 if edge % 2 == 0 else -1.0)
        limit = half[(face + 1 + axis) % 3] + SLACK
        kept = 0
        for i in range(count):
            j = (i + 1) % count
            here, there = limit - sense * table[i, axis], limit - sense * table[j, axis]
            if here >= 0.0:
                for k in range(4):
                    sheet[kept, k] = table[i, k]
                kept += 1
            # a line has one edge, not two: it is crossed from its first vertex only
            if (here >= 0.0) != (there >= 0.0) and (count > 2 or i == 0):
                # where the edge crosses the border
                t = here / (here - there)
                for k in range(3):
                    sheet[kept, k] = table[i, k] + t * (table[j, k] - table[i, k])
                sheet[kept, 3] = -1.0
                kept += 1
        count = kept
        for i in range(count):
            for k in range(4):
                table[i, k] = sheet[i, k]
    return count


@kernel
def _place(
    table: FloatArray, count: int, lift: float, r: float, R: FloatArray, c: FloatArray, face: int, out: float,
    flip: bool, first: int, gaps: FloatArray, points: FloatArray, normals: FloatArray,
) -> None:  # fmt: skip
    """Write the contacts of what was cut to a face; vertices take the slot of their index, cuts the rest."""
    # a vertex keeps its slot, so that a contact keeps its number from step to step
    taken = np.zeros(8, dtype=np.bool_)
    for i in range(count):
        if table[i, 3] >= 0.0:
            taken[int(table[i, 3])] = True
    free = 0
    for i in range(count):
        slot = int(table[i, 3])
        if slot < 0:
            while free < 8 and taken[free]:
                free += 1
            if free == 8:
                return
            slot = free
            taken[slot] = True
        gap = table[i, 2] - lift - r
        gaps[first + slot] = gap
        for k in range(3):
            normal = out * R[k, face]
            points[first + slot, k] = (
                c[k] + table[i, 0] * R[k, (face + 1) % 3] + table[i, 1] * R[k, (face + 2) % 3]
                + (lift + 0.5 * gap) * normal
            )  # fmt: skip
            normals[first + slot, k] = -normal if flip else normal


@kernel
def _nearest(
    a: int, b: int, half: FloatArray, radius: FloatArray, rotation: FloatArray, centre: FloatArray,
    seen: FloatArray, first: int, gaps: FloatArray, points: FloatArray, normals: FloatArray,
) -> None:  # fmt: skip
    """Write the nearest points as a contact, and the ends of the overlap of nearly parallel lines."""
    n = seen[:3]
    gaps[first] = seen[3]
    for k in range(3):
        points[first, k] = 0.5 * (seen[4 + k] + seen[7 + k])
        normals[first, k] = n[k]
    if not (half[a].any() and half[b].any()):  # a ball touches in one place
        return
    at_a, along_a, at_b, along_b = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    length_a = _line(half[a], rotation[a], centre[a], n, 1.0, at_a, along_a)
    length_b = _line(half[b], rotation[b], centre[b], n, -1.0, at_b, along_b)
    if length_a == 0.0 or length_b == 0.0:
        return
    # two lines, such as capsules' or edges that face each other: overlap along a, in a's own parameter
    cosine = ends = 0.0
    for k in range(3):
        cosine += along_a[k] * along_b[k]
        ends += (at_b[k] - at_a[k]) * along_a[k]
    # lines that cross touch in one place
    if 1.0 - cosine * cosine > PARALLEL * PARALLEL:
        return
    # the stretch along a in which b runs beside it
    reach = length_b * abs(cosine)
    low, high = max(-length_a, ends - reach), min(length_a, ends + reach)
    if high - low < 1e-6:
        return
    together, w = radius[a] + radius[b], np.empty(3)
    for end in range(2):
        t = low if end == 0 else high
        s = 0.0
        for k in range(3):
            s += (at_a[k] + t * along_a[k] - at_b[k]) * along_b[k]
        # the point of b across from an end of the overlap, within b
        s = min(max(s, -length_b), length_b)
        far = straight = 0.0
        for k in range(3):
            w[k] = at_b[k] + s * along_b[k] - at_a[k] - t * along_a[k]
            far += w[k] * w[k]
            straight += w[k] * n[k]
        far = math.sqrt(far)
        # sharp edges that touch have no direction of their own
        round_ones = together > 0.0 and far > 1e-9 and straight > 0.0
        gap = (far if round_ones else straight) - together
        gaps[first + 1 + end] = gap
        for k in range(3):
            normal = w[k] / far if round_ones else n[k]
            points[first + 1 + end, k] = at_a[k] + t * along_a[k] + (radius[a] + 0.5 * gap) * normal
            normals[first + 1 + end, k] = normal


@kernel
def _line(
    half: FloatArray,
    R: FloatArray,
    c: FloatArray,
    n: FloatArray,
    sense: float,
    at: FloatArray,
    along: FloatArray,
) -> float:
    """Write the middle and direction of the line of a core that looks along sense n; return half its length.

    A capsule's is its own, a box's the edge; 0 for a point.
    """
    # of a box the edge most across the normal
    axis, least = 2, 2.0
    if half[0] > 0.0:
        for j in range(3):
            cosine = abs(R[0, j] * n[0] + R[1, j] * n[1] + R[2, j] * n[2])
            if cosine < least:
                axis, least = j, cosine
    for k in range(3):
        at[k], along[k] = c[k], R[k, axis]
    for j in range(3):
        if j != axis:
            cosine = R[0, j] * n[0] + R[1, j] * n[1] + R[2, j] * n[2]
            # to the side of the box that faces the other shape
            shift = half[j] if sense * cosine >= 0.0 else -half[j]
            for k in range(3):
                at[k] += shift * R[k, j]
    return float(half[axis])
