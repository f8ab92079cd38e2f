"""Tables of benchmarks, for people and as JSON."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from benchmarks.printing import report


def test_a_record_is_printed_and_kept(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    report({"a": float("nan")}, True, lambda console: console.print("words"), out=tmp_path, name="x")
    said = capsys.readouterr()
    assert json.loads(said.out) == {"a": None}
    (folder,) = tmp_path.iterdir()
    assert json.loads((folder / "x.json").read_text()) == {"a": None}
    assert said.err.startswith("written: ")
    report({}, False, lambda console: console.print("words" * 30), width=200)
    assert capsys.readouterr().out.splitlines() == ["words" * 30]
