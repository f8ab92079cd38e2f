"""`surefoot bench softening`: ways to soften complementarity, on five small problems."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console
from rich.table import Table

from benchmarks.printing import report
from surefoot.app.cli import extras
from surefoot.app.cli.console import plain_console
from surefoot.base.errors import ProblemError, unknown_name

if TYPE_CHECKING:
    from benchmarks.softening.race import Row

QUICK_MOST = 500
"""Most iterations of a start of --quick, over all stages."""
WIDTH = 118
"""Columns that the tables need; a narrower terminal wraps their lines."""
TITLES = {
    "race": "every form on the same path: a b = 0.1 to 1e-13, from the same starts",
    "causes": "one thing changed at a time",
    "first": "the first smoothing",
    "recommended": "the direct method: relaxed to 1e-8, then the modes held",
}


def softening(
    starts: Annotated[int, typer.Option(min=1, help="Random starts of every form on every problem.")] = 10,
    few: Annotated[int, typer.Option(min=1, help="Random starts in the search for causes.")] = 5,
    problem: Annotated[list[str] | None, typer.Option(help="Only this problem; may be repeated.")] = None,
    table: Annotated[list[str] | None, typer.Option(help="Only this table; may be repeated.")] = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="The ball alone, one start, few iterations.")
    ] = False,
    json: Annotated[bool, typer.Option("--json", help="Print JSON only.")] = False,
) -> None:
    """Compare relaxation, barrier, Fischer-Burmeister and others on a ball, a point, a hopper, a push."""
    from benchmarks.softening import race
    from surefoot.motion.planning.direct.textbook import PROBLEMS

    extras.require(["casadi"])
    problems = _among("problem", problem, list(PROBLEMS))
    sets = {"race": race.RACE, "recommended": (race.RECOMMENDED,), "causes": race.CAUSES, "first": race.FIRST}
    if quick:
        starts, few = 1, 1
        problems = [name for name in problems if name == "ball"] if problem is None else problems
        sets = {name: tuple(race.limited(one, QUICK_MOST) for one in ways) for name, ways in sets.items()}
    found: dict[str, list[Row]] = {}
    with plain_console(stderr=True).status("softening") as status:
        for name in _among("table", table, list(sets)):
            count = few if name in ("causes", "first") else starts
            found[name] = [row for row, _ in race.run(sets[name], problems, count, status.update)]

    def in_words(console: Console) -> None:
        for name, rows in found.items():
            _print(console, TITLES[name], rows)

    record = {name: [asdict(row) for row in rows] for name, rows in found.items()}
    report(record, json, in_words, WIDTH)


def _among(kind: str, asked: Sequence[str] | None, known: list[str]) -> list[str]:
    """Return what was asked for, all where nothing was."""
    for name in asked or ():
        if name not in known:
            raise ProblemError(unknown_name(kind, name, known))
    return [name for name in known if not asked or name in asked]


def _print(console: Console, title: str, rows: Sequence[Any]) -> None:
    """Print a table: a row per problem and variant."""
    table = Table(
        "problem", "form", "solved", "iterations", "CPU [s]", "max gap·λ", "max |min(a, b)|", "cost", "step",
        "regularised", title=title,
    )  # fmt: skip
    table.columns[1].no_wrap = True
    for column in table.columns[2:]:
        column.justify = "right"
    last = ""
    for row in rows:
        if last and row.problem != last:
            table.add_section()
        table.add_row(
            row.problem if row.problem != last else "",
            row.variant,
            f"{row.solved}/{row.starts}",
            f"{row.iterations:.0f}",
            f"{row.seconds:.2f}",
            f"{row.product:.0e}",
            f"{row.complementarity:.0e}",
            "-" if row.cost != row.cost else f"{row.cost:.3f}",
            f"{row.step:.2f}",
            f"{100.0 * row.regularised:.0f} %",
        )
        last = row.problem
    console.print(table)
