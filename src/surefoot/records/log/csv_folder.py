"""A folder of CSV files that are columns of one table: a file a sensor, all with the same rows."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError
from surefoot.records.log import csv_file
from surefoot.records.log.source import Source, Topic

SUFFIX = ".csv"


def is_folder(path: Path) -> bool:
    """Return whether a folder holds CSV files."""
    return path.is_dir() and any(file.suffix.lower() == SUFFIX for file in path.iterdir())


def source(path: Path) -> Source:
    """Return the files of a folder as one table.

    A column of the same name and numbers in every file, as their time, is there once; another name that two
    files share gets that of the file before it.

    Raises
    ------
    ProblemError
        For files with other numbers of rows, and what `csv_file.source` does not read.
    """
    files = sorted(file for file in path.iterdir() if file.suffix.lower() == SUFFIX)
    tables = {file: csv_file.source(file).topics[""].fields for file in files}
    rows = {file: len(next(iter(fields.values()))) for file, fields in tables.items()}
    if len(set(rows.values())) > 1:
        counts = ", ".join(f"{file.name} {count}" for file, count in rows.items())
        raise ProblemError(f"{path}: its CSV files are no columns of one table, their rows are {counts}")
    columns: dict[str, FloatArray] = {}
    for file, fields in tables.items():
        for name, numbers in fields.items():
            if name not in columns:
                columns[name] = numbers
            elif not np.array_equal(columns[name], numbers, equal_nan=True):
                columns[f"{file.stem}.{name}"] = numbers
    return Source({"": Topic(None, columns)})
