"""The commands by name, each imported when it is called: a list of them all needs one line of each."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from functools import cache
from typing import Annotated, Any, cast

import typer
from typer.core import TyperGroup

from surefoot import __version__
from surefoot.cli.typer_command import LiteralHelpCommand, ungrouped

UsageError = cast("type[typer.BadParameter]", typer.BadParameter.__bases__[0])
"""Click's class for wrong usage, whether Typer brings Click along or depends on it."""
SUMMARIES = {
    "stand": "Let a robot stand in simulation and account for every contact force.",
    "walk": "Let a robot walk in simulation and account for every contact force.",
    "cone": "Print the half-spaces, the rays and the exact fit errors of a friction pyramid, and draw it.",
    "check": "Tell whether a stance can hold its robot at rest. "
    "Exit code 0 possible, 1 impossible, 2 bad input.",
    "region": "Draw where the centre of mass and the zero-moment point may be, "
    "and say where they differ and why.",
    "model": "Print masses, joints and limits, feet, ranks of the contact Jacobian and "
    "the centroidal inertia.",
    "solve": "Solve the problems in files, contacts or LCPs, and print a certificate for each.",
    "translate": "Print a contact's parameters as another simulator takes them, what agrees "
    "and what is lost.",
    "identify": "Fit a body, a contact law and the ground to tosses, or a leg's joints to a force sensor.",
    "sweep": "Run an experiment over samples of ranges, write a Parquet table, and draw what survives.",
    "audit": "Tell which law of contact a log broke, when, where, and what the likely cause is.",
    "worlds": "Run the same experiments in every world that is here and hold them against closed forms.",
    "plan": "Plan a motion through contact that obeys the laws, and carry it out if asked to.",
    "policy": "Print what is understood of a learned policy, from where, and what is missing.",
    "export": "Write the contacts of a log, a plan or a sequence for other tools: data, "
    "and scripts that hold it.",
    "warmup": "Compile everything that the commands need, once per machine, and say where it is kept.",
    "doctor": "Say what of Surefoot works on this machine, and what would make the rest work.",
    "lab": "Open a page in a browser: a stance, a cone, a robot to push, a plan, a log; Ctrl-C ends it.",
    "drive": "Stand a robot up over DDS, walk it, stop it and sit it down; Ctrl-C damps it.",
    "robot": "Be a robot on the wire: MuJoCo behind Unitree's topics, with noisy sensors, motors' limits, "
    "a delay.",
    "bench": "Measure Surefoot against its rivals in the same run.",
}
"""Command to the first paragraph of its help (a test compares them)."""
HELP = {"help_option_names": ["--help", "-h"]}


def load(name: str) -> Any:
    """Import a command and return it, as Typer makes it."""
    module = importlib.import_module(f"surefoot.cli.{name}")
    if name == "bench":
        return typer.main.get_command(module.app)
    one = typer.Typer(add_completion=False)
    one.command(name, cls=LiteralHelpCommand, context_settings=HELP)(ungrouped(getattr(module, name)))
    return typer.main.get_command(one)


class LazyGroup(TyperGroup):
    """A group that lists commands by their summaries and imports the one that is called."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings)
        for name, summary in SUMMARIES.items():
            self.add_command(LiteralHelpCommand(name, help=summary))

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return the command that is called, and its arguments."""
        if args and args[0] in SUMMARIES:
            self.add_command(load(args[0]), args[0])
        return super().resolve_command(ctx, args)


app = typer.Typer(
    name="surefoot",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    cls=LazyGroup,
    context_settings=HELP,
)


def _print_version(wanted: bool) -> None:
    if wanted:
        print(f"surefoot {__version__}")
        raise typer.Exit


@app.callback()
def surefoot(
    version: Annotated[
        bool,
        typer.Option("--version", help="Print the version and exit.", callback=_print_version, is_eager=True),
    ] = False,
) -> None:
    """Constrain, solve and check the contact forces of legged robots."""


@cache
def tree() -> Callable[..., object]:
    """Return the tree of commands, put together once a process."""
    return cast("Callable[..., object]", typer.main.get_command(app))
