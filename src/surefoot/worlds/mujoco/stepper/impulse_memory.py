"""The impulses of a step, of which the next one starts: as a value that a stepper goes on from."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.errors import ProblemError

ImpulseArrays: TypeAlias = tuple[IntArray, IntArray, FloatArray]
"""Keys, places and impulses as compiled code has them, with room for more."""
LEAST_ROOM = 64
"""Blocks that there is room for at the start."""


class Impulses(NamedTuple):
    """What a stepper remembers of its last step.

    Attributes
    ----------
    keys
        (n, 3) what each block is of: kind of constraint, and its number or geoms.
    places
        (n, 2) first row of each block, and how many it has.
    values
        (rows,) impulses [N s, N m s].
    """

    keys: IntArray
    places: IntArray
    values: FloatArray

    @classmethod
    def of(cls, memory: ImpulseArrays, count: int) -> Impulses:
        """Return a copy of the first `count` blocks."""
        keys, places, values = memory
        rows = int(places[:count].sum(axis=1).max(initial=0))
        return cls(keys[:count].copy(), places[:count].copy(), values[:rows].copy())


def memory_room(count: int, held: ImpulseArrays | Impulses | None = None) -> ImpulseArrays:
    """Return room for keys, places and impulses of so many blocks, with what is held in it."""
    room = np.zeros((count, 3), np.int64), np.zeros((count, 2), np.int64), np.zeros(count)
    if held is not None:
        for into, value in zip(room, held, strict=True):
            into[: len(value)] = value
    return room


def read_memory(impulses: Impulses) -> ImpulseArrays:
    """Return remembered impulses as compiled code has them.

    Raises
    ------
    ProblemError
        For arrays that do not fit each other, or places outside the impulses.
    """
    keys, places, values = impulses
    count = len(keys)
    if (keys.shape, places.shape, values.ndim) != ((count, 3), (count, 2), 1):
        raise ProblemError(
            f"impulses must be keys (n, 3), places (n, 2) and values (rows,), got {keys.shape}, "
            f"{places.shape} and {values.shape}"
        )
    ends = places.sum(axis=1)
    if (places < 0).any() or ends.max(initial=0) > values.size:
        raise ProblemError(f"places of impulses lie outside the {values.size} values")
    return memory_room(max(LEAST_ROOM, 2 * count, 2 * values.size), impulses)
