"""`surefoot bench ...`: one sub-command per benchmark; each prints a ratio to rivals of the same run."""

from __future__ import annotations

import typer

from benchmarks.commands import (
    ablation,
    audit,
    batch,
    certify,
    contact,
    execution,
    faults,
    forces,
    plan,
    rigid,
    robots,
    softening,
    soles,
    speeds,
    stacks,
    statics,
    walk,
    wire,
)
from surefoot.app.cli.typer_command import LiteralHelpCommand

app = typer.Typer(help="Measure Surefoot against its rivals in the same run.", no_args_is_help=True)


@app.callback()
def bench() -> None:
    """Measure Surefoot against its rivals in the same run."""


for _command in (
    statics.statics, walk.walk, faults.faults, contact.contact, rigid.rigid, forces.forces,
    batch.batch, plan.plan, softening.softening, execution.execution,
    stacks.stacks, certify.certify, speeds.speeds, wire.wire, ablation.ablation, audit.audit, soles.soles,
    robots.robots,
):  # fmt: skip
    app.command(_command.__name__, cls=LiteralHelpCommand)(_command)
