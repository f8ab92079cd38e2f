"""`surefoot examples`: the programs, stances, scenarios and sweeps that the docs' commands name, as files."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from surefoot.app.cli import options
from surefoot.app.cli.console import say, show
from surefoot.base.errors import ProblemError, WriteError

PACKAGE = Path(__file__).resolve().parents[2]
PLACES = (PACKAGE / "examples", PACKAGE.parents[1] / "examples")
"""Where examples are: in an installed package, in a checkout."""


def examples(
    out: Annotated[Path, typer.Option(help="The new folder.")] = Path("examples"),
    as_json: options.AsJson = False,
) -> int:
    """Copy the examples into a new folder, where the docs' commands find them; nothing is overwritten."""
    source = examples_folder()
    if out.exists():
        raise ProblemError(f"{out} exists already; name a new folder with --out")
    try:
        shutil.copytree(source, out, ignore=shutil.ignore_patterns("__pycache__"))
    except OSError as error:
        shutil.rmtree(out, ignore_errors=True)
        raise WriteError(out, error) from error
    files = sorted(path.relative_to(out).as_posix() for path in out.rglob("*") if path.is_file())
    show({"folder": str(out), "files": files}, as_json, _print)
    return 0


def examples_folder() -> Path:
    """Return the folder of the examples that come with the package.

    Raises
    ------
    ProblemError
        If the installation has none.
    """
    found = next((place for place in PLACES if (place / "stances").is_dir()), None)
    if found is None:
        raise ProblemError("this installation has no examples; a checkout and a wheel have them")
    return found


def _print(console: Console, facts: dict[str, Any]) -> None:
    by_kind = sorted({name.partition("/")[0] for name in facts["files"] if "/" in name})
    say(console, f"{len(facts['files'])} files in {facts['folder']}: programs and {', '.join(by_kind)}.")
    say(console, f"Try: surefoot check {facts['folder']}/stances/chimney.yaml")
