"""Measured tables: pages say what their files say, and the files what the commands measure."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from rich.table import Table

from benchmarks.printing import cells
from docs import tables
from docs.walking_tables import WALKS

ROOT = Path(__file__).resolve().parents[2]
MEASURED = sorted(path.stem for path in tables.FOLDER.iterdir())


def test_pages_say_what_their_files_say() -> None:
    found: list[str] = []
    for page in (ROOT / "README.md", *(ROOT / "docs").glob("*.md")):
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
    assert "python -m docs.tables\n" in bench


@pytest.mark.long
def test_measured_again_a_table_is_the_same(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("mujoco", reason="the table is of MuJoCo: pip install 'surefoot[sim]'")
    kept = tables.markdown("against_mujoco").split("\n(")[0]  # without command, date and machine
    monkeypatch.setattr(tables, "FOLDER", tmp_path)
    monkeypatch.chdir(tmp_path)  # the command writes pictures
    tables.measure(["against_mujoco"])
    assert tables.markdown("against_mujoco").split("\n(")[0] == kept
    page = f"a\n{tables.markdown('against_mujoco')}\nb"
    assert tables.filled(page) == page
    assert tables.filled(page.replace("|", "| wrong |", 1)) == page


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
    tables.measure(["bipeds"], [told])
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


def test_several_commands_are_told_by_several_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tables, "FOLDER", tmp_path / "tables")
    told = []
    for k, goal in enumerate(("0.410 m", "0.233 m", "-357 deg")):
        told.append(tmp_path / f"{k}.json")
        told[-1].write_text(json.dumps({"status": "solved", "goal": goal, "law_residual": 9.9e-9}))
    tables.measure(["plans"], told)
    shown = tables.markdown("plans")
    assert "| `jump-up 0.2` | solved | 0.233 m | 9.9e-09 |" in shown
    assert "(`surefoot plan jump 0.4 --no-video --no-report`; `surefoot plan jump-up 0.2" in shown


def test_a_file_is_for_the_tables_of_one_command(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tables, "measure", lambda names, told: pytest.fail("measured"))
    monkeypatch.setattr("sys.argv", ["tables", "rigid", "contact", "--told", "x.json"])
    with pytest.raises(SystemExit):
        tables.main()


def test_a_command_that_prints_nothing_is_told() -> None:
    with pytest.raises(RuntimeError, match="unrecognized arguments"):
        tables.answer("python -m docs.tables --nonsense", as_json=False)


def test_a_table_without_a_file_keeps_what_stands_in_its_place(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tables, "FOLDER", tmp_path)
    page = "<!-- table race -->\nas before\n<!-- end of table -->"
    assert tables.filled(page) == page


def _printed(title: str, columns: tuple[str, ...], *rows: tuple[str, ...]) -> list[dict[str, object]]:
    table = Table(*columns, title=title)
    for row in rows:
        table.add_row(*row)
    return [cells(table)]


def test_rows_of_printed_tables() -> None:
    columns = ("road", "bias, exact slope", "bias, smoothed loss", "spread of a sample", "wrong way")
    told = [
        table
        for task in ("ball", "hopper")
        for table in _printed(
            f"{task}: slopes at 21 points", columns, ("penalty", "7 %", "8 %", f"{len(task)} %", "1.5 %")
        )
    ]
    assert tables.TABLES["bias"].rows(told) == [["penalty", "7", "7"]]
    assert tables.TABLES["scatter"].rows(told) == [["penalty", "4 / 1.5", "6 / 1.5"]]
    columns = ("friction", "status", "CPU s", "iterations", "cost", "off with feedback")
    cost = ("RoundCone()", "solved", "2.0", "700", "0.3", "6e-8")
    told = _printed("friction in space: both", columns, cost)
    row = ["RoundCone()", "solved", "700", "0.3", "2.0", "6e-8"]
    assert tables.TABLES["direct_friction"].rows(told) == [row]


def test_rows_of_loads_stand_beside_each_other() -> None:
    columns = (
        "walk", "observer", "walked", "lawful", "lean [deg]", "after 2 s", "velocity off [m/s]", "slip [mm]",
        "found [kg]", "at [m]",
    )  # fmt: skip
    off = ("5 kg", "off", "1/1", "0/1", "7.6", "7.1", "0.010", "3.0", "", "")
    on = ("5 kg", "on", "1/1", "1/1", "1.2", "0.3", "0.004", "0.2", "4.92", "(0.1, 0.08)")
    told = _printed("payloads: 1 seeds", columns, off, on)
    row = ["5 kg", "1/1, 1/1", "0/1, 1/1", "7.6, 1.2", "7.1, 0.3", "0.010, 0.004", "3.0, 0.2"]
    rows = tables.TABLES["payloads"].rows([told, told])
    assert rows == [["5 kg, 20 seeds", *row[1:], "4.92 kg at (0.1, 0.08)"]]


def test_rows_of_contact_solvers() -> None:
    def run(problem: str, solver: str, fresh: float | None) -> dict[str, object]:
        solved = fresh is not None
        return {
            "problem": problem, "family": problem[0], "contacts": 1, "solver": solver, "seconds": fresh,
            "residual": 1e-10, "solved": solved, "p99": fresh, "fresh": fresh, "fresh_p99": fresh,
        }  # fmt: skip

    runs = [run(p, "auto", 4e-6) for p in ("a", "b")] + [run(p, "contact solver", 2e-6) for p in ("a", "b")]
    runs += [run("a", "pinocchio pgs", 8e-6), run("b", "pinocchio pgs", None)]
    told = {"tol": 1e-9, "runs": runs}
    assert tables.TABLES["contact"].rows(told) == [
        ["`ContactSolver`", "2 of 2", "2.0", "2.0"],
        ["`auto` (`ContactProblem` and `solve`)", "2 of 2", "4.0", "4.0"],
        ["pinocchio pgs", "1 of 2", "8.0", "8.0"],
    ]
    assert tables.TABLES["families"].rows(told) == [
        ["a", "2.0", "2.0", "4.00", "4.00"],
        ["b", "2.0", "2.0", "no rival", ""],
        ["all", "2.0", "2.0", "4.00", "4.00"],
    ]


def test_rows_of_walks_tell_the_commanded_component() -> None:
    still = {"commanded": 0.0, "measured": 0.001}
    told = [
        {
            "velocity": {"forward": still, "left": still, "turn": {"commanded": 0.8, "measured": 0.8004}},
            "feet": [{"slip": 1e-4}, {"slip": 2.3e-4}],
            "laws_broken": [],
            "climb": -1.0,
        }
    ] * len(WALKS)
    rows = tables.TABLES["walks"].rows(told)
    assert rows[3] == ["`go2 --velocity 0,0,0.8 --duration 20`", "0.800 rad/s", "0.23 mm", "kept"]
    assert rows[5][1] == "0.800 rad/s, 1.0 m down"
