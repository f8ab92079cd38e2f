"""The `surefoot` command line: collects the commands and turns errors into one line."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from functools import cache
from typing import Annotated, cast

import typer

from surefoot import __version__
from surefoot.cli import (
    audit,
    bench,
    check,
    cone,
    doctor,
    export,
    identify,
    lab,
    model,
    plan,
    policy,
    region,
    solve,
    stand,
    sweep,
    translate,
    walk,
    warmup,
    worlds,
)
from surefoot.cli.closed_pipes import heard
from surefoot.cli.compiling import announce_compilation
from surefoot.cli.typer_command import LiteralHelpCommand, ungrouped
from surefoot.errors import SurefootError

EXIT_BAD_INPUT = 2
PIPE_WIDTH = "120"
"""Columns of a table that goes to a file or a pipe, where there is no terminal to fit."""
UsageError = cast("type[typer.BadParameter]", typer.BadParameter.__bases__[0])
"""Click's class for wrong usage, whether Typer brings Click along or depends on it."""

app = typer.Typer(
    name="surefoot",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
)
for _command in (
    stand.stand, walk.walk, cone.cone, check.check, region.region, model.model, solve.solve,
    translate.translate, identify.identify, sweep.sweep, audit.audit, worlds.worlds, plan.plan, export.export,
    warmup.warmup, doctor.doctor, lab.lab, policy.policy,
):  # fmt: skip
    app.command(_command.__name__, cls=LiteralHelpCommand)(ungrouped(_command))
app.add_typer(bench.app, name="bench")


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


def run(arguments: list[str] | None = None) -> None:
    """Run the command line and exit; bad input is one line on stderr and exit code 2."""
    sys.stdout, sys.stderr = heard(sys.stdout), heard(sys.stderr)
    said = os.environ.get("COLUMNS", "1" if sys.stdout.isatty() else "")
    if not said.isdecimal() or int(said) == 0:  # neither the terminal nor its user says a width
        os.environ["COLUMNS"] = PIPE_WIDTH
    announce_compilation()
    code = main(arguments)
    sys.stdout.flush()
    sys.exit(code)


@cache
def _tree() -> Callable[..., object]:
    """Return the tree of commands; to put it together takes 65 ms, once a process."""
    return cast("Callable[..., object]", typer.main.get_command(app))


def main(arguments: list[str] | None = None) -> int:
    """Run the command line and return its exit code."""
    try:
        result = _tree()(args=arguments, prog_name="surefoot", standalone_mode=False)
    except SurefootError as error:
        return _bad_input(str(error))
    except UsageError as error:
        if type(error).__name__ == "NoArgsIsHelpError":  # the help has been printed
            return EXIT_BAD_INPUT
        return _bad_input(error.format_message())
    except typer.Abort:
        print("interrupted", file=sys.stderr)
        return 130
    except OSError as error:
        return _bad_input(f"{error.strerror or error}" + (f": {error.filename}" if error.filename else ""))
    return result if isinstance(result, int) else 0


def _bad_input(message: str) -> int:
    print("surefoot: " + " ".join(message.split()), file=sys.stderr)
    return EXIT_BAD_INPUT
