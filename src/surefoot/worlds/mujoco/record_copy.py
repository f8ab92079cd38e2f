"""One compiled pass over an MjData after a step: every array that is kept, every contact and constraint.

MuJoCo holds all arrays of a fixed size in one buffer, so that each has a place, in numbers, behind the first;
its contacts lie behind each other as structs, and what moves from step to step is found by its address.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numba
import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import INTEGER, MATRIX, VECTOR, inline_kernel, kernel
from surefoot.worlds.mujoco.memory_places import FIRST_BYTE

TABLE = numba.int64[:, ::1]
WORDS, HALVES = numba.int64[::1], numba.int32[::1]

COPY_TYPES = (VECTOR, TABLE, VECTOR)
START_TYPES = (VECTOR, WORDS, VECTOR, TABLE, VECTOR, VECTOR)
ALL_MEMORY, PARTS = numba.types.Tuple((VECTOR, WORDS, HALVES)), numba.types.Tuple((VECTOR, TABLE))
ROWS, BEHIND = numba.types.Tuple((MATRIX, MATRIX, TABLE)), numba.types.Tuple((MATRIX, TABLE, MATRIX))
STEP_TYPES = (ALL_MEMORY, WORDS, PARTS, PARTS, VECTOR, VECTOR, ROWS, BEHIND, WORDS, INTEGER)

(TIME, TIMESTEP, NCON, NE, NF, NL, NEFC, NISLAND, NITER, INTEGRATOR, ITERATIONS, CONTACTS, FORCE, SOFTNESS, J,
 ROWNNZ, ROWADR, COLIND, JACOBIAN) = range(19)  # fmt: skip
"""Places of numbers and addresses of a model and its data, see `record_places`."""
COUNTS: dict[str, int] = {
    "ncon": NCON, "ne": NE, "nf": NF, "nl": NL, "nefc": NEFC,
    "nisland": NISLAND,
}  # fmt: skip
OPTIONS: dict[str, int] = {"integrator": INTEGRATOR, "iterations": ITERATIONS, "jacobian": JACOBIAN}
ARRAYS: dict[str, int] = {
    "contact": CONTACTS, "efc_force": FORCE, "efc_R": SOFTNESS, "efc_J": J,
    "efc_J_rownnz": ROWNNZ, "efc_J_rowadr": ROWADR, "efc_J_colind": COLIND,
}  # fmt: skip
"""Fields of MjData and MjOption, and where their places stand among these."""
EULER, RK4, DENSE, SPARSE, AGAIN, PGS, JOINTS, CONSTRAINT, VELOCITIES, STRUCT = range(19, 29)
"""Numbers of integrators and of Jacobians' forms, whether doubtful steps are marked and all are, where in a
row forces of contacts on joints go and those of all constraints are, how many there are, and words of a
contact's struct."""
PLACES = 29
AUTO_SPARSE = 60
"""Velocities from which on MuJoCo's rows of constraints are sparse by themselves."""
LAST, BEGUN = 0, 1
"""Times [s]: after the last step, and at the start of the one under way."""
NO_STEP, NO_ROOM, TAKEN, DOUBTFUL, PUSHED = -2, -1, 0, 1, 2
"""What became of a step: not one of time, no room for it, taken; bits for a solver that stopped early and for
forces that are seldom there."""
MOST_ISLANDS = 20
"""Islands of which MuJoCo keeps the iterations."""
EULERS, IMPLICITS, FOURS = 0, 1, 2
"""Schemes, see `record_capture.Scheme`."""


AllMemory = tuple[FloatArray, IntArray, Any]
Parts = tuple[FloatArray, IntArray]


