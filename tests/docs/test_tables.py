"""Measured tables: pages say what their files say, and the files what the commands measure."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from docs import tables

ROOT = Path(__file__).resolve().parents[2]
MEASURED = sorted(path.stem for path in tables.FOLDER.iterdir())


def test_pages_say_what_their_files_say() -> None:
    found: list[str] = []
    for page in (ROOT / "README.md", *(ROOT / "docs").glob("*.md"), *(ROOT / "docs/reports").glob("*.md")):
        text = page.read_text(encoding="utf-8")
        here = [match["name"] for match in tables.PLACE.finditer(text)]
        assert text.count("<!-- table ") == text.count("<!-- end of table -->") == len(here)
        assert {(tables.DOCS / tables.TABLES[name].page).resolve() for name in here} <= {page}
        assert tables.filled(text) == text, f"{page.name}: python -m docs.tables sets it"
        found += here
    assert sorted(found) == sorted(tables.TABLES)


def test_what_was_not_measured_does_not_say_so() -> None:
    assert set(MEASURED) <= set(tables.TABLES)
    for name in set(tables.TABLES) - set(MEASURED):
        text = (tables.DOCS / tables.TABLES[name].page).read_text(encoding="utf-8")
        (place,) = (found[0] for found in tables.PLACE.finditer(text) if found["name"] == name)
        assert not re.search(r"\d{4}-\d\d-\d\d", place), f"{name} was never measured"


@pytest.mark.parametrize("name", MEASURED)
def test_a_file_tells_its_command_and_date(name: str) -> None:
    kept = json.loads((tables.FOLDER / f"{name}.json").read_text(encoding="utf-8"))
    assert kept["command"] == tables.TABLES[name].command
    assert re.fullmatch(r"\d{4}-\d\d-\d\d", kept["date"])
    assert kept["columns"] == list(tables.TABLES[name].columns)
    assert kept["rows"]
    assert {len(row) for row in kept["rows"]} == {len(kept["columns"])}


def test_make_bench_writes_them() -> None:
    bench = (ROOT / "Makefile").read_text(encoding="utf-8").split("\nbench:")[1].split("\n\n")[0]
    assert "python -m docs.tables)\n" in bench


@pytest.mark.long
def test_measured_again_a_table_is_the_same(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("mujoco", reason="the table is of MuJoCo: pip install -e '.[sim]'")
    kept = tables.markdown("against_mujoco").split("\n(")[0]  # without command, date and machine
    monkeypatch.setattr(tables, "FOLDER", tmp_path)
    monkeypatch.chdir(tmp_path)  # the command writes pictures
    tables.measure(["against_mujoco"])
    assert tables.markdown("against_mujoco").split("\n(")[0] == kept
    page = f"a\n{tables.markdown('against_mujoco')}\nb"
    assert tables.filled(page) == page
    assert tables.filled(page.replace("|", "| wrong |", 1)) == page
