"""Tables of numbers as text: one row per instant, a line of names first."""

from __future__ import annotations

import csv
import io
from pathlib import Path

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.errors import ProblemError
from surefoot.log.source import Source, Topic, check_size

MOST_COLUMNS = 10_000
"""A table with more columns than this is no log."""


def source(path: Path) -> Source:
    """Return the table of a CSV file: columns separated by comma, semicolon, tab or blanks.

    An empty cell is NaN.

    Raises
    ------
    ProblemError
        For a file that is empty or no text, a cell that is no number, a row of another length, or a name
        that two columns share.
    """
    check_size(path.stat().st_size, path)
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            line = file.readline(1 << 20)
            names, separator = _header(path, line)
            text = file.read()
    except UnicodeDecodeError as error:
        raise ProblemError(f"{path} is no text: {error.reason} at byte {error.start}") from error
    if "\0" in line or "\0" in text:
        raise ProblemError(f"{path} is no text: it holds zero bytes")
    table = _numbers(path, text, names, separator)
    return Source({"": Topic(None, {name: table[:, k] for k, name in enumerate(names)})})


def _header(path: Path, line: str) -> tuple[list[str], str]:
    """Return the columns' names and what separates them."""
    separator = max(",;\t", key=line.count)
    cells = next(csv.reader([line], delimiter=separator), []) if separator in line else line.split()
    names = [cell.strip().strip('"') for cell in cells]
    if len(names) < 2 or len(names) > MOST_COLUMNS:
        raise ProblemError(f"{path}: the first line must name the columns, got {line.strip()[:80]!r}")
    if sum(map(_is_number, names)) > len(names) / 2:
        raise ProblemError(
            f"{path}: the first line must name the columns, got numbers: {line.strip()[:80]!r}"
        )
    twice = [name for k, name in enumerate(names) if name in names[:k]]
    if twice:
        raise ProblemError(f"{path}: two columns are called {twice[0]!r}")
    return names, separator if separator in line else " "


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _numbers(path: Path, text: str, names: list[str], separator: str) -> FloatArray:
    """Return the (T, columns) table."""
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
    for at, cells in enumerate(csv.reader(io.StringIO(text), delimiter=separator), start=2):
        if not cells:
            continue
        if separator == " ":
            cells = [cell for cell in cells if cell]
        if len(cells) != len(names):
            raise ProblemError(f"{path}, line {at}: {len(cells)} cells, the first line names {len(names)}")
        rows.append([_cell(path, at, name, cell) for name, cell in zip(names, cells, strict=True)])
    return np.array(rows, dtype=np.float64)


_WORDS = {"": float("nan"), "true": 1.0, "false": 0.0}


def _cell(path: Path, line: int, name: str, cell: str) -> float:
    text = cell.strip().lower()
    if text in _WORDS:
        return _WORDS[text]
    try:
        return float(text)
    except ValueError as error:
        raise ProblemError(f"{path}, line {line}, column {name}: {cell[:40]!r} is no number") from error
