"""What lasts in a world from one step to the next, as a value; and which worlds can tell it."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError
from surefoot.mechanics import Robot, Terrain
from surefoot.worlds.interface.world import ContactReading


class WorldState(NamedTuple):
    """All that lasts in a world from one step to the next; compare two by `surefoot.base.memory.alike`.

    Attributes
    ----------
    kind, made
        Class of the world, and a digest of the numbers that it was made with: a state is taken by a world
        that was made in the same way, and by no other.
    own
        Arrays and numbers by name that the world goes on from.
    applied
        (joints,) torques that the motors gave in the last step [N m].
    reading
        What the ground did in the last step.
    touching
        Names of what touched in it, without feet on the ground.
    """

    kind: str
    made: str
    own: dict[str, Any]
    applied: FloatArray
    reading: ContactReading
    touching: list[tuple[str, str]]

    def check(self, kind: str, made: str) -> None:
        """Refuse a state of another world.

        Raises
        ------
        ProblemError
            For another class of world, or one that was made with other numbers.
        """
        if self.kind != kind:
            raise ProblemError(f"the state is one of a {self.kind}, this world is a {kind}")
        if self.made != made:
            raise ProblemError(
                f"the state is one of another {kind}: robot, load, ground, step or softness differ"
            )


def digest(robot: Robot, terrain: Terrain, *numbers: Any) -> str:
    """Return a digest of what a world was made with: the ground by its name, and arrays of numbers."""
    out = hashlib.sha256(repr((robot.name, robot.joint_names, robot.foot_names, terrain.text)).encode())
    for array in map(np.ascontiguousarray, numbers):
        out.update(f"{array.dtype}{array.shape}".encode())
        out.update(array.tobytes())
    return out.hexdigest()


def fill(arrays: Iterable[tuple[str, NDArray[Any], Any]]) -> None:
    """Write values into arrays (...,), each by its name and of the array's own shape and type.

    Raises
    ------
    ProblemError
        For a value of another shape or type; no array has changed.
    """
    arrays = list(arrays)
    for name, into, value in arrays:
        if not isinstance(value, np.ndarray) or value.shape != into.shape or value.dtype != into.dtype:
            got = f"{value.shape} of {value.dtype}" if isinstance(value, np.ndarray) else type(value).__name__
            raise ProblemError(f"{name} of the world's state must be {into.shape} of {into.dtype}, got {got}")
    for _, into, value in arrays:
        into[...] = value


def world_state(world: Any) -> WorldState:
    """Return the state of a world: a copy of all that lasts from one step to the next.

    Raises
    ------
    ProblemError
        For a world that cannot tell all of it.
    """
    kind = type(world)
    if not (hasattr(kind, "state") and hasattr(kind, "resume")):
        raise ProblemError(
            f"a {kind.__name__} does not tell its whole state, so that a run cannot go on from one; "
            "the worlds mujoco and rigid do"
        )
    state: WorldState = world.state
    return state
