"""One compiled pass over an MjData after a step: its contacts as rows of a log, each at its contact point.

After `mj_step` an MjData still holds what the step's forces were computed from: contacts, velocities of the
bodies and places of the geoms, all of one instant (the step's start; of Runge and Kutta its last stage). So
nothing has to be made again: force, velocity, place and gap of every contact follow from what lies there.

Contact points are those of `record_contacts.Slots`: two geoms, and the place on the robot's that is nearest.
"""

from __future__ import annotations

from typing import Any

import numba

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import REAL, VECTOR, inline_kernel, kernel
from surefoot.worlds.mujoco.episode.contact_writing import (
    ADDRESS,
    ALL_PLACES,
    APART,
    BODIES,
    CENTRES,
    CVEL,
    DIM,
    EXCLUDE,
    FIRST,
    GEOM,
    GEOM_AXES,
    GEOM_PLACES,
    GEOMS,
    MARGIN,
    OTHER,
    OWN,
    POS,
    POSITIONS,
    QPOS,
    SEEN,
    STRUCT,
    look_back,
    plane_beside,
    point_of,
    write_contact,
    write_far,
    write_open,
)
from surefoot.worlds.mujoco.memory_places import FIRST_BYTE
from surefoot.worlds.mujoco.record_contact_rows import FIELDS, GAP, MU
from surefoot.worlds.mujoco.record_copy import CONTACTS, NCON, TIME, TIMESTEP
from surefoot.worlds.mujoco.record_copy import PLACES as MUJOCO_PLACES

NO_ROOM, MOVED = -1, -2
"""What became of a step that was not taken: no room for it; the clock is elsewhere than it should be."""
ARRAYS = 15
"""Arrays of a book: places of MuJoCo's numbers, `at`, three of `kinds`, clock, tail, last, four of points and
three of rows, see `take_contacts`. Behind their places stand six sizes: rows, points, positions, geoms,
bodies and those of `last`."""
BOOK = ARRAYS + 6
WORDS, HALVES = numba.int64[::1], numba.int32[::1]
KEEP_TYPES = (VECTOR, WORDS, VECTOR)
PASS_TYPES = (VECTOR, WORDS, HALVES, WORDS, REAL)

Memory = tuple[FloatArray, IntArray, Any]
Points = tuple[IntArray, FloatArray, FloatArray, FloatArray]


@inline_kernel
def _keep_last(floats: FloatArray, at: IntArray, last: FloatArray) -> None:
    """Keep velocities of bodies and places of geoms, see `last` of `take_contacts`."""
    to = 0
    for place, size in (
        (at[CVEL], 6 * at[BODIES]), (at[CENTRES], 3 * at[BODIES]), (at[GEOM_PLACES], 3 * at[GEOMS]),
        (at[GEOM_AXES], 9 * at[GEOMS]), (at[QPOS], at[POSITIONS]),
    ):  # fmt: skip
        for i in range(size):
            last[to + i] = floats[place + i]
        to += size


@inline_kernel
def _take_contact(
    memory: Memory, places: IntArray, at: IntArray, kinds: tuple[IntArray, IntArray, IntArray],
    last: FloatArray, points: Points, table: FloatArray, row: int, count: int, base: int,
) -> int:  # fmt: skip
    """Write a contact, whose struct begins at `base` in memory; return how many points there are."""
    (floats, words, halves), (bodies, parts, roots), (kind, local, plane, spare) = memory, kinds, points
    half, place, own_local, beside = 2 * base, spare[9], spare[10], spare[11:14].reshape(9)
    one, two = halves[half + at[GEOM]], halves[half + at[GEOM] + 1]
    if one < 0 or two < 0 or halves[half + at[EXCLUDE]] != 0:
        return count
    if (parts[one] != 1 and parts[two] != 1) or (parts[one] != 0 and parts[two] != 0):
        return count  # of others, or inside the robot
    sign, own, other = (1.0, two, one) if parts[two] == 1 else (-1.0, one, two)
    for i in range(3):
        place[i] = floats[base + at[POS] + i] - floats[at[GEOM_PLACES] + 3 * own + i]
    for j in range(3):
        own_local[j] = 0.0
        for i in range(3):
            own_local[j] += floats[at[GEOM_AXES] + 9 * own + 3 * i + j] * place[i]
    s = point_of(kind, local, own_local, own, other, row, count)
    if s < 0:
        s, count = count, count + 1
        kind[s, OWN], kind[s, OTHER], kind[s, SEEN], kind[s, FIRST] = own, other, -1, -1
    out = table[row, s]
    dim, address = halves[half + at[DIM]], halves[half + at[ADDRESS]]
    write_contact(floats, words, places, at, bodies, roots, base, dim, address, sign, own, other, spare, out)
    for i in range(3):
        local[s, i], plane[s, i], plane[s, 3 + i] = own_local[i], out[9 + i], out[6 + i]
    plane[s, 6], plane[s, 8] = out[GAP], out[MU]
    plane[s, 7] = max(floats[base + at[MARGIN]], APART)
    if kind[s, FIRST] < 0:
        kind[s, FIRST] = row
    if row > 0 and (kind[s, FIRST] == row or kind[s, SEEN] != row - 1):
        plane_beside(kind, table, plane, row - 1, s, count, beside)
        look_back(last, at, bodies, roots, kind[s], local[s], beside, spare, table, row, s)
    kind[s, SEEN] = row
    return count


