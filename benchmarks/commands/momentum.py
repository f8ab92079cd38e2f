"""`surefoot bench momentum`: the centroidal momentum matrix three ways, against the number of links."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from benchmarks.printing import table
from surefoot.cli import extras
from surefoot.cli.console import show
from surefoot.cli.output import check_out, new_run_folder

if TYPE_CHECKING:
    from benchmarks.momentum import MomentumTiming


def momentum(
    out: Annotated[Path | None, typer.Option(help="Write a picture to a new folder below this one.")] = None,
    longest: Annotated[int, typer.Option(min=20, help="Links of the longest chain.")] = 1000,
    quick: Annotated[bool, typer.Option("--quick", help="Chains of up to 20 links.")] = False,
    json: Annotated[bool, typer.Option("--json", help="Print JSON only.")] = False,
) -> None:
    """Time the momentum matrix of chains of 10 to 1000 links: Pinocchio, our CCRBA, brute force."""
    from benchmarks.momentum import LINKS, WAYS, time_momentum

    check_out(out)
    extras.require(["pin"], ["matplotlib"] if out is not None else [])
    longest = 20 if quick else longest
    timing = time_momentum([n for n in LINKS if n < longest] + [longest], *([0.02] if quick else []))
    growth = {way: timing.growth(way) for way in WAYS}
    show(asdict(timing) | {"growth": growth}, json, lambda console, _: _print(console, timing, growth))
    if out is not None:
        from surefoot.viz.momentum_plots import plot_timing

        path = new_run_folder(out, "bench-momentum") / "momentum-timing.png"
        plot_timing(path, timing.links, timing.seconds, growth)
        typer.echo(f"picture: {path}", err=True)


def _print(console: Console, timing: MomentumTiming, growth: dict[str, float]) -> None:
    from benchmarks.momentum import PINOCCHIO_LINKS, WAYS

    names = ("links", *(f"{way} [µs]" for way in WAYS), "summed / composite")
    rows = []
    for k, count in enumerate(timing.links):
        times = [timing.seconds[way][k] for way in WAYS]
        numbers = ("-" if t != t else f"{1e6 * t:.1f}" for t in times)
        rows.append((str(count), *numbers, f"{times[2] / times[1]:.2f}"))
    rows.append(("grows as", *(f"n^{growth[way]:.2f}" for way in WAYS), ""))
    console.print(table(names, rows, "A_G of a chain"))
    console.print(f"Pinocchio stops at {PINOCCHIO_LINKS} links: its Data takes memory like n^3")
    console.print(f"largest relative difference between the three: {timing.disagreement:.1e}")
