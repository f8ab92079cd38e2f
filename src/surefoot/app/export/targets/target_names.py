"""The targets by name."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from surefoot.app.export.sequence import ContactSequence
from surefoot.base.errors import ProblemError, writing
from surefoot.base.lazy_table import LazyTable
from surefoot.base.text_files import path_of

Target = Callable[[ContactSequence], dict[str, str]]
"""Takes a sequence, returns names of files and their texts; a ProblemError where it cannot express it."""
TARGETS: LazyTable[Target] = LazyTable(
    "target",
    {
        "ocs2": "surefoot.app.export.targets.ocs2:files",
        "crocoddyl": "surefoot.app.export.targets.crocoddyl:files",
        "tsid": "surefoot.app.export.targets.tsid:files",
        "casadi": "surefoot.app.export.targets.casadi:files",
        "drake": "surefoot.app.export.targets.drake:files",
        "isaaclab": "surefoot.app.export.targets.isaaclab:files",
    },
)
"""Name to the function that writes a target's files."""


def find_target(name: str) -> Target:
    """Return what writes the files of a target.

    Raises
    ------
    ProblemError
        For an unknown name.
    """
    return TARGETS.load(name)


def export_sequence(sequence: ContactSequence, target: str, folder: Path | str) -> list[Path]:
    """Write a sequence for another tool into a folder and return the paths of the new files.

    Raises
    ------
    ProblemError
        For an unknown target, a sequence that it cannot express, and files that exist: nothing is
        overwritten.
    WriteError
        If a file cannot be written.
    """
    texts = find_target(target)(sequence)
    where = path_of(folder)
    taken = [name for name in texts if (where / name).exists()]
    if taken:
        raise ProblemError(f"{where / taken[0]} exists already")
    out = []
    for name, text in texts.items():
        with writing(where / name):
            where.mkdir(parents=True, exist_ok=True)
            (where / name).write_text(text, encoding="utf-8")
        out.append(where / name)
    return out