@inline_kernel
def _write_open_points(
    floats: FloatArray, at: IntArray, kinds: tuple[IntArray, IntArray, IntArray], points: Points,
    table: FloatArray, row: int, count: int,
) -> None:  # fmt: skip
    """Write the points that are open: as they are beside a touch, else as far."""
    (bodies, _, roots), (kind, local, plane, spare) = kinds, points
    beside = spare[11:14].reshape(9)
    for s in range(count):
        if kind[s, SEEN] == row:
            continue
        touches = plane_beside(kind, table, plane, row, s, count, beside)
        if kind[s, SEEN] < row - 1 and not touches:
            write_far(plane[s], table[row, s])
        else:
            write_open(
                floats, at[CVEL], at[CENTRES], at[GEOM_PLACES], at[GEOM_AXES], bodies, roots, kind[s, OWN],
                kind[s, OTHER], local[s], beside, spare, table[row, s],
            )  # fmt: skip


@inline_kernel
def take_contacts(
    memory: Memory,
    places: IntArray,
    at: IntArray,
    kinds: tuple[IntArray, IntArray, IntArray],
    clock: FloatArray,
    last: FloatArray,
    points: Points,
    rows: tuple[FloatArray, FloatArray, FloatArray],
    tail: IntArray,
    length: float,
) -> int:
    """Take the contacts of the step that a data has just made, and return how many points it knows.

    Parameters
    ----------
    memory
        As float64, int64 and int32, see `memory_places`.
    places, at
        Of `record_places.StepPlaces`, and (ALL_PLACES,) of this file.
    kinds
        (ngeom,) body of each geom and what it is: 1 of the robot, 2 of what that hangs on, else 0; (nbody,)
        root of each body.
    clock
        (1,) time after the last step [s]; written.
    last
        (n,) velocities, places and positions after the last step; written.
    points
        (s, 4) `OWN` to `FIRST`; (s, 3) place on the robot's geom [m]; (s, 9) plane, see
        `write_open`; (14, 3) room.
    rows
        (rows, s, FIELDS) contact points, (rows, 2) start and length [s], (rows, nq) positions at the start.
    tail
        (2,) how many rows and points there are; written.
    length
        Of the step [s], 0 for the model's.

    Returns
    -------
    int
        `NO_ROOM`, `MOVED`, else the number of contact points.
    """
    (floats, words, halves), (table, times, positions) = memory, rows
    now, step = floats[places[TIME]], length if length > 0.0 else floats[places[TIMESTEP]]
    if not abs(now - clock[0] - step) < 1e-6 * step + 1e-12:
        return MOVED
    row, count, ncon = tail[0], tail[1], halves[places[NCON]]
    if row >= len(table) or count + ncon > table.shape[1]:
        return NO_ROOM
    struct = (words[places[CONTACTS]] - FIRST_BYTE) // 8
    for c in range(ncon):
        count = _take_contact(
            memory, places, at, kinds, last, points, table, row, count, struct + c * at[STRUCT]
        )  # fmt: skip
    _write_open_points(floats, at, kinds, points, table, row, count)
    times[row, 0], times[row, 1] = clock[0], step
    first = len(last) - at[POSITIONS]
    for i in range(at[POSITIONS]):
        positions[row, i] = last[first + i]
    _keep_last(floats, at, last)
    clock[0], tail[1] = now, count
    tail[0] = row + 1  # last: an interrupted row is none
    return int(count)


@kernel
def take_step(floats: FloatArray, words: IntArray, halves: Any, book: IntArray, length: float) -> int:
    """Call `take_contacts` with arrays that a book finds in memory: to hand over so many takes as long.

    Parameters
    ----------
    floats, words, halves
        All memory, see `memory_places`.
    book
        (BOOK,) place and size of every array, see `ARRAYS`.
    length
        See there.
    """
    sizes = book[ARRAYS:]
    rows, points, positions, geoms = sizes[0], sizes[1], sizes[2], sizes[3]
    bodies, last = sizes[4], sizes[5]
    places, at = words[book[0] : book[0] + MUJOCO_PLACES], words[book[1] : book[1] + ALL_PLACES]
    kinds = (
        words[book[2] : book[2] + geoms], words[book[3] : book[3] + geoms], words[book[4] : book[4] + bodies]
    )  # fmt: skip
    clock, tail = floats[book[5] : book[5] + 1], words[book[6] : book[6] + 2]
    state = floats[book[7] : book[7] + last]
    known = (
        words[book[8] : book[8] + 4 * points].reshape((points, 4)),
        floats[book[9] : book[9] + 3 * points].reshape((points, 3)),
        floats[book[10] : book[10] + 9 * points].reshape((points, 9)),
        floats[book[11] : book[11] + 42].reshape((14, 3)),
    )
    kept = (
        floats[book[12] : book[12] + rows * points * FIELDS].reshape((rows, points, FIELDS)),
        floats[book[13] : book[13] + 2 * rows].reshape((rows, 2)),
        floats[book[14] : book[14] + rows * positions].reshape((rows, positions)),
    )
    memory = (floats, words, halves)
    return take_contacts(memory, places, at, kinds, clock, state, known, kept, tail, length)


@kernel
def keep_last(floats: FloatArray, at: IntArray, last: FloatArray) -> None:
    """Keep what the data holds before an episode's first step, see `last` of `take_contacts`."""
    _keep_last(floats, at, last)
