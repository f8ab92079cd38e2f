"""The formats that logs come in: one file each, one line in the table, or `register_format` from outside."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from surefoot.base.errors import ProblemError, SurefootError, WriteError, one_line
from surefoot.base.text_files import path_of
from surefoot.records.log import csv_file, mcap_file, npz, parts, rosbag
from surefoot.records.log.corrupt_file import SPOILT
from surefoot.records.log.log import Log
from surefoot.records.log.mapped import log_from_source
from surefoot.records.log.mapping import LogMapping
from surefoot.records.log.source import Source


@dataclass(frozen=True)
class Format:
    """A kind of file that holds a log.

    Attributes
    ----------
    name
        What it is called.
    suffixes
        How its files' names end, in lower case with their dot.
    read
        From the path of an existing file or folder to its log. Whatever it raises is reported as
        "is not a log of this format"; an error of Surefoot's own goes on as it is. None where `source` is.
    write
        Writes a log to an empty file; None for a format that is only read.
    source
        From the path to topics and fields that a mapping turns into a log, for files that others wrote;
        of a table also from its columns' names, where the file does not hold them.
    marker
        A file by which a folder is known to be of this format.
    """

    name: str
    suffixes: tuple[str, ...]
    read: Callable[[Path], Log] | None = None
    write: Callable[[Log, Path], None] | None = None
    source: Callable[..., Source] | None = None
    marker: str = ""


FORMATS: dict[str, Format] = {
    "npz": Format("npz", (".npz",), npz.read, npz.write),
    "parts": Format("parts", (".parts",), parts.read, marker=parts.FACTS_FILE),
    "csv": Format("csv", (".csv", ".tsv"), source=csv_file.source),
    "mcap": Format("mcap", (".mcap",), write=mcap_file.write, source=mcap_file.source),
    "rosbag": Format("rosbag", (".bag", ".db3"), source=rosbag.source, marker=rosbag.MARKER),
}


def register_format(new: Format) -> None:
    """Add a format to those of `read_log` and `Log.save`; one of the same name is replaced."""
    FORMATS[new.name] = new


def format_of(path: Path) -> Format:
    """Return the format of a file by its suffix, of a folder by what lies in it; else it holds parts.

    Raises
    ------
    ProblemError
        If no format has that suffix.
    """
    for entry in FORMATS.values():
        if path.name.lower().endswith(entry.suffixes):
            return entry
    if path.is_dir():
        marked = (f for f in FORMATS.values() if f.marker and (path / f.marker).exists())
        return next(marked, FORMATS["parts"])
    valid = ", ".join(sorted(s for entry in FORMATS.values() for s in entry.suffixes))
    raise ProblemError(f"{path} is not a Surefoot log: its name should end in one of {valid}")


def read_log(
    path: Path | str,
    mapping: LogMapping | Path | str | None = None,
    columns: Sequence[str] | None = None,
) -> Log:
    """Read a log from a file of any format, or from the folder of parts that a killed run left.

    A long log of Surefoot's own is mapped from files and not read into memory. What others wrote (CSV,
    MCAP, ROS bags) is turned into a log by a mapping; see docs/logs.md. What is not plausible in it stands in
    `Log.doubts`.

    Parameters
    ----------
    path
        File or folder.
    mapping
        From fields to channels, or the YAML file that holds it; None for what the file brings itself or else
        a guess, which stands in the fact ``mapping``.
    columns
        Names of the columns of a CSV file whose first line does not name them.

    Raises
    ------
    ProblemError
        If the file is missing, not a log, or of a schema that this version does not know; for a mapping that
        does not fit.
    MissingExtra
        If the format needs a package that is not installed.
    """
    path = path_of(path)
    entry = format_of(path)
    with _reported(path, "is not a Surefoot log", entry):
        if entry.source is not None:
            return log_from_source(_source(entry, path, columns), mapping, str(path))
        if entry.read is None or mapping is not None or columns is not None:
            raise ProblemError(f"{path}: logs of the format {entry.name} take no mapping and no columns")
        return entry.read(path)


def _source(entry: Format, path: Path, columns: Sequence[str] | None) -> Source:
    """Return what a file of others holds; columns are given to tables only."""
    assert entry.source is not None
    if columns is None:
        return entry.source(path)
    if entry.name != "csv":
        raise ProblemError(f"{path}: files of the format {entry.name} name their fields themselves")
    return entry.source(path, columns)


def read_source(path: Path | str, columns: Sequence[str] | None = None) -> Source:
    """Return what a file of others holds before any mapping: topics, fields, numbers.

    Raises
    ------
    ProblemError
        If the file cannot be read, or is of a format that needs no mapping.
    """
    path = path_of(path)
    entry = format_of(path)
    if entry.source is None:
        raise ProblemError(f"{path}: logs of the format {entry.name} take no mapping")
    with _reported(path, "cannot be read", entry):
        return _source(entry, path, columns)


@contextmanager
def _reported(path: Path, what: str, entry: Format) -> Iterator[None]:
    """Raise errors as Surefoot's: readers from outside raise what they like."""
    try:
        yield
    except SurefootError:
        raise
    except Exception as error:
        reason = one_line(error)[:300] or type(error).__name__
        if not path.exists():
            reason = "there is no such file"
        elif entry.name in SPOILT:
            reason = SPOILT[entry.name](path)
        raise ProblemError(f"{path} {what} ({entry.name}): {reason}") from error


def new_file(path: Path) -> tuple[Path, Callable[[Log, Path], None]]:
    """Return the path of a log to be written, with its suffix, and what writes it.

    Raises
    ------
    ProblemError
        For a format that is only read, or a file that exists.
    """
    path = path if path.suffix or not path.name else path.with_name(path.name + ".npz")
    entry = format_of(path)
    if entry.write is None:
        raise ProblemError(f"{path}: logs of the format {entry.name} can be read, not written")
    if path.exists():
        raise ProblemError(f"{path} exists already")
    return path, entry.write


def write_log(log: Log, path: Path) -> Path:
    """Write a log to a new file; see `Log.save`."""
    path, write = new_file(path)
    try:
        path.open("xb").close()  # ours from here on
        try:
            write(log, path)
        except BaseException:
            path.unlink(missing_ok=True)
            raise
    except OSError as error:
        kept = "" if log.parts is None else f"; its rows are in {log.parts}"
        raise WriteError(path, error, kept) from error
    if log.parts is not None:
        parts.remove(log.parts, log.arrays)
        log.parts = None
    return path
