"""A log on its way to the disk: a bounded number of rows in memory, the rest in one .npy file per field.

The files grow at their end and their headers are brought up to date after the data, so that at any moment,
also after the process was killed, each is a valid .npy file of the rows written so far.
"""

from __future__ import annotations

import json
import os
import struct
import tempfile
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from surefoot.errors import ProblemError, WriteError
from surefoot.simulation.log import MEMORY, Log, read_parts

CHUNK_BYTES = 1 << 20
"""Size of the rows that are held back before they are written to a folder that was asked for."""
HEADER_BYTES = 256
"""Length of a .npy header with room for any number of rows; a multiple of 64 as the format asks."""
FLAGS = ("active", "planned", "attained", "saturated")
FACTS = "facts.json"


class Parts:
    """The growing files of a log in a new folder.

    Parameters
    ----------
    folder
        Folder to make; nothing that exists is touched.
    rows
        Name to array, whose dtype and row shape the file takes.
    facts
        What is known about the run from its start on.

    Raises
    ------
    ProblemError
        If the folder exists already.
    WriteError
        If it cannot be written to.
    """

    def __init__(self, folder: Path, rows: dict[str, Any], facts: dict[str, Any]) -> None:
        self.folder = folder
        self._files: dict[str, Any] = {}
        try:
            folder.mkdir(parents=True)
        except FileExistsError as error:
            raise ProblemError(f"{folder} exists already") from error
        except OSError as error:
            raise WriteError(folder, error) from error
        try:
            self.write_facts(facts)
            for name, array in rows.items():
                self._files[name] = (folder / f"{name}.npy").open("xb", buffering=0)
                _write_at(self._files[name], 0, _header(array.dtype, (0, *array.shape[1:])))
        except OSError as error:
            self.remove()
            raise WriteError(folder, error) from error

    def append(self, rows: dict[str, Any], start: int, count: int) -> None:
        """Write the first `count` rows of every array as rows `start` on.

        Calling it again with the same `start`, after an interruption, writes the same again.
        """
        try:
            for name, file in self._files.items():
                array = rows[name]
                begin = HEADER_BYTES + start * array[:1].nbytes
                _write_at(file, begin, memoryview(array[:count].reshape(-1).view(np.uint8)))
            for name, file in self._files.items():
                _write_at(file, 0, _header(rows[name].dtype, (start + count, *rows[name].shape[1:])))
        except OSError as error:
            raise WriteError(self.folder, error) from error

    def write_facts(self, facts: dict[str, Any]) -> None:
        """Replace the facts, or keep the earlier ones if these cannot be written."""
        new = self.folder / f".{FACTS}"
        try:
            new.write_text(json.dumps({k: _plain(v) for k, v in facts.items()}), encoding="utf-8")
            new.replace(self.folder / FACTS)
        except OSError:
            new.unlink(missing_ok=True)
            raise

    def close(self) -> None:
        """Close the files; they stay."""
        for file in self._files.values():
            file.close()

    def remove(self) -> None:
        """Delete the files that were made here, and the folder if nothing else lies in it."""
        self.close()
        remove_parts(self.folder, self._files)


def remove_parts(folder: Path, names: Iterable[str]) -> None:
    """Delete the parts of a log by name, and the folder if nothing else lies in it."""
    for name in [*(f"{n}.npy" for n in names), FACTS, f".{FACTS}"]:
        (folder / name).unlink(missing_ok=True)
    try:
        folder.rmdir()
    except OSError:
        return  # something else lies in it, which is not ours


class Recorder:
    """Takes the rows of a log one by one and holds a bounded number of them in memory.

    Parameters
    ----------
    steps
        Largest number of rows.
    folder
        New folder that the rows are written to as they come; None to keep up to `MEMORY` bytes in memory
        and the rest in a temporary folder.
    facts
        What is known about the run from its start on; what a killed run leaves says that much.
    rows
        Name to shape of every field's row.

    Attributes
    ----------
    arrays
        Name to array of the rows in memory; write to row `slot()`, then add one to `count`.
    count
        Number of rows so far.
    """

    def __init__(
        self,
        steps: int,
        folder: Path | None = None,
        facts: dict[str, Any] | None = None,
        **rows: tuple[int, ...],
    ) -> None:
        kinds = {name: np.dtype(bool if name in FLAGS else np.float64) for name in rows}
        self._row_bytes = sum(kinds[n].itemsize * int(np.prod(s, dtype=int)) for n, s in rows.items())
        room = (MEMORY if folder is None else CHUNK_BYTES) // max(self._row_bytes, 1)
        self._rows = max(1, min(steps, room))
        self.arrays: dict[str, Any] = {n: np.zeros((self._rows, *s), dtype=kinds[n]) for n, s in rows.items()}
        self.count = self._written = 0
        self._facts = dict(facts or {})
        self._temporary: tempfile.TemporaryDirectory[str] | None = None
        self._parts = None if folder is None else Parts(folder, self.arrays, self._facts)

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

    def flush(self) -> None:
        """Write the rows that are in memory to the files."""
        if self._parts is None:
            try:
                self._temporary = tempfile.TemporaryDirectory(prefix="surefoot-log-")
                self._parts = Parts(Path(self._temporary.name) / "parts", self.arrays, self._facts)
            except OSError as error:
                raise WriteError(tempfile.gettempdir(), error) from error
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
        if self._parts is None:
            return Log({n: a[: self.count].copy() for n, a in self.arrays.items()}, facts)
        try:
            if self.count > self._written:
                self.flush()
            self._parts.write_facts(facts)
        except OSError as error:  # a WriteError is one
            facts.setdefault("error", str(error))
        self._parts.close()
        arrays = {n: a[: self._written] for n, a in read_parts(self._parts.folder)[0].items()}
        if self._row_bytes * self.count <= MEMORY:
            rest = self.count - self._written
            arrays = {n: np.concatenate([a, self.arrays[n][:rest]]) for n, a in arrays.items()}
        if self._temporary is not None:
            self._temporary.cleanup()  # what is mapped stays until it is let go
            return Log(arrays, facts)
        return Log(arrays, facts, self._parts.folder)


def _header(dtype: Any, shape: tuple[int, ...]) -> bytes:
    """Return the header of a .npy file, padded to `HEADER_BYTES`."""
    text = repr({"descr": np.lib.format.dtype_to_descr(dtype), "fortran_order": False, "shape": shape})
    body = text.encode("latin1").ljust(HEADER_BYTES - 11) + b"\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(body)) + body


def _write_at(file: Any, offset: int, data: bytes | memoryview) -> None:
    """Write all of the data at a place in an unbuffered file."""
    file.seek(offset, os.SEEK_SET)
    left = memoryview(data)
    while left:
        left = left[file.write(left) :]


def _plain(value: Any) -> Any:
    return value.tolist() if hasattr(value, "tolist") else value
