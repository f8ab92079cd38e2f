"""A log as a folder of growing files: one .npy file per channel, and facts.json.

The files grow at their end and their headers are brought up to date after the data, so that at any moment,
also after the process was killed, each is a valid .npy file of the rows written so far.
"""

from __future__ import annotations

import json
import os
import struct
from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from surefoot.base.errors import ProblemError, WriteError, writing
from surefoot.records.log.channels import SCHEMA, Channel, channels_from
from surefoot.records.log.contents import StoredLog
from surefoot.records.log.kept_states import remove_states
from surefoot.records.log.npz import check_schema

HEADER_BYTES = 256
"""Length of a .npy header with room for any number of rows; a multiple of 64 as the format asks."""
FACTS_FILE = "facts.json"


def read(folder: Path) -> StoredLog:
    """Return the contents of a folder of parts, mapped; only rows that are in every file count.

    Raises
    ------
    ProblemError
        If the folder holds no log.
    """
    whole = json.loads((folder / FACTS_FILE).read_text(encoding="utf-8"))
    files = {p.stem: p for p in sorted(folder.glob("*.npy"))}
    check_schema(folder, whole["schema"])
    channels, facts = channels_from(whole["channels"]), whole["facts"]
    arrays = {name: np.load(files[name], mmap_mode="r") for name in channels if name in files}
    rows = min(map(len, arrays.values()), default=0)
    return StoredLog({name: array[:rows] for name, array in arrays.items()}, facts, channels)


class PartFiles:
    """The growing files of a log in a new folder.

    Parameters
    ----------
    folder
        Folder to make; nothing that exists is touched.
    channels
        What each file holds, with numbers for sizes.
    facts
        What is known about the run from its start on.

    Raises
    ------
    ProblemError
        If the folder exists already.
    WriteError
        If it cannot be written to.
    """

    def __init__(self, folder: Path, channels: Iterable[Channel], facts: dict[str, Any]) -> None:
        self.folder, self._channels = folder, tuple(channels)
        self._files: dict[str, Any] = {}
        try:
            folder.mkdir(parents=True)
        except FileExistsError as error:
            raise ProblemError(f"{folder} exists already") from error
        except OSError as error:
            raise WriteError(folder, error) from error
        try:
            self.write_facts(facts)
            for channel in self._channels:
                file = self._files[channel.name] = (folder / f"{channel.name}.npy").open("xb", buffering=0)
                _write_at(file, 0, _header(channel.dtype, (0, *channel.row_shape)))
        except OSError as error:
            self.remove()
            raise WriteError(folder, error) from error

    def append(self, rows: dict[str, Any], start: int, count: int) -> None:
        """Write the first `count` rows of every array as rows `start` on.

        Calling it again with the same `start`, after an interruption, writes the same again.
        """
        with writing(self.folder):
            for name, file in self._files.items():
                array = rows[name]
                begin = HEADER_BYTES + start * array[:1].nbytes
                _write_at(file, begin, array[:count].reshape(-1).view(np.uint8).data)
            for name, file in self._files.items():
                _write_at(file, 0, _header(rows[name].dtype, (start + count, *rows[name].shape[1:])))

    def write_facts(self, facts: dict[str, Any]) -> None:
        """Replace the facts, or keep the earlier ones if these cannot be written."""
        new = self.folder / f".{FACTS_FILE}"
        plain = {name: _plain(value) for name, value in facts.items()}
        channels = [asdict(channel) for channel in self._channels]
        text = json.dumps({"schema": SCHEMA, "channels": channels, "facts": plain})
        try:
            new.write_text(text, encoding="utf-8")
            new.replace(self.folder / FACTS_FILE)
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
        remove(self.folder, self._files)


def remove(folder: Path, names: Iterable[str]) -> None:
    """Delete the parts of a log by name, and the folder if nothing else lies in it."""
    for name in [*(f"{n}.npy" for n in names), FACTS_FILE, f".{FACTS_FILE}"]:
        (folder / name).unlink(missing_ok=True)
    remove_states(folder)
    try:
        folder.rmdir()
    except OSError:
        return  # something else lies in it, which is not ours


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
