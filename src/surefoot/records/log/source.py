"""What a file of somebody else's holds before it is a log: topics with time stamps and named fields.

A field of a topic is called as Foxglove writes message paths: ``/imu/data.linear_acceleration.x``. A table
such as a CSV file is one topic without a name, and its columns are the fields.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError

LONGEST_LIST = 64
"""Longest list of messages within a message of which every element is read on its own."""
LARGEST = 4 << 30
"""Largest file of text or messages that is read [bytes]: such files are held in memory."""
APART = 10 * 10**9
"""Stamps of a message and its recorder that differ by more are of two clocks [ns]."""


@dataclass
class Topic:
    """One stream.

    Attributes
    ----------
    times
        (k,) stamps since the source's start [s]; None for a table whose time is one of its columns.
    fields
        Name to (k, ...) numbers.
    texts
        Name to the texts of a field, such as the names of the joints; the same in every message.
    kind
        Type of the messages, empty for a table.
    """

    times: FloatArray | None
    fields: dict[str, Any]
    texts: dict[str, tuple[str, ...]] = field(default_factory=dict)
    kind: str = ""


@dataclass
class Source:
    """Topics by name.

    Attributes
    ----------
    topics
        Name to topic.
    notes
        What could not be read of it, one line each.
    start
        Stamp of the first message [s]; NaN where there are no stamps.
    mapping
        The mapping that the file brings itself, as YAML; empty for none.
    facts
        What it says once: single numbers that have the names of facts.
    """

    topics: dict[str, Topic]
    notes: list[str] = field(default_factory=list)
    start: float = math.nan
    mapping: str = ""
    facts: dict[str, Any] = field(default_factory=dict)

    def names(self) -> list[str]:
        """Return the full names of all fields."""
        return [full_name(name, f) for name, topic in self.topics.items() for f in topic.fields]

    def find(self, name: str) -> tuple[str, FloatArray]:
        """Return the topic and the (k, m) numbers of a field, or of the x, y, z (w) below a name.

        Raises
        ------
        ProblemError
            If there is no such field.
        """
        for at, topic in self.topics.items():
            if not name.startswith(at):
                continue
            rest = name[len(at) :].removeprefix("." if at else "")
            if rest in topic.fields:
                return at, _columns(topic.fields[rest])
            there = [axis for axis in "xyzw" if f"{rest}.{axis}" in topic.fields]
            if there[:3] == ["x", "y", "z"]:
                return at, np.hstack([_columns(topic.fields[f"{rest}.{axis}"]) for axis in there])
        raise ProblemError(f"the file has no field {name!r}; it has: {_some(self.names())}")


def full_name(topic: str, name: str) -> str:
    """Return how a field of a topic is called."""
    return f"{topic}.{name}" if topic else name


def _some(names: list[str]) -> str:
    return ", ".join(names[:40]) + (f" and {len(names) - 40} more" if len(names) > 40 else "")


def _columns(values: Any) -> FloatArray:
    array = np.asarray(values, dtype=np.float64)
    return array.reshape(len(array), math.prod(array.shape[1:]))


def check_size(size: int, what: object) -> None:
    """Raise `ProblemError` for a file that is too large to be held in memory, or empty."""
    if size > LARGEST:
        raise ProblemError(f"{what} has {size / 2**30:.1f} GiB, the limit is {LARGEST / 2**30:.0f}: cut it")
    if size == 0:
        raise ProblemError(f"{what} is empty")


class Messages:
    """Collects the messages of several topics and returns them as a source.

    Attributes
    ----------
    unread
        What could not be read, one line each.
    """

    def __init__(self) -> None:
        self.unread: set[str] = set()
        self._stamps: dict[str, list[tuple[int, int]]] = {}
        self._rows: dict[str, list[dict[str, Any]]] = {}
        self._texts: dict[str, dict[str, tuple[str, ...]]] = {}
        self._kinds: dict[str, str] = {}

    def add(self, topic: str, kind: str, stamp: int, message: Any) -> None:
        """Take a message: dictionary, protobuf or ROS message; `stamp` is when it was logged [ns]."""
        row: dict[str, Any] = {}
        texts: dict[str, tuple[str, ...]] = {}
        _flatten(message, "", row, texts)
        self._stamps.setdefault(topic, []).append((stamp, _own_stamp(row)))
        self._rows.setdefault(topic, []).append(row)
        self._kinds[topic] = kind
        names = self._texts.setdefault(topic, texts)
        changed = [n for n, t in texts.items() if len(t) > 1 and names.get(n, t) != t]
        if changed:
            at = len(self._rows[topic])
            raise ProblemError(f"{topic}.{changed[0]} changes at message {at}: the order must stay the same")

    def source(self) -> Source:
        """Return all messages so far."""
        if not self._rows:
            raise ProblemError("it holds no messages that can be read")
        notes: list[str] = []
        stamps = self._clock(notes)
        start = min(map(min, stamps.values()))
        topics = {
            name: Topic(
                1e-9 * np.array([s - start for s in stamps[name]], dtype=np.float64),
                _stack_fields(name, rows, notes),
                self._texts[name],
                self._kinds[name],
            )
            for name, rows in self._rows.items()
        }
        return Source(topics, notes + sorted(self.unread), 1e-9 * start)

    def _clock(self, notes: list[str]) -> dict[str, list[int]]:
        """Return the stamps of every topic [ns]: the messages' own, where those can be compared."""
        logged = {name: [at for at, _ in both] for name, both in self._stamps.items()}
        own = {name: [stamp for _, stamp in both] for name, both in self._stamps.items()}
        stamped = {name for name, stamps in own.items() if all(stamps)}
        if stamped == set(own):
            return own
        near = all(abs(o - at) < APART for n in stamped for o, at in zip(own[n], logged[n], strict=True))
        if not near:
            notes.append(
                "some messages carry stamps of another clock than the recorder's: the recorder's is used"
            )
            return logged
        return {name: own[name] if name in stamped else logged[name] for name in own}


