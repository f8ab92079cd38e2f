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
from surefoot.cli.literal_help import LiteralHelpCommand

app = typer.Typer(help="Measure Surefoot against its rivals in the same run.", no_args_is_help=True)


@app.callback()
def bench() -> None:
    """Measure Surefoot against its rivals in the same run."""


for _command in (
    bench_momentum.momentum, bench_statics.statics, bench_walk.walk, bench_faults.faults,
    bench_contact.contact, bench_rigid.rigid, bench_forces.forces,
):  # fmt: skip
    app.command(_command.__name__, cls=LiteralHelpCommand)(_command)
