"""The `surefoot` command line: runs a command and turns errors into one line."""

from __future__ import annotations

import os
import sys
from typing import Any, NoReturn, TextIO, cast

from surefoot import __version__

EXIT_BAD_INPUT = 2
SHORT = ("check", "cone", "region", "solve")
"""Commands that ask one short question of kernels: these run as Python where nothing is compiled yet."""
PIPE_WIDTH = "120"
"""Columns of a table that goes to a file or a pipe, where there is no terminal to fit."""


def run(arguments: list[str] | None = None) -> None:
    """Run the command line and exit; bad input is one line on stderr and exit code 2."""
    sys.stdout, sys.stderr = heard(sys.stdout), heard(sys.stderr)
    words = sys.argv[1:] if arguments is None else arguments
    if words == ["--version"]:  # asked by scripts, often
        _end(0, f"surefoot {__version__}\n")
    said = os.environ.get("COLUMNS", "1" if sys.stdout.isatty() else "")
    if not said.isdecimal() or int(said) == 0:  # neither the terminal nor its user says a width
        os.environ["COLUMNS"] = PIPE_WIDTH
    from surefoot.app.cli.compiling import announce_compilation

    announce_compilation()
    if words and words[0] in SHORT:
        from surefoot.base.compilation.cold_start import cold_start

        cold_start.allow()
    _end(main(arguments))


def _end(code: int, last: str = "") -> NoReturn:
    """Exit, once what was printed and a last text have arrived: a full disk is found here at the latest."""
    try:
        sys.stdout.write(last)
        sys.stdout.flush()
    except OSError as error:
        code = _bad_input(error.strerror or str(error))
    sys.exit(code)


def main(arguments: list[str] | None = None) -> int:
    """Run the command line and return its exit code."""
    import typer

    from surefoot.app.cli import commands
    from surefoot.base.errors import SurefootError

    try:
        result = commands.tree()(args=arguments, prog_name="surefoot", standalone_mode=False)
    except SurefootError as error:
        return _bad_input(str(error))
    except commands.UsageError as error:
        if type(error).__name__ == "NoArgsIsHelpError":  # the help has been printed
            return EXIT_BAD_INPUT
        said = error.format_message()
        if said.startswith("No such option: -") and said[17:18].isdigit():
            said += "; a number below zero stands behind --, as in: surefoot plan jump -- -0.3"
        return _bad_input(said)
    except typer.Abort:
        print("interrupted", file=sys.stderr)
        return 130
    except OSError as error:
        return _bad_input(f"{error.strerror or error}" + (f": {error.filename}" if error.filename else ""))
    finally:
        if (output := sys.modules.get("surefoot.app.cli.output")) is not None:
            output.drop_empty_folders()
    return result if isinstance(result, int) else 0


def _bad_input(message: str) -> int:
    print("surefoot: " + " ".join(message.split()), file=sys.stderr)
    return EXIT_BAD_INPUT


class _Pipe:
    """A text stream that goes on into nothing once its reader is gone, as `head` is after ten lines.

    So it does after an error, a full disk say, that has been raised once: what the buffer still holds would
    raise it again when Python ends.
    """

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Write, or drop what nobody reads."""
        try:
            return self._stream.write(text)
        except OSError as error:
            self._drop(error)
            return len(text)

    def flush(self) -> None:
        """Flush, or drop what nobody reads."""
        try:
            self._stream.flush()
        except OSError as error:
            self._drop(error)

    def _drop(self, error: OSError) -> None:
        with open(os.devnull, "w", encoding="utf-8") as nowhere:
            os.dup2(nowhere.fileno(), self._stream.fileno())
        if not isinstance(error, BrokenPipeError):
            raise error


def heard(stream: TextIO | None) -> TextIO:
    """Return a stream for output that takes all, also where the shell (None) or its reader closed it."""
    if stream is None:
        return open(os.devnull, "w", encoding="utf-8")
    return cast("TextIO", _Pipe(stream))
