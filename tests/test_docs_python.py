"""The pages that show Python are run, block after block, and what they assert holds."""

from __future__ import annotations

from pathlib import Path

import pytest

from surefoot.contact.solvers import solver as solvers
from tests.pages import blocks, run_page

RUN = (
    "bodies.md", "contact-sets.md", "add-a-contact-law.md", "add-a-solver.md", "loads.md", "lab.md",
    "first-steps.md", "pictures.md", "certify.md", "many-environments.md", "mujoco-exact.md",
    "transfer.md",
    pytest.param("robot-loop.md", marks=pytest.mark.long),
    pytest.param("ros2-control.md", marks=pytest.mark.long),
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


def test_the_program_of_the_front_page_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its comment says what is printed, and its picture is there."""
    monkeypatch.chdir(tmp_path)
    (block,) = blocks("../README.md")
    names = run_page("../README.md")
    assert f"print(verdict)  # {names['verdict']}" in block
    assert (tmp_path / "verdict.png").stat().st_size > 20_000


def test_the_program_of_the_tour_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("mujoco", reason="the tour is of `surefoot[all]`")
    monkeypatch.chdir(tmp_path)

    def without_the_plan(block: str) -> str:
        return "\n".join(line for line in block.splitlines() if "sf.plan(" not in line)  # half a minute

    names = run_page("tour.md", edit=without_the_plan)
    assert names["solution"].status.name == "SOLVED"
    assert names["log"].fact("outcome") == "done"
    assert len(names["batch"].status) == 100
