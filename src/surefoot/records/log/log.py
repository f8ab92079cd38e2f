"""A log: arrays over time that say what they are, and facts about the run."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from surefoot.base.arrays import of_kind
from surefoot.base.drawn import Drawn
from surefoot.base.errors import ProblemError, check_name, count_of, shown
from surefoot.base.text_files import path_of
from surefoot.records.log.channels import CHANNELS, Channel, check_shapes
from surefoot.records.log.facts import FACTS, facts_of_rows, facts_of_selection
from surefoot.records.log.formats import write_log

_SHOWN = 8
"""Channels that the sentence about a log names."""


class Ending(StrEnum):
    """How a run ended."""

    DONE = "done"
    """All steps were made."""
    FELL = "fell"
    """The robot fell."""
    LOST = "lost"
    """The robot lost the estimate of its state, and stopped."""
    INVALID = "invalid"
    """The state or a torque stopped being finite, or the world could not go on."""
    INTERRUPTED = "interrupted"
    """Someone stopped it."""
    STOPPED = "stopped"
    """The log could not be written."""


@dataclass(repr=False, eq=False)
class Log(Drawn):
    """Channels over time and facts about the run; also what an interrupted run leaves.

    Attributes
    ----------
    arrays
        Name to array of one row per step, cut to the steps that were made; of a long run mapped from files,
        read-only.
    facts
        Scalars and lists, see `FACTS`.
    parts
        Folder that the rows were written to during the run, until `save` has them in one file.
    channels
        Name to definition of every array; those of `CHANNELS` need not be given.
    sizes
        The named sizes that the arrays have: ``nq``, ``p``, ...

    Raises
    ------
    ProblemError
        For arrays that are no channels, or do not fit theirs or each other.
    """

    arrays: dict[str, Any]
    facts: dict[str, Any] = field(default_factory=dict)
    parts: Path | None = None
    channels: dict[str, Channel] = field(default_factory=dict)
    sizes: dict[str, int] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        of_kind("arrays", self.arrays, Mapping)
        try:
            self.arrays = {name: np.asanyarray(array) for name, array in self.arrays.items()}
        except ValueError as error:
            raise ProblemError(f"a channel's rows must all have one shape: {error}") from error
        given = {**CHANNELS, **self.channels}
        self.sizes = check_shapes(self.arrays, given)
        self.channels = {name: given[name] for name in self.arrays}

    def __getitem__(self, name: Any) -> Any:
        """Return a channel by its name, or the log of rows: a slice, a mask or places, as in `rows`."""
        if isinstance(name, slice | list | np.ndarray):
            return self.rows(name)
        check_name("channel", name, self.arrays)
        return self.arrays[name]

    def __contains__(self, name: object) -> bool:
        return name in self.arrays

    def __iter__(self) -> Iterator[str]:
        return iter(self.arrays)

    def __len__(self) -> int:
        return len(self.arrays["time"])

    def __eq__(self, other: object) -> bool:
        """Whether the other has the same arrays to the last bit, NaN included, and the same facts."""
        if not isinstance(other, Log):
            return NotImplemented
        if self.arrays.keys() != other.arrays.keys() or not _same(self.facts, other.facts):
            return False
        return all(_same(array, other.arrays[name]) for name, array in self.arrays.items())

    __hash__ = None  # type: ignore[assignment]

    def __add__(self, other: object) -> Log:
        """Return both one after the other, as episodes whose time goes on; pieces of one log as that log.

        Raises
        ------
        ProblemError
            If the two do not have the same channels, sizes and facts.
        """
        if not isinstance(other, Log):
            return NotImplemented
        return join_logs(self, other)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({len(self)} rows, {len(self.arrays)} channels, {self.duration:.4g} s)"

    def __str__(self) -> str:
        who = f" of {shown(self.facts['robot']).strip(chr(39))}" if "robot" in self.facts else ""
        rate = f" at {(len(self) - 1) / self.duration:.4g} Hz" if self.duration > 0.0 else ""
        end = f"; it ended: {self.facts['outcome']}" if "outcome" in self.facts else ""
        doubts = f"; doubts: {len(self.doubts)}, see .doubts" if self.doubts else ""
        more = f" and {len(self.arrays) - _SHOWN} more" if len(self.arrays) > _SHOWN else ""
        channels = ", ".join([*self][:_SHOWN]) + more
        rows = f"{self.duration:.4g} s, {count_of(len(self), 'row')}{rate}"
        return f"Log{who}: {rows}{end}{doubts}. Channels: {channels}."

    @property
    def duration(self) -> float:
        """Time from the first row to the last [s]."""
        return float(self["time"][-1] - self["time"][0]) if len(self) else 0.0

    def fact(self, name: str) -> Any:
        """Return a fact that cannot be done without, as `FACTS` defines it.

        Raises
        ------
        ProblemError
            If the log does not tell it, or tells something else.
        """
        if not isinstance(name, str):
            raise ProblemError(f"a fact is asked for by its name, got {shown(name)}")
        known = FACTS.get(name)
        if name not in self.facts:
            meaning = "" if known is None else f" ({known.meaning})"
            raise ProblemError(f"the log does not tell {name!r}{meaning}")
        return self.facts[name] if known is None else known.checked(name, self.facts[name], self.sizes)

    @property
    def doubts(self) -> tuple[str, ...]:
        """What is not plausible in a log from outside, one line each; see `log.find_doubts`."""
        found = self.facts.get("doubts", ())
        return (found,) if isinstance(found, str) else tuple(map(str, found))

    @property
    def episodes(self) -> tuple[Log, ...]:
        """The log's episodes, each a log: cut where the state was reset; the log itself if it never was."""
        starts = np.atleast_1d(self.facts.get("episode_rows", [0])).astype(int).tolist()
        if len(starts) < 2:
            return (self,)
        spans = enumerate(pairwise([*starts, len(self)]), 1)
        return tuple(
            Log(self.rows(slice(first, end)).arrays, facts_of_rows(self.facts, number, first, end, len(self)),
                channels=self.channels)
            for number, (first, end) in spans
        )  # fmt: skip

    def rows(self, which: Any) -> Log:
        """Return the log of some rows: a slice, a (T,) mask or (k,) places.

        Raises
        ------
        ProblemError
            For what picks no rows.
        """
        try:
            arrays = {name: array[which] for name, array in self.arrays.items()}
        except (IndexError, TypeError, ValueError, RuntimeError) as error:
            wanted = f"a slice, a ({len(self)},) mask or whole numbers from 0 to {len(self) - 1}"
            raise ProblemError(f"rows must be {wanted}, got {shown(which)}") from error
        facts = self.facts
        if "episode_rows" in facts:
            facts = facts_of_selection(facts, np.arange(len(self))[which])
        if isinstance(which, slice) and self.arrays.keys() == self.channels.keys():
            return self._same_channels(arrays, facts)
        return Log(arrays, facts, channels=self.channels)

    def _same_channels(self, arrays: dict[str, Any], facts: dict[str, Any]) -> Log:
        """Return a log of slices of this one's arrays, which fit each other as those do."""
        out = object.__new__(Log)
        out.arrays, out.facts, out.parts = arrays, facts, None
        out.channels, out.sizes = dict(self.channels), dict(self.sizes)
        return out

    def chunks(self, rows: int = 1 << 16) -> Iterator[Log]:
        """Yield the log in pieces of consecutive rows; a log of at most `rows` rows as it is."""
        if len(self) <= rows:
            yield self
            return
        for start in range(0, len(self), rows):
            yield self.rows(slice(start, start + rows))
            self.let_go()

    def let_go(self) -> None:
        """Tell the system that what is mapped from files is not needed in memory for now."""
        for array in self.arrays.values():
            _let_go(array)

    def save(self, path: Path | str) -> Path:
        """Write to a new file in the format of its suffix and return its path; .npz where it has none.

        The parts that the run left are removed when all is in the file, and kept if it cannot be written.

        Raises
        ------
        ProblemError
            If the file exists already (nothing is overwritten), or the suffix is of no format.
        WriteError
            If the disk has no room for it; no half file stays.
        """
        saved = write_log(self, path_of(path), self.parts)
        self.parts = None
        return saved


