"""The columns of a sweep's table."""

from __future__ import annotations

from typing import Any

from surefoot import __version__
from surefoot.errors import MissingExtra, ProblemError
from surefoot.sweep.config import SweepConfig

MARK = b"surefoot.sweep"
"""Key of the fingerprint in a file's metadata ..."""
MADE_BY = b"surefoot.version"
"""... and of the version that its rows were made by."""


def import_pyarrow() -> Any:
    """Return pyarrow, with its Parquet part loaded.

    Raises
    ------
    MissingExtra
        If it is not installed.
    """
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError as error:
        raise MissingExtra("pyarrow", "sweep") from error
    return pyarrow


def schema(config: SweepConfig) -> Any:
    """Return the Arrow schema of a sweep's rows.

    index; a column for each parameter; status ("done", "error", "crashed") and error; a column for each
    result, null where the sample is not done; wall_time [s].

    Raises
    ------
    ProblemError
        If an experiment's result has the name of another column.
    """
    pyarrow = import_pyarrow()
    types = {"float": pyarrow.float64(), "bool": pyarrow.bool_(), "text": pyarrow.string()}
    columns = [
        ("index", pyarrow.int64()),
        *((name, types[config.space.kind(name)]) for name in config.space.names),
        ("status", pyarrow.string()),
        ("error", pyarrow.string()),
        *((name, types[kind]) for name, kind in config.experiment.columns.items()),
        ("wall_time", pyarrow.float64()),
    ]
    names = [name for name, _ in columns]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise ProblemError(
            f"experiment {config.name} has a result named as another column: {', '.join(twice)}"
        )
    marks = {MARK: config.fingerprint().encode(), MADE_BY: __version__.encode()}
    return pyarrow.schema(columns, metadata=marks)
