"""`surefoot bench momentum`: the centroidal momentum matrix three ways, against the number of links."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from surefoot.cli import extras
from surefoot.cli.console import plain_console
from surefoot.cli.output import check_out, new_run_folder, to_json


def momentum(
    out: Annotated[Path | None, typer.Option(help="Write a picture to a new folder below this one.")] = None,
    longest: Annotated[int, typer.Option(min=20, help="Links of the longest chain.")] = 1000,
    quick: Annotated[bool, typer.Option("--quick", help="Chains of up to 20 links.")] = False,
    json: Annotated[bool, typer.Option("--json", help="Print JSON only.")] = False,
) -> None:
    """Time the momentum matrix of chains of 10 to 1000 links: Pinocchio, our CCRBA, brute force."""
    from benchmarks.momentum import LINKS, PINOCCHIO_LINKS, WAYS, time_momentum

    check_out(out)
    extras.require(["pin"], ["matplotlib"] if out is not None else [])
    longest = 20 if quick else longest
    timing = time_momentum([n for n in LINKS if n < longest] + [longest], *([0.02] if quick else []))
    if json:
        print(
            to_json(
                {
                    "links": timing.links,
                    "seconds": timing.seconds,
                    "growth": {way: timing.growth(way) for way in WAYS},
                    "disagreement": timing.disagreement,
                }
            )
        )
    else:
        console = plain_console()
        table = Table("links", *(f"{way} [µs]" for way in WAYS), "summed / composite", title="A_G of a chain")
        for k, count in enumerate(timing.links):
            times = [timing.seconds[way][k] for way in WAYS]
            table.add_row(
                str(count),
                *("-" if t != t else f"{1e6 * t:.1f}" for t in times),
                f"{times[2] / times[1]:.2f}",
            )
        table.add_row("grows as", *(f"n^{timing.growth(way):.2f}" for way in WAYS), "")
        console.print(table)
        console.print(f"Pinocchio stops at {PINOCCHIO_LINKS} links: its Data takes memory like n^3")
        console.print(f"largest relative difference between the three: {timing.disagreement:.1e}")
    if out is not None:
        from surefoot.viz.momentum_plots import plot_timing

        path = new_run_folder(out, "bench-momentum") / "momentum-timing.png"
        plot_timing(path, timing.links, timing.seconds, {way: timing.growth(way) for way in WAYS})
        typer.echo(f"picture: {path}", err=True)
