"""`surefoot bench batch`: many contact problems and their gradients, and the derivative of a step."""

from __future__ import annotations

from typing import Annotated

import typer
from rich.table import Table

from surefoot.cli import extras
from surefoot.cli.console import plain_console
from surefoot.cli.output import to_json


def batch(
    quick: Annotated[bool, typer.Option("--quick", help="Fewer problems and repeats.")] = False,
    json: Annotated[bool, typer.Option("--json", help="Print JSON only.")] = False,
) -> None:
    """Contact problems and gradients a second, against Pinocchio, JAX and MuJoCo, with their accuracy."""
    from benchmarks.batch import measure

    extras.require((*extras.robot_packages("go2"), "mujoco"))
    found = measure(quick)
    if json:
        print(to_json(found))
        return
    console = plain_console()
    console.print(f"{found['problems']} problems of Go2 on four feet, modes {found['modes']}")
    table = Table("", "µs", "million/s", title="cold starts, tolerance 1e-8")
    for name, seconds in found["times"].items():
        table.add_row(name, f"{1e6 * seconds:.2f}", f"{1e-6 / seconds:.3f}")
    console.print(table)
    for what in ("velocity_error", "gradient_error"):
        errors = ", ".join(f"{name} {error:.1e}" for name, error in found[what].items())
        console.print(f"largest relative {what.replace('_', ' ')}: {errors}")
    mjx = found["mjx"]
    if mjx is None:
        console.print("MJX is not here: pip install 'surefoot[mjx]'", markup=False)
    else:
        console.print(
            f"MJX, a box on four contacts in a batch: a step {1e6 * mjx['step']:.0f} µs, with its Jacobian "
            f"{1e6 * mjx['both']:.0f} µs; into the ground at {mjx['inward']:.2g} m/s after it; its Jacobian "
            f"is off by {mjx['error']:.1e}, {mjx['nan']} with NaN, {mjx['zero']} zero"
        )
    table = Table("", "µs", title="a step of Go2 on four feet and its derivative")
    for name, seconds in found["step"].items():
        table.add_row(name, f"{1e6 * seconds:.0f}")
    console.print(table)
    console.print(f"MuJoCo / Surefoot, derivative with its step: {found['step_ratio']:.2f}")
    rates = ", ".join(f"{workers} workers {rate:.0f}" for workers, rate in found["robots"].items())
    console.print(f"RigidBatch of Go2, steps a second: {rates}")
