"""The one console of the commands, and what they print on it: text, never markup."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple, TypeAlias

from rich.console import Console

from surefoot.app.cli.output import to_json

NARROW = 10
"""Characters that a column needs so that its words can still be read."""
Cell: TypeAlias = Callable[[Any], str]
"""What a table says of a thing in one column."""


def plain_console(**settings: Any) -> Console:
    """Return a console that prints square brackets as they are: units, file names, extras of pip."""
    return Console(markup=False, emoji=False, **settings)


def say(console: Console, *lines: str, style: str | None = None) -> None:
    """Print lines as they are: whole, without colours of their own; empty ones are left out."""
    for line in filter(None, lines):
        console.print(line, style=style, soft_wrap=True, highlight=False)


def say_verdict(console: Console, line: str, good: bool) -> None:
    """Print the line that says how something went, in green or red."""
    say(console, line, style="bold green" if good else "bold red")


def table(
    header: Sequence[str],
    rows: Iterable[Sequence[str]],
    title: str | None = None,
    left: int | Collection[str] = 1,
    whole: Collection[str] = (),
    **column: Any,
) -> Any:
    """Return a table for `Console.print`.

    Parameters
    ----------
    header, rows
        Names of the columns, and their cells.
    title
        Written above, from the left.
    left
        How many columns, from the first one on, are flush left, or which; the others are flush right.
    whole
        Columns whose cells are not broken into lines, where the others then keep `NARROW` characters each.
    column
        Of every column, for Rich.
    """
    from rich.table import Table as RichTable

    flush = header[:left] if isinstance(left, int) else left
    rows = list(rows)
    taken = sum(
        max(len(line[k]) for line in (header, *rows)) if name in whole else NARROW
        for k, name in enumerate(header)
    )
    whole = whole if taken + 3 * len(header) + 1 <= plain_console().width else ()
    out = RichTable(title=title, title_justify="left")
    for name in header:
        out.add_column(
            name,
            justify="left" if name in flush else "right",
            no_wrap=name in whole,
            **{"overflow": "fold", **column},
        )
    for row in rows:
        out.add_row(*row)
    return out


def fit_table(fit: Mapping[str, Mapping[str, Any]], title: str, digits: int = 4, left: int = 4) -> Any:
    """Return the table of what was fitted, by name: value, low, high and unit; `left` as for `table`."""
    rows = [
        (name, f"{e['value']:.{digits}g}", f"{e['low']:.{digits}g} to {e['high']:.{digits}g}", e["unit"])
        for name, e in fit.items()
    ]
    return table(("", "value", "95 % interval", "unit"), rows, title, left)


def show(facts: Any, as_json: bool, in_words: Callable[[Console, Any], None], **settings: Any) -> None:
    """Print facts as JSON and nothing else, or in words on the plain console of these settings."""
    if as_json:
        print(to_json(facts))
    else:
        in_words(plain_console(**settings), facts)


class Table(NamedTuple):
    """A table of the screen and of the page that a command leaves.

    Attributes
    ----------
    title, header, rows
        Heading, columns' names and cells.
    shown
        How many columns, from the first one on, are printed; the page has all.
    """

    title: str
    header: Sequence[str]
    rows: Sequence[Sequence[str]]
    shown: int | None = None

    @classmethod
    def of(
        cls, title: str, things: Iterable[Any], columns: Mapping[str, Cell], shown: int | None = None
    ) -> Table:
        """Return the table with a row for each thing; a column is its name and what a thing has there."""
        return cls(title, [*columns], [[cell(one) for cell in columns.values()] for one in things], shown)


def print_tables(console: Console, tables: Sequence[Table], lines: Sequence[str]) -> None:
    """Print tables without their headings, and what is said below them."""
    for one in tables:
        console.print(table(one.header[: one.shown], [row[: one.shown] for row in one.rows]))
    say(console, *lines)


@contextmanager
def progress_bar(shown: bool, label: str, total: float) -> Iterator[Callable[[float], None] | None]:
    """Show a progress bar on a terminal while the context lasts; yield the function that moves it."""
    screen = plain_console(stderr=True)
    if not shown or not screen.is_terminal:
        yield None
        return
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (TextColumn(label), BarColumn(), TextColumn("{task.percentage:.0f} %"), TimeElapsedColumn())
    with Progress(*columns, console=screen, transient=True) as bar:
        task = bar.add_task(label, total=total if math.isfinite(total) else None)
        yield lambda done: bar.update(task, completed=done)
