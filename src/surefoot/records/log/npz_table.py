"""Archives of arrays (.npz) that somebody's own loop wrote: tables whose columns may have many numbers."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from surefoot.base.errors import ProblemError
from surefoot.base.npz_files import check_archive
from surefoot.records.log.facts import FACTS
from surefoot.records.log.source import Source, Topic, check_size

SCHEMA = "schema"
"""Array that logs of Surefoot's own have."""


def is_foreign(path: Path) -> bool:
    """Return whether a file is an archive of arrays that is no log of Surefoot's own."""
    try:
        with path.open("rb") as opened, np.load(opened, allow_pickle=False) as file:
            return isinstance(file, np.lib.npyio.NpzFile) and SCHEMA not in file.files
    except Exception:  # cut, no archive, not there: the reader of logs says which
        return False


def source(path: Path) -> Source:
    """Return the arrays of an archive that have as many rows as most of them; single numbers are facts.

    Raises
    ------
    ProblemError
        For an archive that is empty, too large, or holds no array of numbers over time.
    """
    check_size(path.stat().st_size, path)
    check_archive(path, path)
    notes: list[str] = []
    arrays: dict[str, Any] = {}
    with path.open("rb") as opened, np.load(opened, allow_pickle=False) as file:
        for name in file.files:
            try:
                arrays[name] = file[name]
            except ValueError:  # pickled objects, which are not loaded
                notes.append(
                    f"the array {name} holds pickled Python objects, which are not loaded: save numbers, "
                    f"np.savez(path, {name}=np.asarray({name}, dtype=float))"
                )
    numbers = {name: array for name, array in arrays.items() if array.dtype.kind in "biuf"}
    notes += [f"{name} holds no numbers: left out" for name in arrays if name not in numbers]
    rows = Counter(len(array) for array in numbers.values() if array.ndim)
    if not rows:
        raise ProblemError("; ".join(["it holds no array of numbers over time", *notes]))
    count = max(rows, key=lambda length: (rows[length], length))
    fields = {
        name: array.astype(np.float64)
        for name, array in numbers.items()
        if array.ndim and len(array) == count
    }
    others = [
        f"{name} {numbers[name].shape}" for name in numbers if name not in fields and numbers[name].ndim
    ]
    if others:
        notes.append(f"left out, since most arrays have {count} rows: {', '.join(others)}")
    single = {name: array.item() for name, array in numbers.items() if not array.ndim}
    facts = {name: value for name, value in single.items() if name in FACTS or name == "mu"}
    return Source({"": Topic(None, fields, kind=KIND)}, notes, facts=facts)


KIND = "arrays"
"""Kind of the one topic that such a table is."""
