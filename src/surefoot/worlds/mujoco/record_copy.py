"""One compiled pass over an MjData after a step: every array that is kept, and every contact, in two calls.

MuJoCo holds all arrays of a fixed size in one buffer, so that each has a place, in numbers, behind the first;
its contacts lie behind each other as structs.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numba
import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import INTEGER, MATRIX, REAL, VECTOR, inline_kernel, kernel

TABLE = numba.int64[:, ::1]
STRIDED = numba.types.Array(numba.float64, 1, "A")
COUNTS = numba.types.Array(numba.int32, 1, "C")

COPY_TYPES = (VECTOR, TABLE, VECTOR)
STEP_TYPES = (VECTOR, TABLE, VECTOR, MATRIX, INTEGER, MATRIX, REAL, REAL, TABLE, *[INTEGER] * 5)
CONTACT_TYPES = (STRIDED, VECTOR, VECTOR, MATRIX, INTEGER, MATRIX, INTEGER)


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
def copy_step(
    base: FloatArray,
    parts: IntArray,
    start: FloatArray,
    flat: FloatArray,
    at: int,
    times: FloatArray,
    time: float,
    step: float,
    places: IntArray,
    contacts: int,
    ncon: int,
    rows: int,
    nefc: int,
    scheme: int,
) -> None:
    """Write the state that a step started from, and what acted in it, into row `at` of (room, n) `flat`.

    And its time and length to (room, 2) `times`, and where its contacts are to (room, 6) `places`.
    """
    row = flat[at]
    for i in range(len(start)):
        row[i] = start[i]
    own = _copy_into(base, parts, row, len(start))
    times[at, 0], times[at, 1] = time, step
    places[at, 0], places[at, 1], places[at, 2] = contacts, ncon, rows
    places[at, 3], places[at, 4], places[at, 5] = nefc, scheme, 0
    for i in range(own, len(row)):
        row[i] = 0.0


@kernel
def copy_contacts(
    first: FloatArray,
    forces: FloatArray,
    softness: FloatArray,
    contacts: FloatArray,
    at: int,
    constraints: FloatArray,
    row: int,
) -> None:
    """Copy MuJoCo's contacts, whole structs as numbers of eight bytes, and the forces of its constraints.

    Parameters
    ----------
    first
        (c,) the first number of every contact, a struct apart.
    forces, softness
        (e,) force and R of every constraint.
    contacts, at
        (room, struct) where they go, from this row on.
    constraints, row
        (2, room) where those go, from this column on.
    """
    count, width = len(first), contacts.shape[1]
    structs = np.lib.stride_tricks.as_strided(first, (count, width), (8 * width, 8))
    for c in range(count):
        for i in range(width):
            contacts[at + c, i] = structs[c, i]
    for e in range(len(forces)):
        constraints[0, row + e], constraints[1, row + e] = forces[e], softness[e]
