"""What benchmarks print and write: tables for people or as JSON, records as files, options that all share."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Collection, Iterable, Sequence
from pathlib import Path
from typing import Any

import typer
from rich.console import Console
from rich.table import Table

from surefoot.app.cli.console import plain_console
from surefoot.app.cli.console import table as right_table
from surefoot.app.cli.output import new_run_folder, to_json


def show(tables: Iterable[Table], as_json: bool = False, console: Console | None = None) -> None:
    """Print tables as they come; as JSON all together: a list of titles, columns and rows of cells."""
    if as_json:
        print(json.dumps([cells(table) for table in tables], indent=1, ensure_ascii=False))
        return
    console = Console(markup=False) if console is None else console  # [ms] is a unit
    for table in tables:
        console.print(table)


def table(
    header: Sequence[str],
    rows: Iterable[Sequence[str]],
    title: str,
    left: int = 1,
    texts: Collection[str] = (),
) -> Table:  # fmt: skip
    """Return a table; its first columns, `left` of them, and those named in `texts` are flush left."""
    out: Table = right_table(header, rows, title, left)
    for column in out.columns:
        if column.header in texts:
            column.justify = "left"
    return out


def cells(table: Table) -> dict[str, object]:
    """Return title, columns and rows of a table, as they are printed."""
    columns = [[str(cell) for cell in column.cells] for column in table.columns]
    return {
        "title": str(table.title),
        "columns": [str(column.header) for column in table.columns],
        "rows": [list(row) for row in zip(*columns, strict=True)],
    }


def report(
    record: Any, as_json: bool, in_words: Callable[[Console], None], width: int = 0, out: Path | None = None,
    name: str = "",
) -> None:  # fmt: skip
    """Print a record as JSON or in words; keep it as NAME.json in a new folder below `out`.

    Parameters
    ----------
    record
        What JSON can hold, arrays and numbers that are none included.
    as_json
        Whether to print JSON and nothing else.
    in_words
        Prints it for people.
    width
        Columns that this needs: a narrower terminal wraps its lines.
    out, name
        Where it is kept, None for nowhere, and what it is called.
    """
    if as_json:
        print(to_json(record))
    else:
        console = plain_console()
        in_words(console if console.width >= width else plain_console(width=width))
    if out is None:
        return
    folder = new_run_folder(out, f"bench-{name}")
    (folder / f"{name}.json").write_text(to_json(record) + "\n", encoding="utf-8")
    typer.echo(f"written: {folder / f'{name}.json'}", err=True)


def options(about: str | None, quick: str, seeds: int = 0, duration: float = 0.0) -> argparse.ArgumentParser:
    """Return a parser of the options that programs of tables share.

    Parameters
    ----------
    about
        The program's docstring.
    quick
        What ``--quick`` leaves to do.
    seeds, duration
        Defaults of ``--seeds`` and, for programs of walks, ``--duration`` [s] and ``--only``; zero for none.
    """
    parser = argparse.ArgumentParser(description=about)
    parser.add_argument("--quick", action="store_true", help=quick)
    parser.add_argument("--json", action="store_true", help="print the tables as JSON")
    if seeds:
        parser.add_argument("--seeds", type=int, default=seeds)
    if duration:
        parser.add_argument("--duration", type=float, default=duration)
        parser.add_argument("--only", default="", help="walks whose names hold this")
    return parser