def _let_go(array: Any) -> None:
    """Tell the system that the pages of a mapped array are not needed for now."""
    mapped = array
    while isinstance(mapped, np.ndarray):
        mapped = mapped.base
    if hasattr(mapped, "madvise"):
        import mmap

        mapped.madvise(mmap.MADV_DONTNEED)


def join_logs(first: Log, second: Log) -> Log:
    """Return two logs of the same channels and facts as one; see `Log.__add__`."""
    if first.arrays.keys() != second.arrays.keys():
        apart = sorted(first.arrays.keys() ^ second.arrays.keys())
        raise ProblemError(f"logs of different channels cannot be joined: only one has {', '.join(apart)}")
    differ = [name for name in {**first.facts, **second.facts} if not _same_fact(name, first, second)]
    if differ:
        raise ProblemError(f"logs of different facts cannot be joined: {', '.join(sorted(differ))}")
    if not len(first) or not len(second):
        return first if len(first) else second
    step = float(np.median(np.diff(first["time"]))) if len(first) > 1 else float(first.facts.get("dt", 0.0))
    if not step > 0.0:
        raise ProblemError("logs can be joined where the first has rows at rising times, or the fact dt")
    later = float(first["time"][-1]) + step - float(second["time"][0])
    if abs(later) <= 0.5 * step:  # it goes on where the first ends: no new episode
        return Log(_concatenate(first, second), first.facts, channels=first.channels)
    arrays = _concatenate(first, second)
    arrays["time"][len(first) :] += later
    begins = [np.atleast_1d(one.facts.get("episode_rows", [0])).astype(int) for one in (first, second)]
    facts = first.facts | {"episode_rows": [*begins[0].tolist(), *(len(first) + begins[1]).tolist()]}
    return Log(arrays, facts, channels=first.channels)


def _concatenate(first: Log, second: Log) -> dict[str, Any]:
    return {name: np.concatenate([array, second.arrays[name]]) for name, array in first.arrays.items()}


def _same_fact(name: str, first: Log, second: Log) -> bool:
    own = ("episode_rows", "outcome", "doubts")
    return name in own or _same(first.facts.get(name), second.facts.get(name))


def _same(one: Any, other: Any) -> bool:
    """Return whether two values are equal, arrays in shape and every entry, NaN like NaN."""
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        return one.keys() == other.keys() and all(_same(value, other[key]) for key, value in one.items())
    a, b = np.asarray(one), np.asarray(other)
    if a.shape != b.shape:
        return False
    return bool(np.array_equal(a, b, equal_nan=a.dtype.kind == b.dtype.kind == "f"))
