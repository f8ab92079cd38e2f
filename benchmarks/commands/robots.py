"""`surefoot bench robots`: which robots walk, stand or are refused, and how their feet are read."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from benchmarks.printing import report, table
from surefoot.app.cli import extras

WIDTH = 160
"""Columns that reasons need."""


def robots(
    published: Annotated[
        Path | None, typer.Option(help="Folder of clones, OWNER+NAME, whose robots are tried instead.")
    ] = None,
    only: Annotated[list[str] | None, typer.Option(help="Only this robot; may be repeated.")] = None,
    duration: Annotated[float, typer.Option(min=1.0, help="Length of a walk [s].")] = 4.0,
    pictures: Annotated[Path | None, typer.Option(help="Draw the feet into this folder instead.")] = None,
    quick: Annotated[bool, typer.Option("--quick", help="One robot for a second.")] = False,
    json: Annotated[bool, typer.Option("--json", help="Print JSON and nothing else.")] = False,
) -> int:
    """Let all robots of the catalogue walk at 0.3 m/s in MuJoCo, and those that do not stand.

    Each is asked for on the command line, so that what it says is what a user reads. With --published the
    robots of other repositories, and their lint. Exit code 1 if a command crashed or hung.
    """
    from benchmarks.robots.trial import Candidate, attempt, clock
    from benchmarks.robots.trial import published as listed
    from surefoot.base.errors import ModelError, check_name
    from surefoot.mechanics import robot_names

    extras.require(["mujoco", "pinocchio"])
    chosen = [Candidate(n, n) for n in robot_names()] if published is None else listed(published)
    for name in only or ():
        check_name("--only", name, [one.name for one in chosen])
    chosen = [one for one in chosen if not only or one.name in only]
    if quick:
        chosen, duration = chosen[:1], 1.0
    if pictures is not None:
        from benchmarks.robots.drawings import draw_foot

        pictures.mkdir(parents=True, exist_ok=True)
        for one in chosen:
            try:
                typer.echo(draw_foot(one, pictures))
            except ModelError as error:
                typer.echo(f"{one.name}: {error}")
        return 0
    trials = []
    for one in chosen:
        typer.echo(f"{clock()} {one.name}", err=True)
        trials.append(attempt(one, duration, lint=published is not None))

    def in_words(console: Console) -> None:
        heads = ("robot", "feet", "walk", "stand", "lint")
        rows = [
            (t.name, t.feet, t.walk, t.stand, "" if t.errors is None else str(sum(t.errors.values())))
            for t in trials
        ]
        console.print(table(heads, rows, "Robots that nobody tuned", left=4))

    report({"trials": [asdict(t) for t in trials]}, json, in_words, WIDTH)
    return 0 if all(t.code in (0, 1, 2) for t in trials) else 1
