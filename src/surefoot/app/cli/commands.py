"""The commands by name, each imported when it is called: a list of them all needs one paragraph of each."""

from __future__ import annotations

import ast
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Annotated, Any, cast

import typer
from typer.core import TyperGroup

from surefoot import __version__
from surefoot.app.cli.typer_command import LiteralHelpCommand, flatten_parameters
from surefoot.base.errors import near_name
from surefoot.base.lazy_table import LazyTable

UsageError = cast("type[typer.BadParameter]", typer.BadParameter.__bases__[0])
"""Click's class for wrong usage, whether Typer brings Click along or depends on it."""
COMMANDS: LazyTable[Callable[..., int]] = LazyTable(
    "command",
    {
        "stand": "surefoot.app.cli.stand:stand",
        "walk": "surefoot.app.cli.walk:walk",
        "cone": "surefoot.app.cli.cone:cone",
        "check": "surefoot.app.cli.check:check",
        "region": "surefoot.app.cli.region:region",
        "model": "surefoot.app.cli.model:model",
        "lint": "surefoot.app.cli.lint:lint",
        "solve": "surefoot.app.cli.solve:solve",
        "translate": "surefoot.app.cli.translate:translate",
        "identify": "surefoot.app.cli.identify:identify",
        "estimate": "surefoot.app.cli.estimate:estimate",
        "sweep": "surefoot.app.cli.sweep:sweep",
        "audit": "surefoot.app.cli.audit:audit",
        "certify": "surefoot.app.cli.certify:certify",
        "worlds": "surefoot.app.cli.worlds:worlds",
        "plan": "surefoot.app.cli.plan:plan",
        "policy": "surefoot.app.cli.policy:policy",
        "export": "surefoot.app.cli.export:export",
        "examples": "surefoot.app.cli.examples:examples",
        "course": "surefoot.app.cli.course:course",
        "warmup": "surefoot.app.cli.warmup:warmup",
        "doctor": "surefoot.app.cli.doctor:doctor",
        "lab": "surefoot.app.cli.lab:lab",
        "drive": "surefoot.app.cli.drive:drive",
        "robot": "surefoot.app.cli.robot:robot",
        "bench": "surefoot.app.cli.bench:app",
    },
)
"""The commands in the order of the list; each has a file of its name."""
HELP = {"help_option_names": ["--help", "-h"]}


def load(name: str) -> Any:
    """Import a command and return it, as Typer makes it."""
    command = COMMANDS.load(name)
    if isinstance(command, typer.Typer):  # a group of commands
        return typer.main.get_command(command)
    one = typer.Typer(add_completion=False)
    one.command(name, cls=LiteralHelpCommand, context_settings=HELP)(flatten_parameters(command))
    return typer.main.get_command(one)


def summary(name: str) -> str:
    """Return the first paragraph of a command's docstring, read from its file, which is not imported."""
    module = ast.parse(Path(__file__).with_name(f"{name}.py").read_text(encoding="utf-8"))
    own = (part for part in module.body if isinstance(part, ast.FunctionDef) and part.name == name)
    return " ".join((ast.get_docstring(next(own, module)) or "").split("\n\n")[0].split())


class LazyGroup(TyperGroup):
    """A group that lists commands by their summaries and imports the one that is called."""

    def list_commands(self, ctx: Any) -> list[str]:
        """Return the names of the commands."""
        return [*COMMANDS]

    def get_command(self, ctx: Any, name: str) -> Any:
        """Return a command of which nothing but its summary is known."""
        return LiteralHelpCommand(name, help=summary(name)) if name in COMMANDS else None

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return the command that is called, and its arguments."""
        if args[0] in COMMANDS:
            return args[0], load(args[0]), args[1:]
        if args[0][:1] != "-" and (hint := near_name(args[0], COMMANDS)):
            raise UsageError(f"No such command {args[0]!r}{hint}")
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
