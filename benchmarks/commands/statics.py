"""`surefoot bench statics`: verdicts and speed against SciPy's HiGHS, Clarabel and cddlib."""

from __future__ import annotations

from dataclasses import asdict
from typing import Annotated

import typer
from rich.table import Table

from surefoot.cli import extras, parsing
from surefoot.cli.console import plain_console
from surefoot.cli.output import to_json


def statics(
    cases: Annotated[int, typer.Option(min=6, help="Random stances whose verdicts are compared.")] = 5000,
    calls: Annotated[int, typer.Option(min=20, help="Instances that are timed.")] = 300,
    seed: Annotated[int, typer.Option(help="Seed of the random stances.")] = 0,
    quick: Annotated[bool, typer.Option("--quick", help="Sixty stances, twenty calls.")] = False,
    json: Annotated[bool, typer.Option("--json", help="Print JSON and nothing else.")] = False,
) -> int:
    """Compare verdicts on random stances, then time each question on the same instances.

    Exit code 1 if a verdict disagrees outside the band around the boundary or does not verify.
    """
    from benchmarks.statics.race import BAND, agreement, races, random_cases

    extras.require(["clarabel"])
    parsing.seed(seed)
    if quick:
        cases, calls = min(cases, 60), min(calls, 20)
    questions = random_cases(cases, seed)
    checks = [agreement(questions), agreement(questions, facets=8)]
    timed = races(calls, seed + 1)
    good = all(c.disagreed == 0 and c.verified == c.cases for c in checks)
    if json:
        speed = [{**asdict(r), "timing": asdict(r.timing)} for r in timed]
        print(to_json({"agreement": [asdict(c) for c in checks], "speed": speed}))
        return 0 if good else 1
    console = plain_console()
    table = Table(title=f"Verdicts on {cases} random stances, 2 to 12 contacts", title_justify="left")
    for name in ("against", "possible", "agree", f"differ within {BAND:g} of the load", "differ", "verified"):
        table.add_column(name, justify="left" if name == "against" else "right")
    for c in checks:
        row = (c.possible, c.agreed, c.in_band, c.disagreed, c.verified)
        table.add_row(c.rival, *(str(n) for n in row))
    console.print(table)
    table = Table(title="Time per call on one core", title_justify="left")
    for name in ("question", "who", "median [µs]", "99 % [µs]", "ratio"):
        table.add_column(name, justify="right" if "[" in name or name == "ratio" else "left")
    last = ""
    for r in timed:
        t = r.timing
        table.add_row(
            "" if r.question == last else r.question,
            r.who,
            f"{1e6 * t.median:.1f}",
            f"{1e6 * t.p99:.1f}",
            f"{r.ratio:.2f}",
        )
        last = r.question
    console.print(table)
    return 0 if good else 1
