"""What commands say in tables: on the screen, and on the page that they leave."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from rich.console import Console

from surefoot.cli.console import say, table
from surefoot.viz import report


class Table(NamedTuple):
    """A heading, the columns' names and the rows."""

    title: str
    header: Sequence[str]
    rows: Sequence[Sequence[str]]


def print_tables(console: Console, tables: Sequence[Table], lines: Sequence[str]) -> None:
    """Print tables without their headings, and what is said below them."""
    for one in tables:
        console.print(table(one.header, one.rows))
    say(console, *lines)


def report_sections(tables: Sequence[Table], lines: Sequence[str]) -> list[tuple[str, str]]:
    """Return a page's sections of tables and figures."""
    written = [(one.title, report.table(one.header, one.rows)) for one in tables]
    return [*written, ("Figures", "".join(report.paragraph(line) for line in lines))]


def write_page(
    folder: Path, title: str, verdicts: Sequence[tuple[str, bool]], sections: Sequence[tuple[str, str]]
) -> Path:
    """Write report.html of the command that runs into a folder and return its path.

    Parameters
    ----------
    folder, title, sections
        See `surefoot.viz.report.write_report`.
    verdicts
        Lines, and whether each is good news; together they are one line.
    """
    verdict = "; ".join(line for line, _ in verdicts), all(good for _, good in verdicts)
    command = shlex.join(["surefoot", *sys.argv[1:]])
    return report.write_report(folder / "report.html", title, verdict, sections, command)
