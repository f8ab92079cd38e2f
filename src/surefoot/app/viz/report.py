"""A report of a run as one HTML file that needs nothing else: pictures and film are inside."""

from __future__ import annotations

import base64
import html
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from surefoot.app.viz.palette import BAD, GOOD, GRID, INK, NOTE, PANEL, PAPER, TEXT_FAMILY
from surefoot.base.errors import ProblemError

_CSS = f"""
body{{font:15px/1.5 {TEXT_FAMILY};color:{INK};max-width:60rem;margin:2rem auto;padding:0 1rem}}
h1{{font-size:1.6rem;margin-bottom:.2rem}}h2{{font-size:1.1rem;margin-top:2rem}}
.verdict{{display:inline-block;padding:.2rem .7rem;border-radius:.4rem;color:{PAPER};background:{BAD}}}
.verdict.good{{background:{GOOD}}}table{{border-collapse:collapse;margin:.6rem 0}}
td,th{{padding:.25rem .8rem;border-bottom:1px solid {GRID};text-align:right}}
td:first-child,th:first-child{{text-align:left}}img,video{{max-width:100%}}
@media(max-width:40rem){{body{{margin:.5rem auto;font-size:16px}}table{{display:block;overflow-x:auto}}
td,th{{padding:.25rem .4rem}}.verdict{{display:block}}}}
code{{background:{PANEL};padding:.1rem .3rem;border-radius:.2rem}}.note{{color:{NOTE}}}
"""


def write_report(
    path: Path,
    title: str,
    verdict: tuple[str, bool],
    sections: Sequence[tuple[str, str]],
    command: str,
) -> Path:
    """Write the report to a new file and return its path.

    Parameters
    ----------
    path
        Where to; must not exist.
    title
        Heading of the page.
    verdict
        One line, and whether it is good news.
    sections
        Pairs of a heading and ready HTML (see `table`, `picture`, `film`).
    command
        The command that made the run.

    Raises
    ------
    ProblemError
        If the file exists already.
    """
    if path.exists():
        raise ProblemError(f"{path} exists already")
    body = "".join(f"<h2>{html.escape(name)}</h2>\n{content}\n" for name, content in sections)
    line, good = verdict
    path.write_text(
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{html.escape(title)}</title>"
        f"<style>{_CSS}</style></head><body>\n<h1>{html.escape(title)}</h1>\n"
        f'<p><span class="verdict{" good" if good else ""}">{html.escape(line)}</span></p>\n'
        f'<p class="note">Made by <code>{html.escape(command)}</code></p>\n{body}</body></html>\n',
        encoding="utf-8",
    )
    return path


def table(header: Sequence[str], rows: Sequence[Sequence[Any]]) -> str:
    """Return an HTML table."""
    return f"<table>{_row('th', header)}{''.join(_row('td', row) for row in rows)}</table>"


def _row(tag: str, cells: Sequence[Any]) -> str:
    return "<tr>" + "".join(f"<{tag}>{html.escape(str(c))}</{tag}>" for c in cells) + "</tr>\n"


def embed_picture(path: Path) -> str:
    """Return the HTML element of a picture, its bytes inside."""
    name = html.escape(path.stem.replace("_", " "))
    return f'<img alt="{name}" src="data:image/png;base64,{_base64(path)}">'


def embed_film(path: Path) -> str:
    """Return the HTML element of a film, its bytes inside."""
    return f'<video controls loop muted src="data:video/mp4;base64,{_base64(path)}"></video>'


def _base64(path: Path) -> str:
    return base64.b64encode(path.read_bytes()).decode("ascii")


def paragraph(text: str) -> str:
    """Return a paragraph of plain text."""
    return f"<p>{html.escape(text)}</p>"
