"""`surefoot export`: the contacts of a log, a plan or a sequence, as other tools read them."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from surefoot.app.cli import options
from surefoot.app.cli.console import say, show
from surefoot.app.cli.output import new_run_folder
from surefoot.base.errors import check_name

SEQUENCE = "sequence"


def export(
    source: Annotated[Path, typer.Argument(help="A contact sequence (.json), or a log or plan.")],
    to: Annotated[
        list[str] | None,
        typer.Option(help="sequence, ocs2, crocoddyl, tsid, casadi, drake, isaaclab; repeatable."),
    ] = None,
    facets: Annotated[
        int | None, typer.Option(help="Sides of the pyramids; None for the file's, or 8.")
    ] = None,
    out: Annotated[Path, typer.Option(help="Parent of the new folder.")] = Path("runs"),
    as_json: options.AsJson = False,
) -> int:
    """Write the contacts of a log, a plan or a sequence for other tools: data, and scripts that hold it.

    Exit code 0 if every file is written, 2 for wrong input.
    """
    from surefoot.app.export import TARGETS, export_sequence, write_sequence
    from surefoot.app.export.targets.target_names import find_target

    targets = dict.fromkeys(to or [SEQUENCE])
    for name in targets:
        check_name("target of --to", name, (SEQUENCE, *TARGETS))
    sequence = _read(source, facets)
    for name in targets.keys() - {SEQUENCE}:  # refused before a folder is made
        find_target(name)(sequence)
    folder = new_run_folder(out, f"export-{source.stem}")
    paths: list[Path] = []
    for name in targets:
        if name == SEQUENCE:
            paths.append(write_sequence(sequence, folder / "contacts.json"))
        else:
            paths += export_sequence(sequence, name, folder)
    facts = {
        "robot": sequence.robot,
        "frames": list(sequence.frames),
        "duration": sequence.duration,
        "phases": [{"duration": p.duration, "contacts": list(p.names)} for p in sequence.phases],
        "files": [str(path) for path in paths],
    }
    show(facts, as_json, _print)
    return 0


def _read(source: Path, facets: int | None) -> Any:
    """Return the sequence of a file."""
    from dataclasses import replace

    from surefoot.app.export import read_sequence, sequence_from_log
    from surefoot.records import read_log

    if source.suffix == ".json":
        sequence = read_sequence(source)
        return sequence if facets is None else replace(sequence, facets=facets)
    return sequence_from_log(read_log(source), facets or 8)


def _print(console: Console, facts: dict[str, Any]) -> None:
    size = f"{len(facts['phases'])} phases, {len(facts['frames'])} frames, {facts['duration']:.3f} s"
    say(console, size, *facts["files"])
