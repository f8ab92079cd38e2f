"""Reading logs from files of any format of `formats`, with a mapping where others wrote them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from surefoot.base.errors import ProblemError, SurefootError, one_line
from surefoot.base.text_files import path_of
from surefoot.records.log.corrupt_file import SPOILT
from surefoot.records.log.formats import Format, format_of
from surefoot.records.log.from_source import log_from_source
from surefoot.records.log.log import Log
from surefoot.records.log.mapping import LogMapping
from surefoot.records.log.source import Source


def read_log(
    path: Path | str,
    mapping: LogMapping | Path | str | None = None,
    columns: Sequence[str] | None = None,
    rate: float | None = None,
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
    rate
        Of the rows of a CSV file that has no column of stamps [Hz].

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
    with _report_errors(path, "is not a Surefoot log", entry):
        if entry.source is not None:
            return log_from_source(_source(entry, path, columns), mapping, str(path), rate)
        if entry.read is None or any(given is not None for given in (mapping, columns, rate)):
            raise ProblemError(f"{path}: logs of the format {entry.name} take no mapping, columns or rate")
        contents = entry.read(path)
        if isinstance(contents, Log):
            return contents
        return Log(dict(contents.arrays), dict(contents.facts), channels=dict(contents.channels))


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
    with _report_errors(path, "cannot be read", entry):
        return _source(entry, path, columns)


@contextmanager
def _report_errors(path: Path, what: str, entry: Format) -> Iterator[None]:
    """Raise errors as Surefoot's: readers from outside raise what they like."""
    try:
        yield
    except ProblemError as error:
        if entry.name == "arrays" and str(path) not in str(error):  # it may have been meant for one of ours
            raise ProblemError(f"{path} is not a Surefoot log, and as a table of arrays: {error}") from error
        raise
    except SurefootError:
        raise
    except Exception as error:
        reason = one_line(error)[:300] or type(error).__name__
        if not path.exists():
            reason = "there is no such file"
        elif entry.name in SPOILT:
            reason = SPOILT[entry.name](path)
        raise ProblemError(f"{path} {what} ({entry.name}): {reason}") from error
