"""The formats that logs come in: one file each, one line in the table, or `register_format` from outside."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from surefoot.errors import ProblemError, SurefootError, WriteError
from surefoot.log import npz, parts
from surefoot.log.log import Log


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
        From the path of an existing file or folder to its log. Whatever it raises is told as
        "is not a log of this format"; an error of Surefoot's own goes on as it is.
    write
        Writes a log to an empty file; None for a format that is only read.
    """

    name: str
    suffixes: tuple[str, ...]
    read: Callable[[Path], Log]
    write: Callable[[Log, Path], None] | None = None


FORMATS: dict[str, Format] = {
    "npz": Format("npz", (".npz",), npz.read, npz.write),
    "parts": Format("parts", (".parts",), parts.read),
}


def register_format(new: Format) -> None:
    """Add a format to those of `read_log` and `Log.save`; one of the same name is replaced."""
    FORMATS[new.name] = new


def format_names() -> list[str]:
    """Return the names of the formats, sorted."""
    return sorted(FORMATS)


def format_of(path: Path) -> Format:
    """Return the format of a file by its suffix; a folder without one holds parts.

    Raises
    ------
    ProblemError
        If no format has that suffix.
    """
    for entry in FORMATS.values():
        if path.name.lower().endswith(entry.suffixes):
            return entry
    if path.is_dir():
        return FORMATS["parts"]
    valid = ", ".join(sorted(s for entry in FORMATS.values() for s in entry.suffixes))
    raise ProblemError(f"{path} is not a Surefoot log: its name should end in one of {valid}")


def read_log(path: Path | str) -> Log:
    """Read a log from a file of any format, or from the folder of parts that a killed run left.

    A long log is mapped from files and not read into memory.

    Raises
    ------
    ProblemError
        If the file is missing, not a log, or of a schema that this version does not know.
    """
    path = Path(path)
    entry = format_of(path)
    try:
        return entry.read(path)
    except SurefootError:
        raise
    except Exception as error:  # readers from outside raise what they like
        raise ProblemError(f"{path} is not a Surefoot log ({entry.name}): {error}") from error


def write_log(log: Log, path: Path) -> Path:
    """Write a log to a new file; see `Log.save`."""
    path = path if path.suffix else path.with_name(path.name + ".npz")
    entry = format_of(path)
    if entry.write is None:
        raise ProblemError(f"{path}: logs of the format {entry.name} can be read, not written")
    try:
        path.open("xb").close()  # ours from here on
        try:
            entry.write(log, path)
        except BaseException:
            path.unlink(missing_ok=True)
            raise
    except FileExistsError as error:
        raise ProblemError(f"{path} exists already") from error
    except OSError as error:
        kept = "" if log.parts is None else f"; its rows are in {log.parts}"
        raise WriteError(path, error, kept) from error
    if log.parts is not None:
        parts.remove(log.parts, log.arrays)
        log.parts = None
    return path
