"""The Python that docs/sweeps.md shows, and the files that it names."""

from __future__ import annotations

from pathlib import Path

import pytest

from surefoot.worlds.sweep import read_sweep
from tests.pages import DOCS, blocks, run_page

pytest.importorskip("pyarrow", reason="tables are written by pyarrow: pip install -e '.[sweep]'")
EXAMPLES = DOCS.parent / "examples"


def test_the_page_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "examples").symlink_to(EXAMPLES)
    monkeypatch.chdir(tmp_path)
    names = run_page("sweeps.md")
    assert len(blocks("sweeps.md")) == 1
    assert names["result"].table.num_rows == 8
    assert names["result"].table["status"].to_pylist() == ["done"] * 8


@pytest.mark.parametrize("file", sorted((EXAMPLES / "sweeps").glob("*.yaml")), ids=lambda f: f.name)
def test_every_example_is_a_sweep(file: Path) -> None:
    assert read_sweep(file).space.drawn
