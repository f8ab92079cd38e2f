"""Write a course page that was run: Markdown for the site, and a notebook to download."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

from docs.site.execute import Ran
from docs.site.page import LANGUAGES
from docs.site.recipe import BLOCK, Recipe

OTHER = {"en": ("中文", "zh/course"), "zh": ("English", "../course")}
"""What the link to a page's other language says, and where it leads from the root of the tree."""
_WIDE = "\u3000-\u303f\u4e00-\u9fff\uff00-\uffef"
_CHINESE_BREAK = re.compile(rf"(?<=[{_WIDE}])\n(?=[{_WIDE}])")
"""A line break between Chinese characters, which a browser would show as a space."""
_DOC_LINK = re.compile(r"\[([^\]]+)\]\(\.\./([\w/-]+)\.md(#[\w-]+)?\)")
AFTER = {
    "en": "After section {} of *Robotics Tutorial*, chapter 52, by Pengfei Guo (CC BY 4.0). "
    "The words and the measurements are our own.",
    "zh": "本页参照 Pengfei Guo 的《Robotics Tutorial》第 52 章 {} 节（CC BY 4.0）；"
    "文字与测量均为我们自己的。",
}
"""Whose order a page follows."""
NOTEBOOK = {"en": "This page as a notebook", "zh": "本页的 Jupyter 笔记本"}


def markdown(ran: Ran, language: str) -> str:
    """Return a page for the site, with links to its other language and to its notebook."""
    page, (word, folder) = ran.page, OTHER[language]
    other = f'<a class="language" href="../{folder}/{page.name}.html">{word}</a>'
    lines = [f"# {page.title[language]}", "", other, ""]
    for kind, text in ran.pieces[language]:
        lines += [*_piece(page.title[language], kind, text), ""]
    if language == "zh":  # the docs are in the English tree
        lines = [_DOC_LINK.sub(r'<a href="../../\2.html\3">\1</a>', line) for line in lines]
        lines = [_CHINESE_BREAK.sub("", line) for line in lines]
    lines += [AFTER[language].format(page.after), ""]
    lines += [f"{{download}}`{NOTEBOOK[language]} <notebooks/{page.name}.ipynb>`", ""]
    return "\n".join(lines)


def _piece(title: str, kind: str, text: str) -> list[str]:
    if kind == "code":
        return ["```python", text, "```"]
    if kind == "output":
        return ["```text", text, "```"]
    if kind == "figure":
        return [f"![{title}](figures/{text})"]
    return [text]


def notebook(ran: Ran, language: str) -> str:
    """Return a page as a notebook, format 4.5, its code not run."""
    pieces = [piece for piece in ran.pieces[language] if piece[0] in ("markdown", "code")]
    about = ("markdown", f"# {ran.page.title[language]}\n\n{AFTER[language].format(ran.page.after)}")
    return _as_notebook([about, *pieces])


def recipe_notebook(recipe: Recipe) -> str:
    """Return a page of the cookbook as a notebook, its code not run."""
    pieces, at = [], 0
    for found in BLOCK.finditer(recipe.text):
        pieces.append(("markdown", recipe.text[at : found.start()].strip()))
        at = found.end()
        if found[1] == "python":
            pieces.append(("code", found[2].rstrip()))
    return _as_notebook([piece for piece in [*pieces, ("markdown", recipe.text[at:].strip())] if piece[1]])


def _as_notebook(pieces: list[tuple[str, str]]) -> str:
    """Return cells of Markdown and code as a notebook."""
    cells = [_cell(kind, text) for kind, text in pieces]
    for number, cell in enumerate(cells):
        cell["id"] = f"cell-{number}"
    about = {"kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"}}
    return json.dumps({"nbformat": 4, "nbformat_minor": 5, "metadata": about, "cells": cells}, indent=1)


def _cell(kind: str, text: str) -> dict[str, Any]:
    cell: dict[str, Any] = {"cell_type": kind, "metadata": {}, "source": text.splitlines(keepends=True)}
    return cell | ({"outputs": [], "execution_count": None} if kind == "code" else {})


def write(ran: Ran, trees: dict[str, Path]) -> None:
    """Write a page and its notebook below `course/` of each language's source tree."""
    for language in LANGUAGES:
        folder = trees[language] / "course"
        (folder / "notebooks").mkdir(parents=True, exist_ok=True)
        (folder / f"{ran.page.name}.md").write_text(markdown(ran, language), encoding="utf-8")
        (folder / "notebooks" / f"{ran.page.name}.ipynb").write_text(
            notebook(ran, language), encoding="utf-8"
        )
