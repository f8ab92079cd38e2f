"""The docs' links and commands hold, and what the README promises is there."""

from __future__ import annotations

import doctest
import json
import re
import runpy
from pathlib import Path
from typing import Any

import pytest

from docs import front_page

ROOT = Path(__file__).resolve().parents[1]
BLOCK = re.compile(r"```python\n(.*?)```", re.DOTALL)
CHECK = runpy.run_path(str(ROOT / "docs" / "check.py"), run_name="check")


@pytest.mark.parametrize("page", CHECK["PAGES"], ids=lambda page: page.name)
def test_links_and_commands(page: Path) -> None:
    assert CHECK["broken_links"](page) == []
    assert CHECK["wrong_commands"](page) == []


@pytest.mark.long
@pytest.mark.parametrize("name", ["derivatives.md", "step-derivatives.md", "batches.md", "soft-contact.md"])
def test_shown_python_runs(name: str) -> None:
    failed, tried = doctest.testfile(
        str(ROOT / "docs" / name), module_relative=False, optionflags=doctest.NORMALIZE_WHITESPACE
    )
    assert tried > 5
    assert failed == 0


def test_the_check_finds_faults(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    page = tmp_path / "page.md"
    page.write_text("[x](none.md)\n```bash\nsurefoot stand --bogus\nsurefoot nope\n```\n")
    monkeypatch.setitem(CHECK["broken_links"].__globals__, "ROOT", tmp_path)
    assert len(CHECK["broken_links"](page)) == 1
    assert len(CHECK["wrong_commands"](page)) == 2


def test_what_counts_as_a_shown_command(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(
        "```python\nimport surefoot\n```\n`surefoot stand`, `surefoot bench walk --quick`, `surefoot.x`\n"
        "```bash\nsurefoot cone --mu 0.5   # as numbers\n"
        "surefoot check a.yaml \\\n  --mu 0.1  # exit code 1\nls\n```\n"
        "| `surefoot walk ...` | said |\n| --- | --- |\n| `go2 --seed 1` | x |\n| `a1`, `go1` | `y` |\n\n"
        "| other | z |\n| --- | --- |\n| `go2` | x |\n"
    )
    found = [(" ".join(shown.words), shown.code) for shown in CHECK["shown_commands"](page)]
    assert found == [
        ("cone --mu 0.5", 0),
        ("check a.yaml --mu 0.1", 1),
        ("bench walk --quick", 0),
        ("walk go2 --seed 1", 0),
        ("walk a1", 0),
        ("walk go1", 0),
    ]


def test_the_index_leads_to_four_shelves_and_not_to_lists() -> None:
    for page in (ROOT / "docs" / "README.md", ROOT / "docs" / "site" / "index.md"):
        links = [link for link in CHECK["LINK"].findall(page.read_text()) if link.endswith(".md")]
        assert {"learn", "do", "look-up", "understand"} <= {Path(link).stem for link in links}
        assert len(links) <= 10


def test_the_first_screen_of_the_readme() -> None:
    first = "\n".join((ROOT / "README.md").read_text().splitlines()[:40])
    assert "pip install" in first
    assert "make stand" in first
    assert "make test" in first
    assert "docs/images/pushed.webp" in first
    program = BLOCK.findall(first)[-1]
    assert len(program.strip().splitlines()) <= 10
    assert program.rstrip().endswith('sf.picture(verdict, "verdict.png")')


REFERENCE = {"settings.md", "glossary.md"}
"""Pages that are looked things up in: one is printed from the code, one has an entry for every term."""


@pytest.mark.parametrize("page", sorted((ROOT / "docs").glob("*.md")), ids=lambda page: page.name)
def test_a_page_is_short(page: Path) -> None:
    """What was measured, and history, go to docs/reports."""
    if page.name in REFERENCE:
        pytest.skip("a reference")
    text = page.read_text(encoding="utf-8")
    assert len(text.splitlines()) <= 150
    assert len(text.split()) <= 1200


def test_every_report_is_on_its_shelf_and_says_of_what_it_is() -> None:
    shelf = (ROOT / "docs" / "reports" / "README.md").read_text(encoding="utf-8")
    for report in (ROOT / "docs" / "reports").glob("*.md"):
        if report.name != "README.md":
            assert f"]({report.name})" in shelf
            assert "20" in report.read_text(encoding="utf-8")  # a date


def test_the_front_page_is_short() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    lines = text.splitlines()
    assert len(lines) <= 150
    assert max(map(len, lines)) <= 100
    assert len(text.split()) <= 700
    cells = [cell.strip() for line in lines if line.startswith("|") for cell in line.split("|")]
    assert max(map(len, cells)) <= 40


def test_what_the_front_page_makes_is_up_to_date(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert front_page.main(["--check"]) == 0, "run python -m docs.front_page"
    bars = front_page.groups(json.loads(front_page.TABLE.read_text(encoding="utf-8"))["rows"])
    assert len(bars) == 4
    for group in bars.values():
        assert [bar.ours for bar in group] == [True] + [False] * (len(group) - 1)
        assert len(group) >= 3
    page = tmp_path / "README.md"
    page.write_text((ROOT / "README.md").read_text())
    monkeypatch.setattr(front_page, "README", page)
    monkeypatch.setattr(front_page, "RELEASED", True)
    assert front_page.main(["--check"]) == 1
    assert "README.md is old" in capsys.readouterr().out
    front_page.main([])
    assert "pip install 'surefoot[all]'" in page.read_text()


def test_the_picture_of_the_rooms_is_up_to_date() -> None:
    drawing = runpy.run_path(str(ROOT / "docs" / "architecture.py"), run_name="drawing")
    assert drawing["main"](["--check"]) == 0, "run python docs/architecture.py"
    found = {p.parent.name for p in (ROOT / "src" / "surefoot").glob("*/__init__.py")}
    assert found == set(drawing["wings"]()), "a wing that import-linter does not know"


def test_the_code_of_the_architecture_page() -> None:
    page = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    (block,) = CHECK["BLOCK"].findall(page)
    names: dict[str, Any] = {}
    exec(block[1], names)
    assert names["solve_program"](names["program"]).x == pytest.approx([0.75, 0.0, 1.5], abs=1e-6)
