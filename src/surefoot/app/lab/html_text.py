"""Texts beside a picture as HTML, which a browser shows as it is: Markdown would be parsed at every move."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

from surefoot.app.viz import palette

STYLE = f"font-family: {palette.TEXT_FAMILY}; font-size: 14px; line-height: 1.45; padding: 0 0.8em;"
_CELL = 'style="text-align: {}; padding: 1px 6px 1px 0;"'


def heading(text: str, colour: str = "") -> str:
    """Return a heading; with a colour it is a badge of a verdict, white on it."""
    badge = f"color: {palette.PAPER}; background: {colour}; padding: 0.2em 0.7em; border-radius: 0.4em;"
    style = f"font-size: 18px; font-weight: bold; margin: 0.4em 0 0.3em; {badge if colour else ''}"
    return f'<div style="{style}">{escape(text)}</div>'


def paragraph(text: str, style: str = "") -> str:
    """Return a paragraph, in the words of a style sheet."""
    return f'<div style="margin: 0.25em 0; {style}">{escape(text)}</div>'


def table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table whose first column is flush left, the others flush right."""

    def line(cells: Sequence[str], tag: str) -> str:
        made = [
            f"<{tag} {_CELL.format('right' if k else 'left')}>{escape(cell)}</{tag}>"
            for k, cell in enumerate(cells)
        ]
        return f"<tr>{''.join(made)}</tr>"

    body = "".join(line(row, "td") for row in rows)
    return f'<table style="border-collapse: collapse; width: 100%;">{line(header, "th")}{body}</table>'


def text(*parts: str) -> str:
    """Return parts below each other; empty ones are left out."""
    return f'<div style="{STYLE}">{"".join(parts)}</div>'


def refusal(line: str) -> str:
    """Return what is said to a browser whose choice was refused."""
    return text(paragraph(f"Refused: {line}", f"color: {palette.BAD}; font-weight: bold;")) if line else ""
