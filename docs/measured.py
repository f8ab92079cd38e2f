"""What a measured table of the docs is, and cells of tables that benchmarks print."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

Rows = list[list[str]]


@dataclass(frozen=True)
class Table:
    """A measured table.

    Attributes
    ----------
    command
        What measures it, as it is typed; several with "; " between them.
    page
        File name below docs/.
    columns
        Headings.
    rows
        Makes cells of what the command printed, of a list where there are several.
    long
        Whether it takes many minutes: measured by name only.
    reads
        Makes what `rows` takes of what a command prints; where it is `json.loads` the command is asked for
        JSON.
    said
        What the page says in place of the commands.
    """

    command: str
    page: str
    columns: tuple[str, ...]
    rows: Callable[[Any], Rows]
    long: bool = False
    reads: Callable[[str], Any] = json.loads
    said: str = ""

    @property
    def commands(self) -> list[str]:
        """Return the commands one by one."""
        return self.command.split("; ")


def printed(data: Sequence[dict[str, Any]], title: str, *columns: str) -> Rows:
    """Return some columns of the printed table whose title has some words in it (`benchmarks.printing`)."""
    (table,) = (table for table in data if title in table["title"])
    places = [table["columns"].index(name) for name in columns or table["columns"]]
    return [[row[k].strip() for k in places] for row in table["rows"]]


def words(text: str, *beginnings: str) -> Iterator[list[str]]:
    """Yield the lines of a printed text that begin with some words, cut at two spaces or more."""
    for line in text.splitlines():
        if line.strip().startswith(beginnings):
            yield [part.strip() for part in line.split("  ") if part.strip()]
