"""`surefoot bench soles`: the exact cone of a sole against Clarabel and 50 digits, and its speed."""

from __future__ import annotations

from dataclasses import asdict
from typing import Annotated

import typer
from rich.console import Console

from benchmarks.printing import report, table
from surefoot.app.cli import extras, parsing


def soles(
    soles: Annotated[int, typer.Option(min=1, help="Soles, every other a rectangle.")] = 20,
    wrenches: Annotated[int, typer.Option(min=30, help="Random wrenches of each sole.")] = 10_000,
    calls: Annotated[int, typer.Option(min=100, help="Wrenches that are timed in one batch.")] = 1_000_000,
    seed: Annotated[int, typer.Option(help="Seed of soles and wrenches.")] = 0,
    quick: Annotated[bool, typer.Option("--quick", help="Two soles, sixty wrenches.")] = False,
    json: Annotated[bool, typer.Option("--json", help="Print JSON and nothing else.")] = False,
) -> int:
    """Compare answers about soles with Clarabel on their corner forces, then time the questions.

    A third of the wrenches are drawn near the border; those nearer than 1e-7 of their size are settled in 50
    digits. Exit code 1 if an answer differs farther from the border, or a pyramid errs on its wrong side.
    """
    from benchmarks.soles.agreement import NEAR, agreement
    from benchmarks.soles.race import races

    extras.require(["clarabel"])
    parsing.seed(seed)
    if quick:
        soles, wrenches, calls = 2, 60, 1000
    found = agreement(soles, wrenches, seed)
    timed = races(calls, seed)
    good = all(a["differ"] == 0 for a in found["answers"])
    good = good and all(p["wrongly"] == 0 for p in found["pyramids"].values())

    def in_words(console: Console) -> None:
        heads = (
            "question", "wrenches", "held", "differ", f"nearer than {NEAR:g}", "of them differ",
            "farthest that differs",
        )  # fmt: skip
        rows = [
            (
                a["question"].replace("`", ""), str(a["wrenches"]), str(a["inside"]), str(a["differ"]),
                str(a["settled"]), str(a["differ_near"]), f"{a['worst']:.1e}",
            )
            for a in found["answers"]
        ]  # fmt: skip
        console.print(table(heads, rows, f"Answers about {soles} soles against Clarabel and 50 digits"))
        console.print(f"largest error of a margin, over the wrench's size: {found['margin_error']:.1e}")
        for fit, p in found["pyramids"].items():
            console.print(
                f"8 facets, {fit}: {p['promised']} said to be held, {p['held']} are, {p['wrongly']} wrongly"
            )
        times = [(c.question, c.who, f"{1e6 * c.seconds:.2f}", f"{c.ratio:.2f}") for c in timed]
        console.print(
            table(("question", "who", "time [µs]", "ratio"), times, "Processor time on one core", left=2)
        )

    report(found | {"speed": [asdict(c) for c in timed]}, json, in_words)
    return 0 if good else 1
