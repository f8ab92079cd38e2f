"""Contacts and open contact points of an MjData as rows of numbers, in compiled code; see `contact_pass`."""

from __future__ import annotations

import math

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import inline_kernel
from surefoot.mechanics import surface_frames
from surefoot.worlds.mujoco.memory_places import FIRST_BYTE
from surefoot.worlds.mujoco.record_contact_rows import CREEP, FIELDS, GAP, MU, TURN
from surefoot.worlds.mujoco.record_copy import FORCE, SOFTNESS

FAR = 1.0
"""Gap of a contact point that is open, but for the rows before and after a touch [m]."""
APART = 1e-9
"""Least gap of a contact point whose geoms do not touch [m]."""
OPEN = -1.0
"""Creep of a contact point that is open, for a mark."""
PLACES = 12
(CVEL, CENTRES, GEOM_PLACES, GEOM_AXES, QPOS, DIST, POS, FRAME, MARGIN, FRICTION, DIM, GEOM) = range(PLACES)
"""Places of arrays in memory, then of fields in a contact's struct, in numbers of their kind."""
EXCLUDE, ADDRESS, STRUCT, PYRAMIDS, BODIES, GEOMS, POSITIONS = range(PLACES, PLACES + 7)
"""More fields, words of the struct, whether cones are pyramids, and how many bodies, geoms and positions."""
ALL_PLACES = PLACES + 7
OWN, OTHER, SEEN, FIRST = range(4)
"""Columns of a contact point: its geoms, the row in which it last touched, and first did; -1 for none."""


@inline_kernel
def _velocity(
    floats: FloatArray, cvel: int, centres: int, bodies: IntArray, roots: IntArray, geom: int,
    place: FloatArray, out: FloatArray, sign: float,
) -> None:  # fmt: skip
    """Add the velocity of a geom's material at a (3,) place, times a sign, world axes."""
    body = bodies[geom]
    w, c = cvel + 6 * body, centres + 3 * roots[body]
    x, y, z = place[0] - floats[c], place[1] - floats[c + 1], place[2] - floats[c + 2]
    out[0] += sign * (floats[w + 3] + floats[w + 1] * z - floats[w + 2] * y)
    out[1] += sign * (floats[w + 4] + floats[w + 2] * x - floats[w] * z)
    out[2] += sign * (floats[w + 5] + floats[w] * y - floats[w + 1] * x)


@inline_kernel
def _into(frame: FloatArray, vector: FloatArray, out: FloatArray) -> None:
    """Write a (3,) vector in the axes of a (3, 3) frame."""
    for i in range(3):
        out[i] = frame[0, i] * vector[0] + frame[1, i] * vector[1] + frame[2, i] * vector[2]


@inline_kernel
def _material(floats: FloatArray, at: int, axes: int, geom: int, local: FloatArray, out: FloatArray) -> None:
    """Write where a (3,) place in a geom's axes is, world axes."""
    p, R = at + 3 * geom, axes + 9 * geom
    for i in range(3):
        out[i] = floats[p + i]
        for j in range(3):
            out[i] += floats[R + 3 * i + j] * local[j]


@inline_kernel
def point_of(
    kinds: IntArray, local: FloatArray, place: FloatArray, own: int, other: int, row: int, count: int
) -> int:
    """Return the free contact point of two geoms that was last nearest to a (3,) place, -1 for none."""
    best, least = -1, math.inf
    for s in range(count):
        if kinds[s, OWN] != own or kinds[s, OTHER] != other or kinds[s, SEEN] == row:
            continue
        far = 0.0
        for i in range(3):
            far += (local[s, i] - place[i]) ** 2
        if best < 0 or far < least:
            best, least = s, far
    return best


@inline_kernel
def _force(
    floats: FloatArray, first: int, soft: int, friction: int, dim: int, pyramids: int, out: FloatArray
) -> float:
    """Write a contact's force and moment (6,) in MuJoCo's axes; return R of its friction (round cone)."""
    for k in range(6):
        out[k] = 0.0
    if dim > 1 and pyramids:
        for k in range(dim - 1):
            one, two = floats[first + 2 * k], floats[first + 2 * k + 1]
            out[0] += one + two
            out[k + 1] = (one - two) * floats[friction + k]
        return floats[soft] / (2.0 * floats[friction] ** 2) if floats[friction] > 0.0 else 0.0
    for k in range(dim):
        out[k] = floats[first + k]
    return floats[soft + 1] if dim > 1 else 0.0


