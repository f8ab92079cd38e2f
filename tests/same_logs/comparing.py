"""Compare two logs bit by bit and name the first difference."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

CLOCKS = frozenset({"controller_time", "estimator_time", "fact_wall_time", "fact_cpu_time"})
"""Channels and facts of the machine, not of the robot."""
SAID = frozenset({"fact_source"})
"""Facts that say where a log comes from: versions and paths."""
DEFINITIONS = "channels"
"""Array of a log that defines its channels, as JSON; `meaning` is prose and may be worded anew."""
RENAMED: Mapping[str, str] = {}
"""Words in texts of older logs, as behaviours' names, to those of newer ones."""
ADDED: frozenset[str] = frozenset()
"""Channels and facts (`fact_NAME`, `definition of NAME`) that only newer logs have, on purpose."""


class Difference(NamedTuple):
    """Where two logs differ first.

    Attributes
    ----------
    scenario, channel
        Names; facts are called `fact_NAME`.
    row, column
        Of the first entry that differs; -1 where there is none, as for what only one log has.
    first, second
        What the logs have there.
    """

    scenario: str
    channel: str
    row: int
    column: int
    first: str
    second: str

    def __str__(self) -> str:
        """In one line."""
        place = f" row {self.row}" if self.row >= 0 else ""
        place += f" column {self.column}" if self.column >= 0 else ""
        return f"{self.scenario}: {self.channel}{place}: {self.first} and {self.second}"


def first_difference(scenario: str, first: Path, second: Path) -> Difference | None:
    """Return where two logs differ first in time; facts come after all channels. None if nowhere."""
    with np.load(first, allow_pickle=False) as a, np.load(second, allow_pickle=False) as b:
        one, other = _contents(a), _contents(b)
    names = [*one, *(name for name in other if name not in one and name not in ADDED)]
    found = [d for name in names if (d := _compared(scenario, name, one.get(name), other.get(name)))]
    return min(found, key=lambda difference: (difference.row < 0, difference.row), default=None)


def differences(first: Path, second: Path, names: Iterable[str]) -> list[Difference]:
    """Return the first difference of every scenario that has one in two records."""
    found = []
    for name in names:
        paths = [folder / f"{name}.npz" for folder in (first, second)]
        there = ["a log" if path.is_file() else "none" for path in paths]
        if "none" in there:
            found.append(Difference(name, "log", -1, -1, *there))
        elif difference := first_difference(name, *paths):
            found.append(difference)
    return found


def _contents(file: Mapping[str, Any]) -> dict[str, np.ndarray[Any, Any]]:
    """Return what counts in a log: arrays by name, definitions of channels as one text each."""
    arrays = {name: np.asarray(file[name]) for name in file if name not in CLOCKS | SAID}
    if DEFINITIONS in arrays:
        for row in json.loads(str(arrays.pop(DEFINITIONS))):
            if row["name"] not in CLOCKS:
                row.pop("meaning", None)
                text = json.dumps(row, sort_keys=True)
                arrays[f"definition of {row['name']}"] = np.array(text)
    return arrays


def _compared(
    scenario: str, name: str, a: np.ndarray[Any, Any] | None, b: np.ndarray[Any, Any] | None
) -> Difference | None:
    """Return the first difference of two arrays, None where they are the same to the last bit."""
    if a is None or b is None:
        return Difference(scenario, name, -1, -1, *("nothing" if x is None else "something" for x in (a, b)))
    a, b = _plain(a, RENAMED), _plain(b, {})
    if a.dtype != b.dtype or a.shape[1:] != b.shape[1:] or a.ndim != b.ndim:
        return Difference(scenario, name, -1, -1, f"{a.dtype} {a.shape}", f"{b.dtype} {b.shape}")
    in_rows = a.ndim > 0 and not name.startswith("fact_")
    rows = min(len(a), len(b)) if a.ndim else 1
    width = a[:1].size if a.ndim else 1
    one, other = (x[:rows].reshape(rows, width) if x.ndim else x.reshape(1, 1) for x in (a, b))
    where = np.argwhere(one != other if a.dtype == object else _bits(one) != _bits(other))
    if len(where):
        row, column = (int(k) for k in where[0])
        values = _written(one[row, column]), _written(other[row, column])
        place = (row, column if width > 1 else -1) if in_rows else (-1, row * width + column)
        return Difference(scenario, name, *place, *values)
    if a.shape != b.shape:
        return Difference(scenario, name, rows if in_rows else -1, -1, f"{len(a)} rows", f"{len(b)} rows")
    return None


def _plain(array: np.ndarray[Any, Any], words: Mapping[str, str]) -> np.ndarray[Any, Any]:
    """Return text as objects, for its width is that of the longest entry, with some words replaced."""
    if array.dtype.kind != "U":
        return array
    plain = np.empty(array.shape, dtype=object)
    plain.ravel()[:] = [words.get(text, text) for text in array.ravel().tolist()]
    return plain


def _bits(array: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    """Return an array's entries as whole numbers: NaN equals NaN of the same bits, and 0 is not -0."""
    return np.ascontiguousarray(array).view(f"u{array.dtype.itemsize}")


def _written(value: Any) -> str:
    """Return a value with all its digits."""
    return f"{float(value).hex()} ({float(value)!r})" if isinstance(value, np.floating) else repr(value)
