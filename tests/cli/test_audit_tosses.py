"""`surefoot audit` of a file of tosses: what it prints, its JSON and exit codes."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from benchmarks.problems.tosses import random_tosses
from surefoot.cli.main import main
from surefoot.estimation.tosses import write_tosses


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("tosses")
    tosses = random_tosses(16, [0.2, 0.1, 0.05], seed=0)
    write_tosses(tosses, place / "lawful.npz")
    tosses.states[tosses.starts[2] + 4, 0] += 0.001
    write_tosses(tosses, place / "stray.npz")
    write_tosses(tosses.subset([0, 1]), place / "few.npz")
    return place


@pytest.mark.long
def test_json_and_exit_codes(folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["audit", str(folder / "lawful.npz"), "--json"]) == 0
    facts = json.loads(capfd.readouterr().out)
    assert (facts["verdict"], facts["violations"], facts["frames"]) == ("lawful", [], 1760)
    assert set(facts["laws"]) == {"penetration", "flight", "spin", "pull", "friction"}
    assert main(["audit", str(folder / "stray.npz"), "--json"]) == 1
    facts = json.loads(capfd.readouterr().out)
    assert facts["verdict"] == "broken"
    assert list(facts["tosses"]) == ["2"]
    worst = max(facts["violations"], key=lambda v: v["value"] / v["limit"])
    assert (worst["law"], worst["contact"], worst["unit"]) == ("flight", "cube", "N")
    assert worst["start"] <= 4.5 / 148.0 <= worst["end"] + 1 / 148.0


def test_tables_and_report(folder: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["audit", str(folder / "stray.npz"), "--out", str(tmp_path)]) == 1
    out = capfd.readouterr().out
    for word in ("flight", "friction", "noise in free flight", "taken as displaced", "broken:"):
        assert word in out
    (page,) = tmp_path.glob("audit-stray-*/report.html")
    assert "broken:" in page.read_text()
    assert json.loads((page.parent / "audit.json").read_text())["verdict"] == "broken"
