"""Pages of the course: a MyST-Markdown notebook in each language, and its executed twin as .ipynb.

`course/en/NAME.md` is the source; `course/zh/NAME.md` has the same code cells and its own text. What a run
gives stands in both: `<data value="mu:.2f">0.58</data>` is a number of the code above it, by its expression
and format, and a table that ends with `<!-- rows: table -->` has the tuples of that list as its rows. The
.ipynb beside each is the same notebook with its outputs, which viewers show.
"""

from __future__ import annotations

import html
import json
import re
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from docs.course import words

COURSE = Path(__file__).resolve().parents[2] / "course"
LANGUAGES = ("en", "zh")
FORMAT = "md:myst"
_VALUE = r'<data value="(?P<value>[^"]*)">.*?</data>'
_ROWS = r"(?P<head>^\|[-:| ]+\|\n)(?:\|[^\n]*\n)*\n<!-- rows: (?P<rows>\w+) -->"
COMPUTED = re.compile(f"{_VALUE}|{_ROWS}", re.MULTILINE | re.DOTALL)
"""What a run writes into a text: a value, or the rows of a table."""
_CELL = re.compile(r"^```\{code-cell\}.*?^```$", re.MULTILINE | re.DOTALL)
UNKEPT = "here"
"""Tag of cells that print what depends on the machine, as its speed: their outputs are not kept."""


def names() -> list[str]:
    """Return the names of all pages, in the order of the English contents."""
    index = (COURSE / "en" / "index.md").read_text(encoding="utf-8")
    return re.findall(r"^- \[.*\]\(([\w.-]+)\.ipynb\)", index, re.MULTILINE)


def only(given: list[str], known: list[str]) -> list[str]:
    """Return the pages that are meant: by names, files or how a name begins; all of them without any.

    Raises
    ------
    ValueError
        If nothing is called so.
    """
    chosen = []
    for word in given:
        stem = Path(word).stem if word.endswith((".md", ".ipynb")) else word
        fits = [name for name in known if name == stem] or [name for name in known if name.startswith(stem)]
        if not fits:
            raise ValueError(f"no page {word!r}; there are {', '.join(known)}")
        chosen += fits
    return chosen or known


def source(name: str, language: str) -> Path:
    """Return the file of a page in a language."""
    return COURSE / language / f"{name}.md"


def missing(name: str) -> str:
    """Return a module that a page says it needs and that is not installed, or ""."""
    modules = notebook(source(name, "en").read_text(encoding="utf-8")).metadata.get("modules", [])
    return next((module for module in modules if find_spec(module) is None), "")


def notebook(text: str) -> Any:
    """Return a source's notebook: cells numbered, outputs empty."""
    import jupytext

    book = jupytext.reads(text, fmt=FORMAT)
    for number, cell in enumerate(book.cells):
        cell["id"] = f"cell-{number}"
    return book


def code(text: str) -> list[str]:
    """Return the code cells of a source, fences and tags included."""
    return _CELL.findall(text)


def with_code(text: str, cells: list[str]) -> str:
    """Return a source whose code cells are replaced by as many others."""
    if len(code(text)) != len(cells):
        raise ValueError(f"has {len(code(text))} code cells, the English page {len(cells)}")
    fresh = iter(cells)
    return _CELL.sub(lambda _: next(fresh), text)


def expressions(text: str) -> list[str]:
    """Return what a text wants computed, in its order: expressions with formats, names of lists of rows."""
    return [
        html.unescape(found["value"]) if found["value"] is not None else f"rows {found['rows']}"
        for found in COMPUTED.finditer(text)
    ]


def filled(text: str, values: list[Any], language: str) -> str:
    """Return a text with the values that belong to its `expressions`, words translated."""
    fresh = iter(values)

    def write(found: re.Match[str]) -> str:
        value = next(fresh)
        if found["value"] is not None:
            return f'<data value="{found["value"]}">{words.value(value, language)}</data>'
        rows = ("| " + " | ".join(words.cell(cell, language) for cell in row) + " |\n" for row in value)
        return f"{found['head']}{''.join(rows)}\n<!-- rows: {found['rows']} -->"

    return COMPUTED.sub(write, text)


def pair_faults(name: str) -> list[str]:
    """Return what is wrong with a page's four files as they lie there, without running anything."""
    faults, texts = [], {k: source(name, k).read_text(encoding="utf-8") for k in LANGUAGES}
    if code(texts["en"]) != code(texts["zh"]):
        faults.append(f"{name}: code differs between languages: python -m docs.course {name}")
    for language, text in texts.items():
        if _cells(kept(name, language)) != _cells(notebook(text)):
            faults.append(f"{language}/{name}.ipynb is not its .md's: python -m docs.course {name}")
    return faults


def kept(name: str, language: str) -> dict[str, Any]:
    """Return a page's notebook as it is kept; without cells if there is none."""
    path = source(name, language).with_suffix(".ipynb")
    book: dict[str, Any] = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {"cells": []}
    return book


def _cells(book: Any) -> list[tuple[str, str, list[str]]]:
    return [
        (cell["cell_type"], "".join(cell["source"]), cell["metadata"].get("tags", []))
        for cell in book["cells"]
    ]


def said(book: Any) -> list[list[str]]:
    """Return what each code cell put out: what it printed, and what each of its figures shows in words."""
    return [
        [
            "".join(output["text"])
            if output["output_type"] == "stream"
            else output["metadata"]["image/png"]["alt"]
            for output in cell["outputs"]
        ]
        for cell in book["cells"]
        if cell["cell_type"] == "code"
    ]
