"""The targets by name."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from pkgutil import resolve_name

from surefoot.app.export.sequence import ContactSequence
from surefoot.base.errors import ProblemError, check_name, writing
from surefoot.base.text_files import path_of

Target = Callable[[ContactSequence], dict[str, str]]
"""Takes a sequence, returns names of files and their texts; a ProblemError where it cannot express it."""
TARGETS: dict[str, str] = {
    name: f"surefoot.app.export.targets.{name}:files"
    for name in ("ocs2", "crocoddyl", "tsid", "casadi", "drake", "isaaclab")
}
"""Name to "module:function"."""


def find_target(name: str) -> Target:
    """Return what writes the files of a target.

    Raises
    ------
    ProblemError
        For an unknown name.
    """
    check_name("target", name, TARGETS)
    target: Target = resolve_name(TARGETS[name])
    return target


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
