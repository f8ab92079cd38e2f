"""A motion as a file has it, before any guess, and its arrays by the names that files give them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray, finite_array
from surefoot.base.errors import ProblemError, shown


@dataclass
class MotionFields:
    """A motion as a file has it.

    Attributes
    ----------
    name
        What it is called.
    joints
        (T, n) angles as they stand in the file.
    place, quaternion
        (T, 3) and (T, 4) of the root; None for a robot that is bolted down.
    turn, certain
        Order of the quaternion's numbers by the field's name, empty where that says nothing, and whether it
        is written there and not only usual.
    names
        Of the columns of `joints`; empty where the file does not say.
    rate, times
        [Hz], (T,) [s]; None where the file does not say.
    speeds, torques
        (T, n); None where there are none.
    bodies, body_names
        (T, bodies, 3) places in the world [m], and whose.
    extra
        What else the file has.
    notes
        What was guessed of its columns, a line each.
    """

    name: str
    joints: FloatArray
    place: FloatArray | None = None
    quaternion: FloatArray | None = None
    turn: str = ""
    certain: bool = False
    names: tuple[str, ...] = ()
    rate: float | None = None
    times: FloatArray | None = None
    speeds: FloatArray | None = None
    torques: FloatArray | None = None
    bodies: FloatArray | None = None
    body_names: tuple[str, ...] = ()
    extra: dict[str, Any] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)


class FieldTable:
    """Arrays of one motion by their names, upper and lower case alike.

    Attributes
    ----------
    contents
        What the file has.
    lower
        Name in lower case to the file's own.
    used
        Names of what has been taken out.
    """

    def __init__(self, contents: Mapping[Any, Any]) -> None:
        self.contents = {str(key): value for key, value in contents.items()}
        self.lower = {key.lower(): key for key in self.contents}
        self.used = set[str]()

    def key(self, names: Iterable[str]) -> str | None:
        """Return the file's own name for the first of some names that it has."""
        return next((self.lower[name] for name in names if name in self.lower), None)

    def value(self, names: Iterable[str]) -> Any:
        """Return what stands under the first of some names, as it is; None where none does."""
        key = self.key(names)
        return None if key is None else self.contents[key]

    def numbers(self, names: Iterable[str], width: int | None = None, rows: int | None = None) -> Any:
        """Return the (T, width) array under the first of some names, checked; None where none does."""
        key = self.key(names)
        if key is None:
            return None
        self.used.add(key)
        return frames(key, self.contents[key], width, rows)

    def single(self, names: Iterable[str]) -> tuple[str, Any] | None:
        """Return name and value of a single number; None where there is none."""
        key = self.key(names)
        if key is None or shape_of(self.contents[key]) not in ((), (1,), (1, 1)):
            return None
        self.used.add(key)
        value = self.contents[key]
        return key, np.ravel(value)[0] if shape_of(value) else value

    def texts(self, names: Iterable[str]) -> tuple[str, ...]:
        """Return a list of texts, empty where there is none."""
        key = self.key(names)
        if key is None:
            return ()
        self.used.add(key)
        value = self.contents[key]
        items = value.tolist() if isinstance(value, np.ndarray) else value
        if not isinstance(items, list | tuple):
            raise ProblemError(f"{key} must be a list of names, got {shown(value)}")
        return tuple(one.decode("utf-8", "replace") if isinstance(one, bytes) else str(one) for one in items)

    @property
    def listed(self) -> str:
        """Names of what the file has, for a message."""
        return ", ".join(sorted(self.contents)[:8]) or "nothing"


def shape_of(value: Any) -> tuple[int, ...]:
    """Return the shape of an array or of nested lists, empty for what has none."""
    try:
        return tuple(np.shape(value))
    except ValueError:  # ragged
        return ()


def frames(key: str, value: Any, width: int | None = None, rows: int | None = None) -> FloatArray:
    """Return numbers (T, width), a frame a row.

    Raises
    ------
    ProblemError
        In one line that says where, for what is ragged, no number, not finite, without two frames, or of
        another shape.
    """
    named = repr(key) if key else "its table"
    array = finite_array(named, value)
    if array.ndim == 3 and array.shape[2] == 1 and 1 not in array.shape[:2]:
        array = array[:, :, 0]
    elif array.ndim == 3 and 1 in array.shape[:2]:
        array = array.reshape(max(array.shape[:2]), -1)
    if array.ndim != 2 or (width is not None and array.shape[1] != width):
        raise ProblemError(f"{named} must have shape (frames, {width or 'columns'}), got {array.shape}")
    if len(array) < 2:
        many = "1 frame" if len(array) == 1 else "no frames"
        raise ProblemError(f"{named} has {many}; a motion has two or more")
    if rows is not None and len(array) != rows:
        raise ProblemError(f"{named} has {len(array)} frames, the joints have {rows}")
    return array
