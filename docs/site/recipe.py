"""Cookbook pages: Markdown whose Python runs block after block, and prints what stands below each block."""

from __future__ import annotations

import io
import os
import re
from contextlib import redirect_stdout
from dataclasses import dataclass, field
from importlib.util import find_spec
from pathlib import Path
from typing import Any

COOKBOOK = Path(__file__).resolve().parents[1] / "cookbook"
_NEEDS = re.compile(r"<!-- needs: (.+?) -->\n")
BLOCK = re.compile(r"^```(python|text)\n(.*?)^```$", re.M | re.S)


@dataclass(frozen=True)
class Block:
    """A block of code: its first line in the page, its text, and what it should print."""

    line: int
    code: str
    prints: str


@dataclass(frozen=True)
class Recipe:
    """A page of the cookbook: its path, the modules it needs, its text and its blocks."""

    path: Path
    needs: tuple[str, ...]
    text: str = field(repr=False)
    blocks: tuple[Block, ...] = field(repr=False)

    @property
    def title(self) -> str:
        """The page's heading."""
        return self.text.split("# ", 1)[1].split("\n", 1)[0]

    @property
    def missing(self) -> list[str]:
        """The modules that it needs and that are not installed."""
        return [name for name in self.needs if find_spec(name) is None]


def read_recipe(path: Path) -> Recipe:
    """Read a page; a block of text belongs to the code before it.

    Raises
    ------
    ValueError
        If a block of text has no code before it.
    """
    text = path.read_text(encoding="utf-8")
    needs = _NEEDS.match(text)
    blocks: list[Block] = []
    last = ""
    for found in BLOCK.finditer(text):
        line = text.count("\n", 0, found.start()) + 1
        if found[1] == "python":
            blocks.append(Block(line, found[2], ""))
        elif last != "python":
            raise ValueError(f"{path.name}:{line}: output without code before it")
        else:
            blocks[-1] = Block(blocks[-1].line, blocks[-1].code, found[2].rstrip())
        last = found[1]
    modules = tuple(needs[1].split(", ")) if needs else ()
    return Recipe(path, modules, text[needs.end() :] if needs else text, tuple(blocks))


def recipes() -> list[Recipe]:
    """Return all pages of the cookbook but its index, by name."""
    return [read_recipe(path) for path in sorted(COOKBOOK.glob("*.md")) if path.name != "README.md"]


def run_recipe(recipe: Recipe, folder: Path) -> list[str]:
    """Run a page in a folder; return what each of its blocks printed."""
    names: dict[str, Any] = {"__name__": "__main__"}
    printed, home = [], Path.cwd()
    os.chdir(folder)
    try:
        for block in recipe.blocks:
            out = io.StringIO()
            with redirect_stdout(out):
                exec(compile("\n" * block.line + block.code, str(recipe.path), "exec"), names)
            printed.append(out.getvalue().rstrip())
    finally:
        os.chdir(home)
    return printed
