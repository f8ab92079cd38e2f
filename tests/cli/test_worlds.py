"""`surefoot worlds`: tables, JSON, pictures, exit codes."""

from __future__ import annotations

import importlib.util
import json
from pathlib import Path
from typing import Any

import pytest

from surefoot.cli import worlds
from surefoot.cli.main import main
from surefoot.experiments import EXPERIMENTS
from surefoot.experiments.experiment import ComparedQuantity, Curve, Measurement, WorldExperiment
from surefoot.simulation.drake_python import VARIABLE


def asked(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, dict[str, Any]]:
    code = main(["worlds", *words, "--json"])
    return code, json.loads(capsys.readouterr().out)


def test_rigid_world_slides_as_it_should(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    code, found = asked(capsys, "slide", "--world", "rigid", "--out", str(tmp_path))
    row = found["experiments"]["slide"]["rows"][0]
    assert code == 0
    assert found["agrees"]
    assert row["exact"] == pytest.approx(2.0**2 / (2.0 * 0.4 * 9.81), rel=1e-12)
    assert row["error"] <= row["tolerance"]
    picture = Path(found["pictures"][0])
    assert picture.parent.parent == tmp_path
    assert picture.stat().st_size > 10_000


def test_several_experiments_get_an_overview(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    code, found = asked(capsys, "drop", "slide", "--world", "rigid", "--out", str(tmp_path))
    assert code == 0
    assert [Path(p).name for p in found["pictures"]] == ["drop.png", "slide.png", "overview.png"]
    assert Path(found["pictures"][-1]).stat().st_size > 10_000


def test_tables_are_printed(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "140")
    assert main(["worlds", "drop", "--world", "rigid", "--no-pictures"]) == 0
    out = capsys.readouterr().out
    assert "drop: A ball of 2 kg falls 0.5 m and stays." in out
    assert "gap at rest [m]" in out
    assert "3 of 3 quantities within their world's own step error" in out


def test_a_world_that_does_not_keep_to_it_is_exit_1(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def wrong(world: str, dt: float) -> Measurement:
        import numpy as np

        return Measurement((2.0,), (ComparedQuantity("x", "m", 1.0),), Curve(np.zeros(2), np.zeros(2)))

    made = EXPERIMENTS["drop"]
    monkeypatch.setitem(
        EXPERIMENTS, "drop", WorldExperiment("drop", made.says, made.compares, wrong, made.theory, made.axes)
    )
    code, found = asked(capsys, "drop", "--world", "rigid", "--no-pictures")
    assert code == 1
    assert found["experiments"]["drop"]["rows"][0]["verdict"] == "differs"


def test_absent_worlds_are_one_line_each(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv(VARIABLE, raising=False)
    if importlib.util.find_spec("pydrake") is not None:
        pytest.skip("Drake is here")
    code, found = asked(capsys, "drop", "--world", "rigid", "--world", "drake", "--no-pictures")
    assert code == 0
    assert found["worlds"] == ["rigid"]
    assert "pip install -e '.[drake]'" in found["absent"]["drake"]
    assert main(["worlds", "drop", "--world", "drake"]) == 2
    assert "drake is not installed; run: pip install -e '.[drake]'" in capsys.readouterr().err
    assert main(["stand", "go2", "--world", "drake", "--no-video", "--no-report"]) == 2
    assert "drake is not installed" in capsys.readouterr().err


def test_help_names_every_experiment() -> None:
    assert worlds.NAMES.split(", ") == list(EXPERIMENTS)
