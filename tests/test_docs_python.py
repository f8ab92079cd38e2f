"""The pages that show Python are run, block after block, and what they assert holds."""

from __future__ import annotations

from pathlib import Path

import pytest

from surefoot.solvers import solver as solvers
from tests.pages import blocks, run_page

RUN = (
    "bodies.md", "contact-sets.md", "add-a-contact-law.md", "add-a-solver.md", "loads.md", "lab.md",
    "first-steps.md",
)  # fmt: skip
"""Pages whose blocks are one program."""


@pytest.mark.parametrize("page", RUN)
def test_the_page_runs(page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)  # where pages save what they make
    before = set(solvers.registry())
    assert sum(block.count("assert ") for block in blocks(page)) >= 2
    try:
        run_page(page)
    finally:
        for added in set(solvers.registry()) - before:
            solvers.registry().pop(added)
