"""The pages that show Python are run, block after block, and what they assert holds."""

from __future__ import annotations

import pytest

from surefoot.solvers import solver as solvers
from tests.pages import blocks, run_page

RUN = (
    "bodies.md", "contact-sets.md", "add-a-contact-law.md", "add-a-solver.md", "loads.md", "lab.md",
)  # fmt: skip
"""Pages whose blocks are one program."""


@pytest.mark.parametrize("page", RUN)
def test_the_page_runs(page: str) -> None:
    before = set(solvers.registry())
    assert sum(block.count("assert ") for block in blocks(page)) >= 2
    try:
        run_page(page)
    finally:
        for added in set(solvers.registry()) - before:
            solvers.registry().pop(added)
