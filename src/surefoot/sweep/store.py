"""A sweep's folder: parts as they come, one table in the end, nothing lost and nothing twice after a kill.

``sweep.json`` says what the folder is of. Rows go to ``parts/part-000000.parquet``, ... ; when all are there
they are merged into ``samples.parquet``, sorted by index, and the parts are removed. Every file is written
under a temporary name in its own folder and renamed, file and name brought to the disk, so that a file with
its final name is whole; only the process that holds the folder's lock writes.
"""

from __future__ import annotations

import contextlib
import errno
import json
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import IO, Any

from surefoot import __version__
from surefoot.errors import ProblemError, WriteError
from surefoot.sweep.columns import MARK, import_pyarrow, schema
from surefoot.sweep.config import VERSION, SweepConfig
from surefoot.sweep.worker import Row

TABLE, IDENTITY, PARTS, LOCK = "samples.parquet", "sweep.json", "parts", ".lock"
TEMPORARY, UNREADABLE = ".tmp", ".unreadable"
_NO_FOLDERS = (errno.EINVAL, errno.ENOTSUP, errno.EACCES, errno.EPERM)
"""Of systems, and of folders above a sweep's, that cannot be asked to bring a folder to the disk."""


class Store:
    """The folder of a sweep, locked until `close`; use it in a with statement.

    Parameters
    ----------
    folder
        New, empty, or that of the same sweep.
    config
        What it is of.

    Attributes
    ----------
    done
        Indices of the samples whose rows are there, those not yet written included.
    notes
        What was found to be wrong, one line each.

    Raises
    ------
    ProblemError
        If the folder holds something else or another sweep, is in use, or cannot be written to.
    """

    def __init__(self, folder: str | Path, config: SweepConfig) -> None:
        self.folder, self.config, self.notes = Path(folder), config, list[str]()
        self._arrow, self._schema = import_pyarrow(), schema(config)
        self._parts = self.folder / PARTS
        self._new: list[Row] = []
        self._lock = self._open()
        try:
            self._claim()
            self.done: set[int] = set()
            self._tables = list(self._read())
            self._number = 1 + max((int(p.stem[5:]) for p in self._part_files()), default=-1)
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> Store:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Give the folder free."""
        self._lock.close()

    def missing(self) -> list[int]:
        """Return the indices of the samples that have no row, in their order."""
        return [k for k in range(self.config.samples) if k not in self.done]

    def add(self, rows: list[Row]) -> None:
        """Take rows; those of samples that have one are ignored."""
        for row in rows:
            if row["index"] not in self.done:
                self.done.add(row["index"])
                self._new.append(row)

    def flush(self) -> None:
        """Write the rows taken since the last time as one part.

        Raises
        ------
        WriteError
            If that fails; the rows stay taken.
        """
        if not self._new:
            return
        table = self._arrow.Table.from_pylist(self._new, schema=self._schema)
        self._write_table(self._parts / f"part-{self._number:06d}.parquet", table)
        self._tables.append(table)
        self._number += 1
        self._new = []

    def table(self) -> Any:
        """Return all rows that are written, sorted by index: a pyarrow.Table."""
        return self._arrow.concat_tables(self._tables or [self._schema.empty_table()]).sort_by("index")

    def merge(self) -> Path:
        """Write one table of all rows, remove the parts and return the table's path."""
        self.flush()
        path, parts = self.folder / TABLE, list(self._part_files())
        if parts or not path.exists():
            self._write_table(path, self.table())
            for part in parts:
                part.unlink()
        return path

    def _open(self) -> IO[str]:
        """Make the folders and lock them."""
        try:
            if self.folder.is_dir() and not (self.folder / IDENTITY).exists() and self._strange():
                raise ProblemError(f"{self.folder} is not empty and no sweep's folder; name another one")
            self._parts.mkdir(parents=True, exist_ok=True)
            for folder in (self.folder, *self.folder.resolve().parents[:1]):
                _keep_names(folder)
            lock = (self.folder / LOCK).open("w")
        except OSError as error:
            raise ProblemError(f"cannot write to {self.folder}: {error.strerror}") from error
        try:
            import fcntl

            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except ImportError:  # a system without flock
            pass
        except OSError as error:
            lock.close()
            raise ProblemError(f"another sweep is writing to {self.folder}: wait for it or end it") from error
        return lock

    def _strange(self) -> bool:
        """Tell whether the folder holds what no sweep leaves before its first file."""
        ours = {LOCK, PARTS, IDENTITY + TEMPORARY}
        return any(entry.name not in ours for entry in self.folder.iterdir())

    def _claim(self) -> None:
        """Say what the folder is of, or refuse another sweep's; remove what a killed driver left undone."""
        path, own = self.folder / IDENTITY, self.config.identity()
        if path.exists():
            try:
                found = json.loads(path.read_text(encoding="utf-8"))
            except (OSError, ValueError) as error:
                raise ProblemError(f"{path} cannot be read: {error}") from error
            if found != json.loads(json.dumps(own)):
                self._refuse_version(found)
                raise ProblemError(
                    f"{self.folder} holds another sweep ({_difference(found, own)}); name another folder"
                )
        else:
            text = json.dumps(own, indent=2)
            self._put(path, lambda name: name.write_text(text + "\n", encoding="utf-8"))
        for left in (*self.folder.glob("*" + TEMPORARY), *self._parts.glob("*" + TEMPORARY)):
            left.unlink()

    def _refuse_version(self, found: Any) -> None:
        """Refuse a folder of another version of Surefoot, whose rows may differ from this one's."""
        there = found.get(VERSION, "no version") if isinstance(found, dict) else __version__
        if there != __version__:
            raise ProblemError(
                f"{self.folder} was begun by Surefoot {there}, this is {__version__}, whose results may "
                "differ; name another folder, or go on with that version"
            )

    def _part_files(self) -> list[Path]:
        return sorted(p for p in self._parts.glob("part-*.parquet") if p.stem[5:].isdigit())

    def _read(self) -> Iterator[Any]:
        """Yield the rows that are there, each once; files that cannot be read are put aside."""
        table = self.folder / TABLE
        for path in ([table] if table.exists() else []) + self._part_files():
            try:
                rows = self._arrow.parquet.read_table(path, page_checksum_verification=True, memory_map=False)
            except (OSError, self._arrow.ArrowException) as error:
                aside = path.with_name(path.name + UNREADABLE)
                os.replace(path, aside)
                told = " ".join(str(error).split())
                self.notes.append(
                    f"{path} cannot be read ({told:.80}); now {aside.name}, its samples run again"
                )
                continue
            yield self._checked(path, rows)

    def _checked(self, path: Path, rows: Any) -> Any:
        """Return the rows of a file whose samples were not seen before; they must be this sweep's."""
        mark = (rows.schema.metadata or {}).get(MARK)
        if mark != self._schema.metadata[MARK] or not rows.schema.equals(self._schema):
            raise ProblemError(f"{path} is not of this sweep; move it away")
        indices = rows["index"].to_pylist()
        beyond = [k for k in indices if not 0 <= k < self.config.samples]
        if beyond:
            raise ProblemError(
                f"{path} holds sample {max(beyond)}, the sweep has only {self.config.samples}; ask for as "
                "many, or name another folder"
            )
        names = self.config.space.names
        given = (
            zip(*(rows[name].to_pylist() for name in names), strict=True) if names else ((),) * len(indices)
        )
        for sample, values in zip(self.config.space.sample(indices), given, strict=True):
            if tuple(sample.values[name] for name in names) != tuple(values):
                raise ProblemError(
                    f"{path}: sample {sample.index} was drawn otherwise, by another version of SciPy; name "
                    "another folder"
                )
        fresh = []
        for index in indices:
            fresh.append(index not in self.done)
            self.done.add(index)
        return rows.filter(self._arrow.array(fresh, type=self._arrow.bool_()))

    def _write_table(self, path: Path, table: Any) -> None:
        write = self._arrow.parquet.write_table
        self._put(path, lambda name: write(table, name, write_page_checksum=True))

    def _put(self, path: Path, write: Callable[[Path], Any]) -> None:
        """Write a file under a temporary name, have it on the disk, and give it its own."""
        name = path.with_name(path.name + TEMPORARY)
        try:
            write(name)
            with name.open("rb") as stream:
                os.fsync(stream.fileno())
            os.replace(name, path)
            _keep_names(path.parent)
        except OSError as error:
            with contextlib.suppress(OSError):
                name.unlink()
            raise WriteError(path, error) from error


def _keep_names(folder: Path) -> None:
    """Have a folder's names on the disk: a renamed file could else be gone after a power cut."""
    try:
        opened = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(opened)
        finally:
            os.close(opened)
    except OSError as error:
        if error.errno not in _NO_FOLDERS:
            raise


def _difference(found: Any, own: dict[str, Any], where: str = "") -> str:
    """Return the first entry that differs, and both of its values."""
    if not isinstance(found, dict):
        return "sweep.json is of another kind"
    for key in sorted({*found, *own}):
        here, there = own.get(key), found.get(key)
        name = f"{where}.{key}" if where else key
        if isinstance(here, dict) and isinstance(there, dict):
            told = _difference(there, here, name)
            if told:
                return told
        elif json.dumps(here) != json.dumps(there):
            return f"{name} is {json.dumps(there)} there, {json.dumps(here)} here"
    return ""
