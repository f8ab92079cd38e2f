"""Tables of benchmarks, for people and as JSON."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from rich.table import Table

from benchmarks.printing import cells, options, report, show, table


def _table() -> Table:
    table = Table("solver", "time [µs]", title="two solvers")
    table.add_row("ours", "1.0")
    table.add_row("theirs", "2.0")
    return table


def test_as_json_all_tables_are_one_list(capsys: pytest.CaptureFixture[str]) -> None:
    show((_table() for _ in range(2)), as_json=True)
    first, second = json.loads(capsys.readouterr().out)
    assert first == second
    assert first == {
        "title": "two solvers",
        "columns": ["solver", "time [µs]"],
        "rows": [["ours", "1.0"], ["theirs", "2.0"]],
    }


def test_for_people_they_are_printed(capsys: pytest.CaptureFixture[str]) -> None:
    show([_table()])
    said = capsys.readouterr().out
    assert "two solvers" in said
    assert "theirs" in said


def test_numbers_are_flush_right_and_texts_left() -> None:
    shown = table(("who", "time", "why"), [("ours", "1.0", "it is")], "a title", texts=["why"])
    assert [column.justify for column in shown.columns] == ["left", "right", "left"]
    assert cells(shown)["rows"] == [["ours", "1.0", "it is"]]


def test_a_record_is_printed_and_kept(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = report({"a": float("nan")}, True, lambda console: console.print("words"), out=tmp_path, name="x")
    said = capsys.readouterr()
    assert json.loads(said.out) == {"a": None}
    assert folder is not None
    assert json.loads((folder / "x.json").read_text()) == {"a": None}
    assert said.err.startswith("written: ")
    assert report({}, False, lambda console: console.print("words" * 30), width=200) is None
    assert capsys.readouterr().out.splitlines() == ["words" * 30]


def test_programs_share_their_options() -> None:
    given = options("about", "little", seeds=3, duration=2.0).parse_args(["--quick", "--only", "a"])
    assert vars(given) == {"quick": True, "json": False, "seeds": 3, "duration": 2.0, "only": "a"}
    assert set(vars(options(None, "little").parse_args([]))) == {"quick", "json"}