class MemoryTable:
    """Places of arrays in the memory of an MjData or MjModel.

    Attributes
    ----------
    base
        The first of them, over which all the others can be reached.
    parts
        (n, 2) start of each behind the base, and its length, in numbers.
    size
        Length of all together.
    """

    def __init__(self, arrays: Sequence[Any]) -> None:
        full = [array for array in arrays if array.size]
        places = [int(array.__array_interface__["data"][0]) for array in full]
        first = int(np.argmin(places)) if places else 0
        self.base: FloatArray = full[first].reshape(-1) if places else np.zeros(1)
        start = places[first] if places else 0
        rows = [((at - start) // 8, array.size) for at, array in zip(places, full, strict=True)]
        self.parts: IntArray = np.array(rows, dtype=np.int64).reshape(-1, 2)
        self.size = int(self.parts[:, 1].sum())


@inline_kernel
def _copy_into(base: FloatArray, parts: IntArray, out: FloatArray, at: int) -> int:
    """Copy the parts of a memory behind each other, and return where they end."""
    end = 0
    for k in range(len(parts)):
        end = max(end, parts[k, 0] + parts[k, 1])
    memory = np.lib.stride_tricks.as_strided(base, (end,), (8,))
    for k in range(len(parts)):
        first = parts[k, 0]
        for i in range(parts[k, 1]):
            out[at + i] = memory[first + i]
        at += parts[k, 1]
    return at


@kernel
def copy_parts(base: FloatArray, parts: IntArray, out: FloatArray) -> None:
    """Copy the parts of a memory behind each other into (n,) `out`."""
    _copy_into(base, parts, out, 0)


@kernel
def parts_differ(base: FloatArray, parts: IntArray, known: FloatArray) -> bool:
    """Return whether the parts of a memory are other numbers than the (n,) known ones; NaN is NaN."""
    end, at = 0, 0
    for k in range(len(parts)):
        end = max(end, parts[k, 0] + parts[k, 1])
    memory = np.lib.stride_tricks.as_strided(base, (end,), (8,))
    for k in range(len(parts)):
        first = parts[k, 0]
        for i in range(parts[k, 1]):
            one, two = memory[first + i], known[at + i]
            if one != two and not (one != one and two != two):
                return True
        at += parts[k, 1]
    return False


@kernel
def note_start(
    floats: FloatArray,
    places: IntArray,
    base: FloatArray,
    parts: IntArray,
    clock: FloatArray,
    start: FloatArray,
) -> bool:
    """Keep the state that a step starts from in (s,) `start`, and its time in (2,) `clock` [s].

    Returns False, and keeps nothing, if time has moved since the last step.
    """
    now = floats[places[TIME]]
    if now != clock[LAST]:
        return False
    _copy_into(base, parts, start, 0)
    clock[BEGUN] = now
    return True


@inline_kernel
def _contact_joints(
    floats: FloatArray, words: IntArray, halves: IntArray, places: IntArray, first: int, rows: int,
    row: FloatArray,
) -> None:  # fmt: skip
    """Write what contacts put on the joints, J' f of the constraints from a first on, into a row."""
    count, to, whole = places[VELOCITIES], places[JOINTS], places[CONSTRAINT]
    for j in range(count):
        row[to + j] = row[whole + j] if rows > 0 and first == 0 else 0.0
    if first == 0:
        return
    force = (words[places[FORCE]] - FIRST_BYTE) // 8
    entries = (words[places[J]] - FIRST_BYTE) // 8
    form = halves[places[JACOBIAN]]
    sparse = form == places[SPARSE] or (form != places[DENSE] and count >= AUTO_SPARSE)
    lengths = (words[places[ROWNNZ]] - FIRST_BYTE) // 4
    starts = (words[places[ROWADR]] - FIRST_BYTE) // 4
    columns = (words[places[COLIND]] - FIRST_BYTE) // 4
    for e in range(first, rows):
        f = floats[force + e]
        if sparse:
            at = halves[starts + e]
            for k in range(halves[lengths + e]):
                row[to + halves[columns + at + k]] += f * floats[entries + at + k]
        else:
            for j in range(count):
                row[to + j] += f * floats[entries + e * count + j]


@inline_kernel
def _copy_contacts(
    floats: FloatArray, words: IntArray, places: IntArray, pieces: IntArray, ncon: int, nefc: int,
    contacts: FloatArray, at: int, constraints: FloatArray, row: int,
) -> None:  # fmt: skip
    """Copy the read parts of MuJoCo's contacts, and force and R of its constraints, behind those before."""
    struct = (words[places[CONTACTS]] - FIRST_BYTE) // 8
    for c in range(ncon):
        to = 0
        for k in range(len(pieces)):
            for i in range(pieces[k, 0], pieces[k, 0] + pieces[k, 1]):
                contacts[at + c, to] = floats[struct + i]
                to += 1
        struct += places[STRUCT]
    force, soft = (words[places[FORCE]] - FIRST_BYTE) // 8, (words[places[SOFTNESS]] - FIRST_BYTE) // 8
    for e in range(nefc):
        constraints[0, row + e], constraints[1, row + e] = floats[force + e], floats[soft + e]


@inline_kernel
def _converged(halves: IntArray, places: IntArray) -> bool:
    """Return whether the solver says of all islands that it converged; PGS does not look."""
    if places[PGS]:
        return False
    islands = min(max(halves[places[NISLAND]], 1), MOST_ISLANDS)
    worst = 0
    for k in range(islands):
        worst = max(worst, halves[places[NITER] + k])
    return bool(worst < halves[places[ITERATIONS]])


@inline_kernel
def _any(base: FloatArray, parts: IntArray) -> bool:
    """Return whether a part of a memory is another number than zero; NaN is."""
    end = 0
    for k in range(len(parts)):
        end = max(end, parts[k, 0] + parts[k, 1])
    memory = np.lib.stride_tricks.as_strided(base, (end,), (8,))
    for k in range(len(parts)):
        for i in range(parts[k, 0], parts[k, 0] + parts[k, 1]):
            if memory[i] != 0.0:
                return True
    return False


@kernel
def take_step(
    memory: AllMemory,
    places: IntArray,
    kept: Parts,
    rare: Parts,
    clock: FloatArray,
    start: FloatArray,
    rows: tuple[FloatArray, FloatArray, IntArray],
    behind: tuple[FloatArray, IntArray, FloatArray],
    tail: IntArray,
    scheme: int,
) -> int:
    """Copy the step that a data has just made behind those before, and return what became of it.

    Parameters
    ----------
    memory
        As float64, int64 and int32, see `memory_places`.
    places
        (PLACES,) where the model's and the data's numbers are.
    kept
        Memory and parts of it that are kept, see `MemoryTable`.
    rare
        The same of what is zero in most loops: it is only looked at.
    clock
        (2,) `LAST` and `BEGUN` [s]; the first is written.
    start
        (s,) the state that the step started from.
    rows
        (room, n), (room, 2), (room, 6): state and what acted, time and length, then first contact, their
        number, first constraint, their number, scheme, whether the solver may be off.
    behind
        (room, words) read parts of contacts, (k, 2) which words of their struct those are, and (2, room)
        force and R of constraints.
    tail
        (3,) how many rows, contacts and constraints there are; written.
    scheme
        Of the step, -1 for the model's own.
    """
    (floats, words, halves), (flat, times, found), (contacts, pieces, constraints) = memory, rows, behind
    now, step, begun = floats[places[TIME]], floats[places[TIMESTEP]], clock[BEGUN]
    clock[LAST] = now
    if not abs(now - begun - step) < 1e-6 * step + 1e-12:
        return NO_STEP
    at, contact, constraint = tail[0], tail[1], tail[2]
    ncon, nefc = halves[places[NCON]], halves[places[NEFC]]
    if at >= len(flat) or contact + ncon > contacts.shape[0] or constraint + nefc > constraints.shape[1]:
        return NO_ROOM
    row = flat[at]
    for i in range(len(start)):
        row[i] = start[i]
    _copy_into(kept[0], kept[1], row, len(start))
    first = halves[places[NE]] + halves[places[NF]] + halves[places[NL]]
    _contact_joints(floats, words, halves, places, first, nefc, row)
    if ncon > 0 or nefc > 0:
        _copy_contacts(floats, words, places, pieces, ncon, nefc, contacts, contact, constraints, constraint)
    if scheme < 0:
        own = halves[places[INTEGRATOR]]
        scheme = EULERS if own == places[EULER] else (FOURS if own == places[RK4] else IMPLICITS)
    doubtful = ncon > 0 and places[AGAIN] and not _converged(halves, places)
    times[at, 0], times[at, 1] = begun, step
    found[at, 0], found[at, 1], found[at, 2] = contact, ncon, constraint
    found[at, 3], found[at, 4], found[at, 5] = nefc, scheme, doubtful
    tail[1], tail[2] = contact + ncon, constraint + nefc
    tail[0] = at + 1  # last: an interrupted row is none
    return (DOUBTFUL if doubtful else TAKEN) + (PUSHED if _any(rare[0], rare[1]) else 0)