@inline_kernel
def write_contact(
    floats: FloatArray, words: IntArray, places: IntArray, at: IntArray, bodies: IntArray, roots: IntArray,
    struct: int, dim: int, address: int, sign: float, own: int, other: int, spare: FloatArray,
    out: FloatArray,
) -> None:  # fmt: skip
    """Write a contact as a row of numbers, see `record_contact_rows`; `spare` is (14, 3)."""
    force, world, turned, axis = spare[:2].reshape(6), spare[2], spare[3], spare[4]
    frame, normals = spare[5:8].reshape((1, 3, 3)), spare[8:9]
    axes, friction = struct + at[FRAME], struct + at[FRICTION]
    R = 0.0
    force[:] = 0.0
    if address >= 0:
        first = (words[places[FORCE]] - FIRST_BYTE) // 8 + address
        soft = (words[places[SOFTNESS]] - FIRST_BYTE) // 8 + address
        R = _force(floats, first, soft, friction, dim, at[PYRAMIDS], force)
    for i in range(3):
        normals[0, i] = sign * floats[axes + i]
        axis[i] = floats[axes + 3 + i]
        out[6 + i] = floats[struct + at[POS] + i]
        out[9 + i] = normals[0, i]
    surface_frames(normals, frame)
    for part in range(2):
        for i in range(3):
            world[i] = 0.0
            for j in range(3):
                world[i] += sign * floats[axes + 3 * j + i] * force[3 * part + j]
        _into(frame[0], world, turned)
        for i in range(3):
            out[(14 if part else 0) + i] = turned[i]
    world[:] = 0.0
    _velocity(floats, at[CVEL], at[CENTRES], bodies, roots, own, out[6:9], world, 1.0)
    _velocity(floats, at[CVEL], at[CENTRES], bodies, roots, other, out[6:9], world, -1.0)
    _into(frame[0], world, turned)
    for i in range(3):
        out[3 + i] = turned[i]
    _into(frame[0], axis, turned)
    out[GAP] = floats[struct + at[DIST]]
    out[MU] = floats[friction] if dim > 1 else 0.0
    out[TURN] = math.atan2(turned[1], turned[0])
    out[CREEP] = R * math.sqrt(out[0] ** 2 + out[1] ** 2)


@inline_kernel
def write_open(
    floats: FloatArray, cvel: int, centres: int, geoms: int, axes: int, bodies: IntArray, roots: IntArray,
    own: int, other: int, local: FloatArray, plane: FloatArray, spare: FloatArray, out: FloatArray,
) -> None:  # fmt: skip
    """Write a contact point that is open: no force, its material's place, speed and gap from a (9,) plane.

    The plane is a normal, a point upon it, there the gap, the least that the gap may be, and the friction.
    """
    world, turned, frame, normals = spare[2], spare[3], spare[5:8].reshape((1, 3, 3)), spare[8:9]
    for k in range(FIELDS):
        out[k] = 0.0
    _material(floats, geoms, axes, own, local, out[6:9])
    gap = plane[6]
    for i in range(3):
        normals[0, i] = out[9 + i] = plane[i]
        gap += plane[i] * (out[6 + i] - plane[3 + i])
    surface_frames(normals, frame)
    world[:] = 0.0
    _velocity(floats, cvel, centres, bodies, roots, own, out[6:9], world, 1.0)
    _velocity(floats, cvel, centres, bodies, roots, other, out[6:9], world, -1.0)
    _into(frame[0], world, turned)
    for i in range(3):
        out[3 + i] = turned[i]
    # MuJoCo found no contact there: it is farther than that, whatever the plane says
    out[GAP], out[MU], out[CREEP] = max(gap, plane[7]), plane[8], OPEN


@inline_kernel
def plane_beside(
    kinds: IntArray, table: FloatArray, plane: FloatArray, row: int, point: int, count: int, out: FloatArray
) -> bool:
    """Write the (9,) plane that an open contact point is measured against; return whether its geoms touch."""
    for k in range(9):
        out[k] = plane[point, k]
    for s in range(count):
        same = kinds[s, OWN] == kinds[point, OWN] and kinds[s, OTHER] == kinds[point, OTHER]
        if (
            s == point
            or not same
            or kinds[s, FIRST] < 0
            or kinds[s, FIRST] > row
            or table[row, s, CREEP] < 0.0
        ):
            continue
        for i in range(3):
            out[i], out[3 + i] = table[row, s, 9 + i], table[row, s, 6 + i]
        out[6], out[7] = table[row, s, GAP], -math.inf
        return True
    return False


@inline_kernel
def look_back(
    last: FloatArray, at: IntArray, bodies: IntArray, roots: IntArray, kinds: IntArray, local: FloatArray,
    plane: FloatArray, spare: FloatArray, table: FloatArray, row: int, point: int,
) -> None:  # fmt: skip
    """Write the row before a touch, by the contact point's material; before the first of all it is far.

    `last` is that of `contact_pass.take_contacts`, `plane` (9,), `table` (rows, points, FIELDS).
    """
    if row == 0:
        return
    centres = 6 * at[BODIES]
    geoms = centres + 3 * at[BODIES]
    write_open(
        last, 0, centres, geoms, geoms + 3 * at[GEOMS], bodies, roots, kinds[OWN], kinds[OTHER], local, plane,
        spare, table[row - 1, point],
    )  # fmt: skip
    if kinds[FIRST] == row:
        for t in range(row - 1):
            write_far(plane, table[t, point])
            if t > 0 and table[row - 1, point, GAP] < 0.0:  # beside a touch of its geoms: it does not land
                table[t, point, GAP] = -APART


@inline_kernel
def write_far(plane: FloatArray, out: FloatArray) -> None:
    """Write an open contact point of a (9,) plane, far from any touch, as a row (FIELDS,)."""
    for k in range(FIELDS):
        out[k] = 0.0
    out[GAP], out[MU], out[CREEP] = FAR, plane[8], OPEN
