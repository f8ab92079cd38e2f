"""`surefoot bench lab`: updates a second of the lab's static pages, without and with a browser."""

from __future__ import annotations

import math
from typing import Annotated

import typer
from rich.console import Console

from benchmarks.printing import table
from surefoot.cli import extras
from surefoot.cli.console import show


def lab(
    seconds: Annotated[float, typer.Option(min=0.5, help="Length of each measurement [s].")] = 5.0,
    quick: Annotated[bool, typer.Option("--quick", help="One second, and no browser.")] = False,
    json: Annotated[bool, typer.Option("--json", help="Print JSON only.")] = False,
) -> int:
    """Count the updates of the pages stand and cone while the mouse moves.

    Exit code 1 if an update, with sending it, takes more than a thirtieth of a second of CPU time.
    """
    extras.require(["viser", "pin", "example-robot-data"])
    from benchmarks.browser import find_chromium
    from benchmarks.lab import WANTED, cases, measure

    program = None if quick else find_chromium()
    found = [measure(case, 1.0 if quick else seconds, program) for case in cases()]

    def in_words(console: Console, _: object) -> None:
        header = (
            "page", "CPU of an update [ms]", "sent [1/s]", "CPU with sending [ms]",
            "by Chromium's mouse [1/s]", "Chromium's pictures [1/s]",
        )  # fmt: skip
        rows = [
            (
                r.name, f"{1e3 * r.computing:.2f}", f"{r.sent:.0f}", f"{1e3 * r.handled:.2f}",
                _number(r.browser), _number(r.frames),
            )
            for r in found
        ]  # fmt: skip
        console.print(table(header, rows, "The mouse moves 60 times a second"))
        if program is None and not quick:
            console.print("no Chromium: set SUREFOOT_CHROMIUM to its path to measure the real page")

    show([vars(rates) for rates in found], json, in_words)
    return 0 if all(rates.handled * WANTED <= 1.0 for rates in found) else 1


def _number(value: float) -> str:
    return "-" if math.isnan(value) else f"{value:.0f}"
