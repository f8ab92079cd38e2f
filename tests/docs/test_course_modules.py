"""A course page may need what not every Python has; its header says so."""

from __future__ import annotations

from pathlib import Path

import pytest

from docs.course import pages

pytest.importorskip("jupytext", reason="the pages are notebooks: pip install -e '.[course]'")


@pytest.mark.parametrize(
    ("named", "missing"),
    [("modules:\n- numpy\n", ""), ("modules:\n- numpy\n- not_there\n", "not_there"), ("", "")],
)
def test_a_page_says_which_module_it_lacks(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, named: str, missing: str
) -> None:
    monkeypatch.setattr(pages, "COURSE", tmp_path)
    (tmp_path / "en").mkdir()
    head = f"---\nkernelspec:\n  display_name: Python 3\n  name: python3\n{named}---\n"
    (tmp_path / "en" / "mini.md").write_text(head + "\n# Mini\n\nmodules:\n- never_there\n")
    assert pages.missing("mini") == missing


def test_the_page_that_compares_solvers_needs_ecos() -> None:
    text = pages.source("table-facets", "en").read_text(encoding="utf-8")
    assert "modules:\n- ecos\n" in text