def _stack_fields(topic: str, rows: list[dict[str, Any]], notes: list[str]) -> dict[str, Any]:
    """Return the fields that every message has, in one shape, as arrays over time."""
    out = {}
    for name in dict.fromkeys(n for row in rows for n in row):
        values = [row.get(name) for row in rows]
        shapes = {np.shape(value) for value in values if value is not None}
        if any(value is None for value in values) or len(shapes) != 1:
            notes.append(
                f"{full_name(topic, name)} is missing in some messages or changes its length: left out"
            )
        elif 0 not in next(iter(shapes)):
            out[name] = np.array(values, dtype=np.float64)
    return out


def _own_stamp(row: dict[str, Any]) -> int:
    """Return the stamp that a message itself carries [ns], zero if none."""
    for base in ("header.stamp", "timestamp", "stamp"):
        for seconds, rest in (("sec", "nanosec"), ("sec", "nsec"), ("secs", "nsecs"), ("seconds", "nanos")):
            if f"{base}.{seconds}" in row and f"{base}.{rest}" in row:
                return int(row[f"{base}.{seconds}"]) * 10**9 + int(row[f"{base}.{rest}"])
    return 0


def _flatten(value: Any, name: str, row: dict[str, Any], texts: dict[str, tuple[str, ...]]) -> None:
    """Write the numbers and texts of a message into `row` and `texts`, by their names."""
    if isinstance(value, (bool, int, float, np.number, np.bool_)):
        row[name or "value"] = float(value)
    elif isinstance(value, str):
        texts[name] = (value,)
    elif isinstance(value, (bytes, type(None))):
        return
    elif (children := _children(value)) is not None:
        for key, child in children:
            _flatten(child, f"{name}.{key}" if name else key, row, texts)
    else:
        _flatten_list(value, name, row, texts)


def _flatten_list(value: Any, name: str, row: dict[str, Any], texts: dict[str, tuple[str, ...]]) -> None:
    items = value.tolist() if isinstance(value, np.ndarray) else list(value)
    if all(isinstance(item, str) for item in items):
        texts[name] = tuple(items)
    elif all(item is None or isinstance(item, (bool, int, float, list)) for item in items):
        try:
            row[name] = np.array(items, dtype=np.float64)
        except (ValueError, TypeError):
            return  # a list of lists of several lengths
    elif len(items) <= LONGEST_LIST:
        for k, item in enumerate(items):
            _flatten(item, f"{name}[{k}]", row, texts)


def _children(value: Any) -> Iterable[tuple[str, Any]] | None:
    """Return names and values of a message's fields; None if it is no message."""
    if isinstance(value, dict):
        return [(str(k), v) for k, v in value.items()]
    if hasattr(value, "DESCRIPTOR"):  # protobuf
        return [(f.name, getattr(value, f.name)) for f in value.DESCRIPTOR.fields]
    if hasattr(value, "__dataclass_fields__"):  # rosbags
        names = [n for n in value.__dataclass_fields__ if not n.startswith("__")]
        return [(n, getattr(value, n)) for n in names]
    if hasattr(value, "__slots__"):  # mcap_ros2
        return [(n.lstrip("_"), getattr(value, n)) for n in value.__slots__]
    return None
