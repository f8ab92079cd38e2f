"""The Python that a page of the docs shows, run as one program."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Callable
from pathlib import Path
from typing import Any

DOCS = Path(__file__).resolve().parents[1] / "docs"
BLOCK = re.compile(r"^ *```python\n(.*?)^ *```", re.DOTALL | re.MULTILINE)


def blocks(page: str) -> list[str]:
    """Return the Python blocks of a page, indented ones moved to the margin."""
    text = (DOCS / page).read_text(encoding="utf-8")
    return [textwrap.dedent(block) for block in BLOCK.findall(text)]


def run_page(
    page: str,
    names: dict[str, Any] | None = None,
    *,
    edit: Callable[[str], str] = str,
    after: Callable[[], object] = lambda: None,
) -> dict[str, Any]:
    """Run the blocks of a page one after the other, edited before, a call after; return names."""
    names = {"__name__": "page"} | (names or {})
    for number, block in enumerate(blocks(page)):
        exec(compile(edit(block), f"{page}, block {number}", "exec"), names)
        after()
    return names
