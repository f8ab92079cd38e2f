"""The pages that show Python are run, block after block, and what they assert holds."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from surefoot.solvers import solver as solvers

DOCS = Path(__file__).resolve().parents[1] / "docs"
RUN = ("contact-sets.md", "add-a-contact-law.md", "add-a-solver.md")
"""Pages whose blocks are one program."""
BLOCK = re.compile(r"```python\n(.*?)```", re.DOTALL)


@pytest.mark.parametrize("page", RUN)
def test_the_page_runs(page: str) -> None:
    before = set(solvers.registry())
    blocks = BLOCK.findall((DOCS / page).read_text(encoding="utf-8"))
    assert sum(block.count("assert ") for block in blocks) >= 2
    names: dict[str, Any] = {"__name__": "page"}
    try:
        for number, block in enumerate(blocks):
            exec(compile(block, f"{page}, block {number}", "exec"), names)
    finally:
        for added in set(solvers.registry()) - before:
            solvers.registry().pop(added)
