"""Orders in which a stranger's log may have the joints and feet of a robot, for the feet to choose from."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import permutations
from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import IntArray
from surefoot.mechanics import Robot


class ColumnOrder(NamedTuple):
    """Where the robot's joints and feet are in a log.

    Attributes
    ----------
    joints, feet
        (joints,), (n,) column of each of the robot's.
    words
        What order that is.
    """

    joints: IntArray
    feet: IntArray
    words: str


def leg_joints(robot: Robot) -> list[list[int]]:
    """Return the joints between the base and each foot."""
    model, out = robot.model, []
    for foot in robot.feet:
        joint, chain = int(model.frames[foot.frame].parentJoint), []
        while joint > 1:
            chain.append(int(model.joints[joint].idx_q) - 7)
            joint = int(model.parents[joint])
        out.append(chain[::-1])
    return out


def named_orders(
    legs: Sequence[Sequence[int]], joints: IntArray, feet: IntArray, known: bool = False
) -> Iterator[ColumnOrder]:
    """Yield orders against the joints' names, whose (joints,) columns are known: whole legs that are swapped.

    The feet's columns (n,) are swapped likewise, or are what they were; the latter if they are known.
    """
    for seats in permutations(range(len(legs))):
        if seats == tuple(range(len(legs))):
            continue
        moved = np.empty_like(joints)
        for leg, seat in enumerate(seats):
            moved[list(legs[leg])] = joints[list(legs[seat])]
        words = f"legs in the order {_join_numbers(seats)} of the robot's"
        yield from _with_feet(moved, feet, seats, words, known)


def unnamed_orders(
    legs: Sequence[Sequence[int]], feet: IntArray, known: bool = False
) -> Iterator[ColumnOrder]:
    """Yield orders of joints that nothing names: leg after leg, or all first joints, all second ones, ...

    Feet have the order of the legs, or columns (n,) of their own; the latter if those are known.
    """
    size = len(legs[0])
    for seats in permutations(range(len(legs))):
        after, across = np.empty((2, len(legs) * size), dtype=np.int64)
        for leg, seat in enumerate(seats):
            for part, joint in enumerate(legs[leg]):
                after[joint], across[joint] = seat * size + part, part * len(legs) + seat
        words = f"legs in the order {_join_numbers(seats)} of the robot's"
        yield from _with_feet(after, feet, seats, words, known)
        yield from _with_feet(across, feet, seats, f"joint by joint, {words}", known)


def foot_orders(joints: IntArray, feet: IntArray) -> Iterator[ColumnOrder]:
    """Yield orders of the feet's columns (n,) alone; the joints' (joints,) are what they are."""
    for seats in permutations(range(len(feet))):
        if seats != tuple(range(len(feet))):
            yield ColumnOrder(
                joints, feet[list(seats)], f"feet in the order {_join_numbers(seats)} of the robot's"
            )


def _with_feet(
    joints: IntArray, feet: IntArray, seats: Sequence[int], words: str, known: bool
) -> Iterator[ColumnOrder]:
    if known:
        yield ColumnOrder(joints, feet, words)
        return
    yield ColumnOrder(joints, feet[list(seats)], words)
    if list(seats) != sorted(seats):
        yield ColumnOrder(joints, feet, f"{words}, feet as the robot has them")


def _join_numbers(seats: Sequence[int]) -> str:
    return ", ".join(str(s + 1) for s in seats)
