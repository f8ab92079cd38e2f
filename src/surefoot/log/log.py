"""A log: arrays over time that say what they are, and facts about the run."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path
from typing import Any

import numpy as np

from surefoot.errors import ProblemError, unknown_name
from surefoot.log.channels import CHANNELS, Channel, check_shapes

MEMORY = 64 << 20
"""Largest log that is held in memory; a longer one is mapped from files [bytes]."""
FACTS: dict[str, str] = {
    "robot": "name",
    "kind": "what it did: stand, walk, ...",
    "mass": "of the robot [kg]",
    "dt": "length of a step [s]",
    "feet": "names of the feet",
    "joints": "names of the joints",
    "contact_foot": "(p,) index of the foot of every contact point",
    "contact_centres": "(p, 3) contact points in their feet's frames [m]",
    "effort_limits": "(joints,) [N m]",
    "duration": "of the run as planned [s]",
    "outcome": "how the run ended, see Ending",
    "error": "what ended the run or its recording",
    "wall_time": "real time of the run [s]",
    "normal_min": "least normal force that the controller asks of a foot [N]",
    "normal_max": "largest one [N]",
    "mu_controller": "friction that the controller believes in",
    "gait": "name of the gait",
    "notes": "what the controller changed in its command",
}
"""Facts that Surefoot writes and reads by name; a log may hold others."""


class Ending(StrEnum):
    """How a run ended."""

    DONE = "done"
    """All steps were made."""
    FELL = "fell"
    """The robot fell."""
    INVALID = "invalid"
    """The state stopped being finite, or the world could not go on."""
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

    Raises
    ------
    ProblemError
        For arrays that are no channels, or do not fit theirs or each other.
    """

    arrays: dict[str, Any]
    facts: dict[str, Any] = field(default_factory=dict)
    parts: Path | None = None
    channels: dict[str, Channel] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.arrays = {name: np.asanyarray(array) for name, array in self.arrays.items()}
        given = {**CHANNELS, **self.channels}
        check_shapes(self.arrays, given)
        self.channels = {name: given[name] for name in self.arrays}

    def __getitem__(self, name: str) -> Any:
        if name not in self.arrays:
            raise ProblemError(unknown_name("channel", name, self.arrays))
        return self.arrays[name]

    def __contains__(self, name: object) -> bool:
        return name in self.arrays

    def __len__(self) -> int:
        return len(self.arrays["time"])

    def fact(self, name: str) -> Any:
        """Return a fact that cannot be done without.

        Raises
        ------
        ProblemError
            If the log does not tell it.
        """
        if name not in self.facts:
            raise ProblemError(f"the log does not tell {name!r} ({FACTS.get(name, 'a fact of its own')})")
        return self.facts[name]

    def rows(self, which: Any) -> Log:
        """Return the log of some rows: a slice or a (T,) mask."""
        arrays = {name: array[which] for name, array in self.arrays.items()}
        return Log(arrays, self.facts, channels=self.channels)

    def chunks(self, rows: int = 1 << 16) -> Iterator[Log]:
        """Yield the log in pieces of consecutive rows; a log of at most `rows` rows as it is."""
        if len(self) <= rows:
            yield self
            return
        for start in range(0, len(self), rows):
            yield self.rows(slice(start, start + rows))
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
        from surefoot.log.formats import write_log

        return write_log(self, Path(path))


def _let_go(array: Any) -> None:
    """Tell the system that the pages of a mapped array are not needed for now."""
    mapped = array
    while isinstance(mapped, np.ndarray):
        mapped = mapped.base
    if hasattr(mapped, "madvise"):
        import mmap

        mapped.madvise(mmap.MADV_DONTNEED)
