"""Tables of numbers as text: one row per instant, a line of names first."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError
from surefoot.records.log.source import Source, Topic, check_size

MOST_COLUMNS = 10_000
"""A table with more columns than this is no log."""
LONGEST_NAME = 80
"""A first line that is one word longer than this is no column's name."""


def source(path: Path, columns: Sequence[str] | None = None) -> Source:
    """Return the table of a CSV file: columns separated by comma, semicolon, tab or blanks.

    An empty cell is NaN. The first line names the columns unless `columns` does.

    Raises
    ------
    ProblemError
        For a file that is empty or no text, a cell that is no number, a row of another length, or a name
        that two columns share.
    """
    check_size(path.stat().st_size, path)
    try:
        with path.open(encoding="utf-8-sig") as file:
            line = file.readline(1 << 20)
            cells, separator = _cells(line)
            names = _checked_names(path, line, cells) if columns is None else list(columns)
            text = file.read() if columns is None else line + file.read()
        twice = [name for k, name in enumerate(names) if name in names[:k]]
        if twice:
            raise ProblemError(f"{path}: two columns are called {twice[0]!r}")
        if "\0" in line or "\0" in text:
            raise ProblemError(f"{path} is no text: it holds zero bytes")
        table = _numbers(path, text, names, separator, 2 if columns is None else 1)
    except UnicodeDecodeError as error:
        raise ProblemError(f"{path} is no text: {error.reason} at byte {error.start}") from error
    except csv.Error as error:
        raise ProblemError(f"{path} is no table, a quote may be open: {error}") from error
    return Source({"": Topic(None, {name: table[:, k] for k, name in enumerate(names)})})


def _cells(line: str) -> tuple[list[str], str]:
    """Return the cells of a line and what separates them."""
    separator = max(",;\t", key=line.count)
    cells = next(csv.reader([line], delimiter=separator), []) if separator in line else line.split()
    return cells, separator if separator in line else " "


def _checked_names(path: Path, line: str, cells: list[str]) -> list[str]:
    """Return the columns' names that the first line gives."""
    names = [cell.strip().strip('"') for cell in cells]
    if not any(names) or len(names) > MOST_COLUMNS or (len(names) == 1 and len(names[0]) > LONGEST_NAME):
        raise ProblemError(f"{path}: the first line must name the columns, got {line.strip()[:80]!r}")
    if sum(map(_is_number, names)) > len(names) / 2:
        raise ProblemError(
            f"{path}: the first line must name the columns, got numbers: {line.strip()[:80]!r}; give their "
            f"{len(names)} names, columns=[...] or --columns"
        )
    return names


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _numbers(path: Path, text: str, names: list[str], separator: str, first: int) -> FloatArray:
    """Return the (T, columns) table of a text that begins in line `first` of the file."""
    if not text.strip():
        raise ProblemError(f"{path} has no rows")
    try:
        delimiter = None if separator == " " else separator
        table = np.loadtxt(io.StringIO(text), delimiter=delimiter, ndmin=2, comments=None)
        if table.shape[1] == len(names):
            return np.asarray(table, dtype=np.float64)
    except (ValueError, IndexError):
        pass  # the slow way says what is wrong, or takes empty cells
    rows = []
    for at, cells in enumerate(csv.reader(io.StringIO(text), delimiter=separator), start=first):
        if not cells:
            continue
        if separator == " ":
            cells = [cell for cell in cells if cell]
        if len(cells) != len(names):
            raise ProblemError(f"{path}, line {at}: {len(cells)} cells, {len(names)} columns are named")
        rows.append([_cell(path, at, name, cell) for name, cell in zip(names, cells, strict=True)])
    return np.array(rows, dtype=np.float64)


_WORDS = {"": float("nan"), "true": 1.0, "false": 0.0}


def _cell(path: Path, line: int, name: str, cell: str) -> float:
    text = cell.strip().lower()
    if text in _WORDS:
        return _WORDS[text]
    try:
        return float(text.replace("_", "?"))  # Python takes 1_0 for 10
    except ValueError as error:
        raise ProblemError(f"{path}, line {line}, column {name}: {cell[:40]!r} is no number") from error
