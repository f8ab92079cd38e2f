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
from surefoot.base.errors import ProblemError, check_name, shown
from surefoot.base.text_files import path_of
from surefoot.records.log.channels import CHANNELS, Channel, check_shapes
from surefoot.records.log.facts import FACTS, facts_of_rows, facts_of_selection
from surefoot.records.log.formats import write_log


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


@dataclass
class Log:
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

    def __getitem__(self, name: str) -> Any:
        check_name("channel", name, self.arrays)
        return self.arrays[name]

    def __contains__(self, name: object) -> bool:
        return name in self.arrays

    def __iter__(self) -> Iterator[str]:
        return iter(self.arrays)

    def __len__(self) -> int:
        return len(self.arrays["time"])

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
        return Log(arrays, facts, channels=self.channels)

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
