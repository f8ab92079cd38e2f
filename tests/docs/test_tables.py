"""Measured tables: pages say what their files say, and the files what the commands measure."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from docs import tables

ROOT = Path(__file__).resolve().parents[2]


def test_pages_say_what_their_files_say() -> None:
    found: set[str] = set()
    for page in (ROOT / "docs").glob("*.md"):
        text = page.read_text(encoding="utf-8")
        found |= {match["name"] for match in tables.PLACE.finditer(text)}
        assert tables.filled(text) == text, f"{page.name}: python -m docs.tables sets it"
    assert found == set(tables.TABLES) == {path.stem for path in tables.FOLDER.iterdir()}


@pytest.mark.parametrize("name", tables.TABLES)
def test_a_file_tells_its_command_and_date(name: str) -> None:
    kept = json.loads((tables.FOLDER / f"{name}.json").read_text(encoding="utf-8"))
    assert kept["command"] == f"surefoot {tables.TABLES[name].command}"
    assert re.fullmatch(r"\d{4}-\d\d-\d\d", kept["date"])
    assert kept["columns"] == list(tables.TABLES[name].columns)
    assert kept["rows"]
    assert {len(row) for row in kept["rows"]} == {len(kept["columns"])}


def test_make_bench_writes_them() -> None:
    bench = (ROOT / "Makefile").read_text(encoding="utf-8").split("\nbench:")[1].split("\n\n")[0]
    assert "python -m docs.tables\n" in bench


def test_measured_again_a_table_is_the_same(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("mujoco", reason="the table is of MuJoCo: pip install 'surefoot[sim]'")
    kept = tables.markdown("solref").split("\n(")[0]  # without command, date and machine
    monkeypatch.setattr(tables, "FOLDER", tmp_path)
    monkeypatch.chdir(tmp_path)  # the command writes pictures
    tables.measure(["solref"])
    assert tables.markdown("solref").split("\n(")[0] == kept
    page = f"a\n{tables.markdown('solref')}\nb"
    assert tables.filled(page) == page
    assert tables.filled(page.replace("| 0.02 |", "| 0.03 |")) == page
