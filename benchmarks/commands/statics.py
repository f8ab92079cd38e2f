"""`surefoot bench statics`: verdicts and speed against SciPy's HiGHS, Clarabel and cddlib."""

from __future__ import annotations

from dataclasses import asdict
from typing import Annotated

import typer
from rich.console import Console

from benchmarks.printing import report, table
from surefoot.app.cli import extras, parsing


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
    from benchmarks.problems.stances import random_cases
    from benchmarks.statics.race import BAND, agreement, races

    extras.require(["clarabel"])
    parsing.seed(seed)
    if quick:
        cases, calls = min(cases, 60), min(calls, 20)
    questions = random_cases(cases, seed)
    checks = [agreement(questions), agreement(questions, facets=8)]
    timed = races(calls, seed + 1)
    good = all(c.disagreed == 0 and c.verified == c.cases for c in checks)

    def in_words(console: Console) -> None:
        names = (
            "against", "possible", "agree", f"differ within {BAND:g} of the load", "differ", "verified",
        )  # fmt: skip
        counts = ((c.possible, c.agreed, c.in_band, c.disagreed, c.verified) for c in checks)
        rows = [(c.rival, *map(str, own)) for c, own in zip(checks, counts, strict=True)]
        console.print(table(names, rows, f"Verdicts on {cases} random stances, 2 to 12 contacts"))
        firsts = {r.question: r.who for r in reversed(timed)}
        times = [
            (
                r.question if r.who == firsts[r.question] else "", r.who, f"{1e6 * r.timing.median:.1f}",
                f"{1e6 * r.timing.p99:.1f}", f"{r.ratio:.2f}",
            )
            for r in timed
        ]  # fmt: skip
        heads = ("question", "who", "median [µs]", "99 % [µs]", "ratio")
        console.print(table(heads, times, "Time per call on one core", left=2))

    report({"agreement": [asdict(c) for c in checks], "speed": [asdict(r) for r in timed]}, json, in_words)
    return 0 if good else 1
