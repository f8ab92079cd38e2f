"""The command behind the table of coverage, on one small set."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from benchmarks.identify_coverage import TRUTH, main


@pytest.mark.long
def test_coverage_is_counted_written_and_gone_on_with(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "rows.jsonl"
    main(["--sets", "1", "--tosses", "8", "--out", str(out)])
    (row,) = (json.loads(line) for line in out.read_text().splitlines())
    assert set(row) == set(TRUTH)
    assert all(low <= error <= high for error, low, high in row.values())
    main(["--sets", "1", "--tosses", "8", "--out", str(out)])
    assert len(out.read_text().splitlines()) == 1
    assert "of 1" in capsys.readouterr().out
