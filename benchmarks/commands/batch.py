"""`surefoot bench batch`: many contact problems and their gradients."""

from __future__ import annotations

from typing import Annotated, Any

import typer
from rich.console import Console

from benchmarks.printing import table
from surefoot.app.cli import extras
from surefoot.app.cli.console import show


def batch(
    quick: Annotated[bool, typer.Option("--quick", help="Fewer problems and repeats.")] = False,
    json: Annotated[bool, typer.Option("--json", help="Print JSON only.")] = False,
) -> None:
    """Contact problems and gradients a second, against Pinocchio and JAX, with their accuracy."""
    from benchmarks.batch import measure

    extras.require(extras.robot_packages("go2"))
    show(measure(quick), json, _print)


def _print(console: Console, found: dict[str, Any]) -> None:
    console.print(f"{found['problems']} problems of Go2 on four feet")
    rates = [(name, f"{1e6 * s:.2f}", f"{1e-6 / s:.3f}") for name, s in found["times"].items()]
    console.print(table(("", "µs", "million/s"), rates, "cold starts, tolerance 1e-8"))
    for what in ("velocity_error", "gradient_error"):
        errors = ", ".join(f"{name} {error:.1e}" for name, error in found[what].items())
        console.print(f"largest relative {what.replace('_', ' ')}: {errors}")
