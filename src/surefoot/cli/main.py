"""The `surefoot` command line: collects the commands and turns errors into one line."""

from __future__ import annotations

import os
import sys
from typing import cast

import typer

from surefoot.cli import bench, check, cone, model, region, solve, stand, walk, warmup
from surefoot.cli.compiling import announce_compilation
from surefoot.errors import SurefootError

EXIT_BAD_INPUT = 2
PIPE_WIDTH = "120"
"""Columns of a table that goes to a file or a pipe, where there is no terminal to fit."""
UsageError = cast("type[typer.BadParameter]", typer.BadParameter.__bases__[0])
"""Click's class for wrong usage, whether Typer brings Click along or depends on it."""

app = typer.Typer(
    name="surefoot",
    help="The contact layer for legged robots: constrain, solve and check contact forces.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
app.command("stand")(stand.stand)
app.command("walk")(walk.walk)
app.command("cone")(cone.cone)
app.command("check")(check.check)
app.command("region")(region.region)
app.command("model")(model.model)
app.command("solve")(solve.solve)
app.command("warmup")(warmup.warmup)
app.add_typer(bench.app, name="bench")


def run(arguments: list[str] | None = None) -> None:
    """Run the command line and exit; bad input is one line on stderr and exit code 2."""
    if not sys.stdout.isatty():
        os.environ.setdefault("COLUMNS", PIPE_WIDTH)
    announce_compilation()
    sys.exit(main(arguments))


def main(arguments: list[str] | None = None) -> int:
    """Run the command line and return its exit code."""
    try:
        result = app(args=arguments, prog_name="surefoot", standalone_mode=False)
    except SurefootError as error:
        return _bad_input(str(error))
    except UsageError as error:
        if type(error).__name__ == "NoArgsIsHelpError":  # the help has been printed
            return EXIT_BAD_INPUT
        return _bad_input(error.format_message())
    except typer.Abort:
        print("interrupted", file=sys.stderr)
        return 130
    return result if isinstance(result, int) else 0


def _bad_input(message: str) -> int:
    print("surefoot: " + " ".join(message.split()), file=sys.stderr)
    return EXIT_BAD_INPUT
