"""The one console of the commands, and what they print on it: text, never markup."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from typing import Any

from rich.console import Console

from surefoot.cli.output import to_json


def plain_console(**settings: Any) -> Console:
    """Return a console that prints square brackets as they are: units, file names, extras of pip."""
    return Console(markup=False, emoji=False, **settings)


def say(console: Console, *lines: str, style: str | None = None) -> None:
    """Print lines as they are: whole, without colours of their own; empty ones are left out."""
    for line in filter(None, lines):
        console.print(line, style=style, soft_wrap=True, highlight=False)


def table(
    header: Sequence[str],
    rows: Iterable[Sequence[str]],
    title: str | None = None,
    left: int = 1,
    whole: Collection[str] = (),
) -> Any:
    """Return a table for `Console.print`.

    Parameters
    ----------
    header, rows
        Names of the columns, and their cells.
    title
        Written above, from the left.
    left
        How many columns, from the first one on, are flush left; the others are flush right.
    whole
        Columns whose cells are never broken into lines.
    """
    from rich.table import Table

    out = Table(title=title, title_justify="left")
    for k, name in enumerate(header):
        out.add_column(name, justify="left" if k < left else "right", no_wrap=name in whole)
    for row in rows:
        out.add_row(*row)
    return out


def show(facts: Any, as_json: bool, in_words: Callable[[Console, Any], None]) -> None:
    """Print facts as JSON and nothing else, or in words on the plain console."""
    if as_json:
        print(to_json(facts))
    else:
        in_words(plain_console(), facts)
