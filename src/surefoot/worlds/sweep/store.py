"""A sweep's folder: rows as they come, one table in the end, nothing lost and nothing twice after a kill.

Rows go to ``sweep.sqlite``, which also says what the folder is of: SQLite's transactions survive kills and
power cuts, its lock keeps a second driver out, its primary key keeps a sample from being written twice. In
the end all rows are written to ``samples.parquet``, sorted by index, under a temporary name, then renamed.
"""

from __future__ import annotations

import json
import os
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

from surefoot.base.errors import ProblemError, WriteError, needs, writing
from surefoot.worlds.sweep.config import SweepConfig
from surefoot.worlds.sweep.space import TextRange
from surefoot.worlds.sweep.sweep_worker import Row

TABLE, ROWS = "samples.parquet", "sweep.sqlite"
MARK = b"surefoot.sweep"
"""Key of the sweep's identity in the table's metadata."""


class Store:
    """The folder of a sweep, locked until `close`; use it in `contextlib.closing`.

    Parameters
    ----------
    folder
        New, empty, or that of the same sweep.
    config
        What it is of.

    Attributes
    ----------
    done
        Indices of the samples whose rows are there.

    Raises
    ------
    ProblemError
        If the folder holds something else or another sweep, is in use, or cannot be read or written to.
    """

    def __init__(self, folder: str | Path, config: SweepConfig) -> None:
        self.folder, self.config = Path(folder), config
        with needs("pyarrow", "sweep"):
            import pyarrow.parquet
        self._arrow: Any = pyarrow
        self._schema = _schema(self._arrow, config)
        path = self.folder / ROWS
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            if not path.exists() and any(self.folder.iterdir()):
                raise ProblemError(f"{self.folder} is not empty and no sweep's folder; name another one")
            self._rows = sqlite3.connect(path, timeout=0.0, isolation_level=None)
        except (OSError, sqlite3.Error) as error:
            raise ProblemError(
                f"cannot write to {self.folder}: {getattr(error, 'strerror', error)}"
            ) from error
        try:
            self.done = self._claim()
        except sqlite3.DatabaseError as error:
            self.close()
            if "locked" in str(error):
                reason = f"another sweep is writing to {self.folder}: wait for it or end it"
            else:
                reason = f"{path} cannot be read ({error}); move it away to begin again"
            raise ProblemError(reason) from error
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Give the folder free."""
        self._rows.close()

    def _claim(self) -> set[int]:
        """Lock the rows, refuse another sweep's, and return the samples that are there."""
        self._rows.execute("PRAGMA locking_mode = EXCLUSIVE")  # until closed
        self._rows.execute("PRAGMA synchronous = EXTRA")  # after a power cut, too
        self._rows.execute("BEGIN EXCLUSIVE")
        self._rows.execute("CREATE TABLE IF NOT EXISTS sweep (identity TEXT)")
        self._rows.execute("CREATE TABLE IF NOT EXISTS samples (number INTEGER PRIMARY KEY, row TEXT)")
        (found,) = self._rows.execute("SELECT identity FROM sweep").fetchone() or (None,)
        if found is None:
            self._rows.execute("INSERT INTO sweep VALUES (?)", (json.dumps(self.config.identity()),))
        else:
            self._compare(found, self.folder)
        done = {number for (number,) in self._rows.execute("SELECT number FROM samples")}
        self._rows.execute("COMMIT")
        if max(done, default=0) >= self.config.samples:
            raise ProblemError(
                f"{self.folder} holds sample {max(done)}, the sweep has only {self.config.samples}; ask for "
                "as many, or name another folder"
            )
        return done

    def _compare(self, found: str, folder: Path) -> None:
        """Refuse a folder of another sweep."""
        there, here = json.loads(found), json.loads(json.dumps(self.config.identity()))
        key = next((key for key in {**here, **there} if there.get(key) != here.get(key)), None)
        if key is not None:
            raise ProblemError(
                f"{folder} holds another sweep ({key} is {json.dumps(there.get(key))} there, "
                f"{json.dumps(here.get(key))} here); name another folder"
            )

    def missing(self, first: int = 0, step: int = 1) -> list[int]:
        """Return the indices of samples `first`, `first` + `step`, ... that have no row, in their order."""
        return [k for k in range(first, self.config.samples, step) if k not in self.done]

    def take(self, folder: Path) -> None:
        """Take over the rows of other folders of the same sweep: this one's, and those of the folders in it.

        Raises
        ------
        ProblemError
            For a folder without a sweep, of another one, or one that is being written to.
        """
        found = sorted({*folder.glob(ROWS), *folder.glob(f"*/{ROWS}")} - {self.folder / ROWS})
        if not found:
            raise ProblemError(f"{folder} is no sweep's folder and holds none")
        for path in found:
            try:
                with closing(sqlite3.connect(path, timeout=0.0, isolation_level=None)) as other:
                    (identity,) = other.execute("SELECT identity FROM sweep").fetchone()
                    self._compare(identity, path.parent)
                    wanted = "SELECT number, row FROM samples WHERE number < ?"
                    rows = other.execute(wanted, (self.config.samples,)).fetchall()
            except (sqlite3.Error, TypeError) as error:
                raise ProblemError(f"{path} cannot be read ({error}); is its sweep at work?") from error
            self._insert(rows)

    def add(self, rows: list[Row]) -> None:
        """Write rows; those of samples that have one are ignored.

        Raises
        ------
        WriteError
            If that fails; what was written before is kept.
        """
        self._insert([(row["index"], json.dumps(row, default=lambda value: value.item())) for row in rows])

    def _insert(self, new: list[tuple[int, str]]) -> None:
        """Write rows as they are kept, with their samples' indices."""
        try:
            with self._rows:  # commits, or rolls back
                self._rows.execute("BEGIN")
                self._rows.executemany("INSERT OR IGNORE INTO samples VALUES (?, ?)", new)
        except sqlite3.Error as error:
            raise WriteError(self.folder / ROWS, OSError(str(error))) from error
        self.done.update(number for number, _ in new)

    def table(self) -> Any:
        """Return all rows, sorted by index: a pyarrow.Table."""
        rows = self._rows.execute("SELECT row FROM samples ORDER BY number")
        return self._arrow.Table.from_pylist([json.loads(row) for (row,) in rows], schema=self._schema)

    def write_table(self, table: Any) -> Path:
        """Write one Parquet file of all rows and return its path."""
        path = self.folder / TABLE
        temporary = path.with_name(TABLE + ".tmp")
        with writing(path):
            self._arrow.parquet.write_table(table, temporary)
            with temporary.open("rb") as stream:
                os.fsync(stream.fileno())
            os.replace(temporary, path)
        return path


def _schema(arrow: Any, config: SweepConfig) -> Any:
    """Return the Arrow schema of a sweep's rows: sample, how it ended, results (null where it has none)."""
    types = {"float": arrow.float64(), "bool": arrow.bool_(), "text": arrow.string()}
    kinds = {n: "text" if isinstance(r, TextRange) else "float" for n, r in config.space.ranges.items()}
    columns = [
        ("index", arrow.int64()),
        *((name, types[kind]) for name, kind in kinds.items()),
        ("status", arrow.string()),
        ("error", arrow.string()),
        *((name, types[kind]) for name, kind in config.experiment.columns.items()),
        ("wall_time", arrow.float64()),
    ]
    names = [name for name, _ in columns]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise ProblemError(
            f"experiment {config.name} has a result named as another column: {', '.join(twice)}"
        )
    return arrow.schema(columns, metadata={MARK: json.dumps(config.identity()).encode()})
