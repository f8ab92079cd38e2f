"""A log on its way to the disk: a bounded number of rows in memory, the rest in files that grow."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Iterable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from surefoot.base.errors import WriteError, writing
from surefoot.records.log import part_files
from surefoot.records.log.channels import Channel
from surefoot.records.log.contents import MEMORY
from surefoot.records.log.log import Log

CHUNK_BYTES = 1 << 20
"""Size of the rows that are held back before they are written to a folder that was asked for."""
HELD_BACK = 0.1
"""Longest part of a run that is held back, where the fact ``dt`` tells the time of a row: a process that is
killed loses no more of it [s]."""


class Recorder:
    """Takes the rows of a log one by one and holds a bounded number of them in memory.

    Parameters
    ----------
    steps
        Largest number of rows.
    channels
        What a row holds.
    folder
        New folder that the rows are written to as they come; None to keep up to `MEMORY` bytes in memory
        and the rest in a temporary folder.
    facts
        What is known about the run from its start on; what a killed run leaves says that much.
    sizes
        Numbers for the sizes that channels name (``nq``, ``p``, ...).

    Attributes
    ----------
    arrays
        Name to array of the rows in memory; write to row `slot()`, then add one to `count`, or leave both to
        `write`.
    count
        Number of rows so far.
    """

    def __init__(
        self,
        steps: int,
        channels: Iterable[Channel],
        folder: Path | None = None,
        facts: dict[str, Any] | None = None,
        **sizes: int,
    ) -> None:
        self._channels = {channel.name: channel.sized(**sizes) for channel in channels}
        rows = self._channels.values()
        self._row_bytes = sum(c.dtype.itemsize * math.prod(c.row_shape) for c in rows)
        room = (MEMORY if folder is None else CHUNK_BYTES) // max(self._row_bytes, 1)
        if folder is not None and facts and "dt" in facts:
            room = min(room, round(HELD_BACK / float(facts["dt"])))
        self._rows = max(1, min(steps, room))
        self.arrays: dict[str, Any] = {c.name: np.zeros((self._rows, *c.row_shape), c.dtype) for c in rows}
        self.count = self._written = 0
        self._facts = dict(facts or {})
        self._temporary: tempfile.TemporaryDirectory[str] | None = None
        self._parts = None if folder is None else part_files.PartFiles(folder, rows, self._facts)

    def slot(self) -> int:
        """Return the row of `arrays` for the next step, after writing a full chunk away.

        Raises
        ------
        WriteError
            If the chunk cannot be written; no row is lost.
        """
        at = self.count - self._written
        if at == self._rows:
            self.flush()
            return 0
        return at

    def write(self, values: Sequence[Any]) -> None:
        """Take a row: one value for every channel, in their order, that can be assigned to its row.

        Raises
        ------
        WriteError
            If a full chunk cannot be written; no row is lost.
        ValueError, TypeError
            For a value that does not fit its channel.
        """
        at = self.slot()
        for array, value in zip(self.arrays.values(), values, strict=True):
            array[at] = value
        self.count += 1  # last: an interrupted row is none

    def flush(self) -> None:
        """Write the rows that are in memory to the files."""
        if self._parts is None:
            with writing(tempfile.gettempdir()):
                self._temporary = tempfile.TemporaryDirectory(prefix="surefoot-log-")
                folder = Path(self._temporary.name) / "parts"
                self._parts = part_files.PartFiles(folder, self._channels.values(), self._facts)
        self._parts.append(self.arrays, self._written, self.count - self._written)
        self._written = self.count  # last: an interrupted flush is made again

    def abandon(self) -> None:
        """Close what a run leaves that ended in an error: the rows so far, or nothing if there are none."""
        if self._parts is None:
            return
        if self.count == 0:
            self._parts.remove()
        else:
            with suppress(WriteError):
                self.flush()
            self._parts.close()

    def finish(self, facts: dict[str, Any]) -> Log:
        """Return the log of the rows so far, in memory if it is small and else mapped from the files.

        Where the disk has no room for the last rows, a small log still holds all and its fact ``error``
        says what went wrong; a large one ends with the last row that could be written.
        """
        facts = {**self._facts, **facts}
        # a controller's lists may go on with its next run
        facts = {name: list(value) if isinstance(value, list) else value for name, value in facts.items()}
        if self._parts is None:
            arrays = {n: a[: self.count].copy() for n, a in self.arrays.items()}
            return Log(arrays, facts, channels=self._channels)
        try:
            if self.count > self._written:
                self.flush()
            self._parts.write_facts(facts)
        except OSError as error:  # a WriteError is one
            facts.setdefault("error", str(error))
        self._parts.close()
        arrays = {n: a[: self._written] for n, a in part_files.read(self._parts.folder).arrays.items()}
        if self._row_bytes * self.count <= MEMORY:
            rest = self.count - self._written
            arrays = {n: np.concatenate([a, self.arrays[n][:rest]]) for n, a in arrays.items()}
        kept = None if self._temporary is not None else self._parts.folder
        if self._temporary is not None:
            self._temporary.cleanup()  # what is mapped stays until it is let go
        return Log(arrays, facts, kept, self._channels)
