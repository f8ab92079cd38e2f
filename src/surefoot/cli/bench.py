"""`surefoot bench ...`: one sub-command per benchmark; each prints a ratio to rivals of the same run."""

from __future__ import annotations

import typer

from surefoot.cli import (
    bench_contact,
    bench_faults,
    bench_forces,
    bench_momentum,
    bench_rigid,
    bench_statics,
    bench_walk,
)

app = typer.Typer(help="Measure Surefoot against its rivals in the same run.", no_args_is_help=True)


@app.callback()
def bench() -> None:
    """Measure Surefoot against its rivals in the same run."""


app.command("momentum")(bench_momentum.momentum)
app.command("statics")(bench_statics.statics)
app.command("walk")(bench_walk.walk)
app.command("faults")(bench_faults.faults)
app.command("contact")(bench_contact.contact)
app.command("rigid")(bench_rigid.rigid)
app.command("forces")(bench_forces.forces)
