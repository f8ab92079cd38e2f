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


def test_a_long_table_takes_the_json_of_a_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    row = {
        "stack": "surefoot", "task": "g1-0.3", "must": True, "trials": 20, "survived": 19, "held": 18,
        "survival": {"low": 0.764, "high": 0.991}, "forward": 0.3012, "slip": 0.0004,
        "cost_of_transport": None,
        "torque_use": 0.7, "speed_use": 0.2, "step_us": 301.2, "step_p99_us": 900.0, "real_time": 1.24,
        "faults": {"law: a | b": 1},
    }  # fmt: skip
    other = {**row, "stack": "another"}, {**row, "task": "ice"}
    told = tmp_path / "told.json"
    told.write_text(json.dumps({"rows": [row, *other]}), encoding="utf-8")
    monkeypatch.setattr(tables, "FOLDER", tmp_path)
    tables.measure(["bipeds"], told)
    kept = json.loads((tmp_path / "bipeds.json").read_text(encoding="utf-8"))
    assert kept["rows"] == [
        [
            "`g1-0.3`*",
            "19/20 (76 to 99 %)",
            "18",
            "0.301",
            "0.4",
            "-",
            "0.70",
            "0.20",
            "301, 900",
            "1.2",
            "law: a / b: 1",
        ]
    ]
    assert kept["command"] == "surefoot bench stacks --stack surefoot --seeds 20"


def test_long_tables_are_measured_by_name_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[str] = []
    monkeypatch.setattr(tables, "measure", lambda names, told: asked.extend(names))
    monkeypatch.setattr("sys.argv", ["tables"])
    tables.main()
    assert "rigid" in asked
    assert not any(tables.TABLES[name].long for name in asked)
    monkeypatch.setattr("sys.argv", ["tables", "--told", "x.json"])
    with pytest.raises(SystemExit):
        tables.main()
