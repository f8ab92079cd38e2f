"""The `surefoot` command line: runs a command and turns errors into one line."""

from __future__ import annotations

import os
import sys

from surefoot import __version__

EXIT_BAD_INPUT = 2
PIPE_WIDTH = "120"
"""Columns of a table that goes to a file or a pipe, where there is no terminal to fit."""


def run(arguments: list[str] | None = None) -> None:
    """Run the command line and exit; bad input is one line on stderr and exit code 2."""
    from surefoot.cli.closed_pipes import heard

    sys.stdout, sys.stderr = heard(sys.stdout), heard(sys.stderr)
    if (sys.argv[1:] if arguments is None else arguments) == ["--version"]:  # asked by scripts, often
        print(f"surefoot {__version__}", flush=True)
        sys.exit(0)
    said = os.environ.get("COLUMNS", "1" if sys.stdout.isatty() else "")
    if not said.isdecimal() or int(said) == 0:  # neither the terminal nor its user says a width
        os.environ["COLUMNS"] = PIPE_WIDTH
    from surefoot.cli.compiling import announce_compilation

    announce_compilation()
    code = main(arguments)
    sys.stdout.flush()
    sys.exit(code)


def main(arguments: list[str] | None = None) -> int:
    """Run the command line and return its exit code."""
    import typer

    from surefoot.cli import commands
    from surefoot.errors import SurefootError

    try:
        result = commands.tree()(args=arguments, prog_name="surefoot", standalone_mode=False)
    except SurefootError as error:
        return _bad_input(str(error))
    except commands.UsageError as error:
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
