"""The formats that logs come in: one file each, one line in the table, or `register_format` from outside."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from surefoot.base.errors import ProblemError, WriteError
from surefoot.records.log import csv_file, csv_folder, kept_states, mcap_file, npz, part_files, rosbag
from surefoot.records.log.contents import LogContents
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
        From the path of an existing file or folder to its `Log` or `StoredLog`. Whatever it raises is
        reported as "is not a log of this format"; an error of Surefoot's own goes on as it is. None where
        `source` is.
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
    read: Callable[[Path], LogContents] | None = None
    write: Callable[[Any, Path], None] | None = None
    source: Callable[..., Source] | None = None
    marker: str = ""


def _arrays(path: Path) -> Source:
    """Return the table that somebody's archive of arrays is; its reader is loaded where one is read."""
    from surefoot.records.log import npz_table

    return npz_table.source(path)


FORMATS: dict[str, Format] = {
    "npz": Format("npz", (".npz",), npz.read, npz.write),
    "arrays": Format("arrays", (), source=_arrays),
    "parts": Format("parts", (".parts",), part_files.read, marker=part_files.FACTS_FILE),
    "csv": Format("csv", (".csv", ".tsv"), source=csv_file.source),
    "csv folder": Format("csv folder", (), source=csv_folder.source),
    "mcap": Format("mcap", (".mcap",), write=mcap_file.write, source=mcap_file.source),
    "rosbag": Format("rosbag", (".bag", ".db3"), source=rosbag.source, marker=rosbag.MARKER),
}


def register_format(new: Format) -> None:
    """Add a format to those of `read_log` and `Log.save`; one of the same name is replaced."""
    FORMATS[new.name] = new


def _is_foreign(path: Path) -> bool:
    """Return whether an .npz file is no log of ours, nor what is left of one."""
    from surefoot.records.log import npz_table

    return path.is_file() and npz_table.is_foreign(path)


def format_of(path: Path) -> Format:
    """Return the format of a file by its suffix, of a folder by what lies in it; else it holds parts.

    An .npz file of arrays that are not a log of ours is a table, as a .csv file is.

    Raises
    ------
    ProblemError
        If no format has that suffix.
    """
    for entry in FORMATS.values():
        if path.name.lower().endswith(entry.suffixes):
            return FORMATS["arrays"] if entry.read is npz.read and _is_foreign(path) else entry
    if path.is_dir():
        marked = (f for f in FORMATS.values() if f.marker and (path / f.marker).exists())
        tables = FORMATS["csv folder"] if csv_folder.is_folder(path) else FORMATS["parts"]
        return next(marked, tables)
    valid = ", ".join(sorted(s for entry in FORMATS.values() for s in entry.suffixes))
    raise ProblemError(f"{path} is not a Surefoot log: its name should end in one of {valid}")


def new_file(path: Path) -> tuple[Path, Callable[[Any, Path], None]]:
    """Return the path of a log to be written, with its suffix, and what writes it.

    Raises
    ------
    ProblemError
        For a format that is only read, or a file that exists.
    """
    path = path if path.suffix or not path.name else path.with_name(path.name + ".npz")
    if path.is_file():
        raise ProblemError(f"{path} exists already")
    entry = format_of(path)
    if entry.write is None:
        raise ProblemError(f"{path}: logs of the format {entry.name} can be read, not written")
    if path.exists():
        raise ProblemError(f"{path} exists already")
    return path, entry.write


def write_log(log: LogContents, path: Path, folder: Path | None = None) -> Path:
    """Write a log to a new file, and remove the folder of parts that its run left; see `Log.save`."""
    path, write = new_file(path)
    if folder is not None and path.suffix.lower() != ".npz" and kept_states.kept_files(folder):
        raise ProblemError(f"{path}: a log that has kept states is saved as .npz")
    try:
        path.open("xb").close()  # ours from here on
        try:
            write(log, path)
            if folder is not None and path.suffix.lower() == ".npz":
                kept_states.add_states(path, folder)
        except BaseException:
            path.unlink(missing_ok=True)
            raise
    except OSError as error:
        kept = "" if folder is None else f"; its rows are in {folder}"
        raise WriteError(path, error, kept) from error
    if folder is not None:
        part_files.remove(folder, log.arrays)
    return path
