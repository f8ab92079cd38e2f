"""Measure Surefoot against its rivals in the same run.

The benchmarks lie beside the source tree, where there is one.
"""

from __future__ import annotations

import importlib
import importlib.util
import sys
from pathlib import Path
from typing import Any, cast

import typer
from typer.core import TyperGroup

import surefoot
from surefoot.base.errors import SurefootError

FOLDER = Path(surefoot.__file__).parents[2] / "benchmarks"
"""Where a checkout keeps them; an installed package has nothing there."""


class Absent(TyperGroup):
    """A group of no commands, which fails with one line whatever it is asked."""

    def invoke(self, ctx: Any) -> Any:
        """Say where the benchmarks are.

        Raises
        ------
        SurefootError
            Always.
        """
        raise SurefootError(
            "benchmarks come with the repository, not with the installed package; in a checkout of it, "
            "after pip install -e '.[all]', run `surefoot bench` again"
        )


def commands(folder: Path = FOLDER) -> typer.Typer:
    """Return the benchmarks of a checkout, or a group that says where they are."""
    if not (folder / "commands" / "__init__.py").is_file():
        app = typer.Typer(cls=Absent, context_settings={"ignore_unknown_options": True})
        app.callback(
            invoke_without_command=True,
            help="Measure Surefoot against its rivals: part of the repository, not installed here.",
        )(lambda: None)
        return app
    if "benchmarks" not in sys.modules:  # by its place: another package of that name may be on the path
        found = importlib.util.spec_from_file_location(
            "benchmarks", folder / "__init__.py", submodule_search_locations=[str(folder)]
        )
        assert found is not None
        assert found.loader is not None
        package = sys.modules["benchmarks"] = importlib.util.module_from_spec(found)
        found.loader.exec_module(package)
    return cast(typer.Typer, importlib.import_module("benchmarks.commands").app)


app = commands()
