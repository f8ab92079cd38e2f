"""Tables of benchmarks, printed for people or as JSON."""

from __future__ import annotations

import json
from collections.abc import Iterable

from rich.console import Console
from rich.table import Table


def show(tables: Iterable[Table], as_json: bool = False, console: Console | None = None) -> None:
    """Print tables as they come; as JSON all together: a list of titles, columns and rows of cells."""
    if as_json:
        print(json.dumps([cells(table) for table in tables], indent=1, ensure_ascii=False))
        return
    console = Console() if console is None else console
    for table in tables:
        console.print(table)


def cells(table: Table) -> dict[str, object]:
    """Return title, columns and rows of a table, as they are printed."""
    columns = [[str(cell) for cell in column.cells] for column in table.columns]
    return {
        "title": str(table.title),
        "columns": [str(column.header) for column in table.columns],
        "rows": [list(row) for row in zip(*columns, strict=True)],
    }
