"""`surefoot worlds`: tables, JSON, picture, exit codes."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from surefoot.app.cli import worlds
from surefoot.worlds.drake.drake_python import VARIABLE
from surefoot.worlds.experiments import EXPERIMENTS
from surefoot.worlds.experiments.experiment import Measured, MeasuredQuantity, WorldExperiment


def test_rigid_world_slides_as_it_should(answer: Callable[..., Any]) -> None:
    found = answer("worlds", "slide", "--world", "rigid")
    row = found["experiments"]["slide"]["rows"][0]
    assert found["agrees"]
    assert row["exact"] == pytest.approx(2.0**2 / (2.0 * 0.4 * 9.81), rel=1e-12)
    assert row["error"] <= row["tolerance"]


def test_tables_are_printed(printed: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "140")
    out = printed("worlds", "drop", "--world", "rigid")
    assert "drop: A ball of 2 kg falls 0.5 m and stays." in out
    assert "gap at rest [m]" in out
    assert "3 of 3 quantities within their world's own step error" in out


def test_a_world_that_does_not_keep_to_it_is_exit_1(
    answer: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    def wrong(world: str, dt: float) -> Measured:
        return (MeasuredQuantity("x", "m", 2.0, 1.0),)

    made = EXPERIMENTS["drop"]
    monkeypatch.setitem(EXPERIMENTS, "drop", WorldExperiment("drop", made.says, made.compares, wrong))
    found = answer("worlds", "drop", "--world", "rigid", code=1)
    assert found["experiments"]["drop"]["rows"][0]["verdict"] == "differs"


def test_absent_worlds_are_one_line_each(
    answer: Callable[..., Any], printed: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv(VARIABLE, raising=False)
    if importlib.util.find_spec("pydrake") is not None:
        pytest.skip("Drake is here")
    found = answer("worlds", "drop", "--world", "rigid", "--world", "drake")
    assert found["worlds"] == ["rigid"]
    assert "pip install -e '.[drake]'" in found["absent"]["drake"]
    said = printed("worlds", "drop", "--world", "drake", code=2)
    assert "drake is not installed; run: pip install -e '.[drake]'" in said
    options = ("--world", "drake", "--no-video", "--no-report")
    assert "drake is not installed" in printed("stand", "go2", *options, code=2)


def test_help_names_every_experiment() -> None:
    assert worlds.NAMES.split(", ") == list(EXPERIMENTS)


@pytest.mark.long
def test_engines_at_their_defaults(
    answer: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """MuJoCo's pyramid lets a slide at 45 degrees go sqrt(2) as far; tuned and exact cones do not."""
    pytest.importorskip("mujoco")
    monkeypatch.delenv("SUREFOOT_NEWTON_PYTHON", raising=False)
    words = ["--defaults", "--world", "mujoco", "--world", "rigid", "--world", "newton"]
    found = answer("worlds", "slide", "slide at 45 deg", *words, "--out", tmp_path)
    error = {(row["engine"], row["case"]): row["error"] for row in found["rows"]}
    assert error["mujoco", "slide at 45 deg"] == pytest.approx(2.0**0.5 - 1.0, abs=0.02)
    assert error["mujoco", "slide"] < 0.01
    assert error["mujoco tuned", "slide at 45 deg"] < 0.01
    assert error["rigid", "slide at 45 deg"] < 1e-5
    assert all(row["cost"] > 0.0 for row in found["rows"])
    assert "SUREFOOT_NEWTON_PYTHON" in found["absent"]["newton"]
    (picture,) = tmp_path.glob("*/defaults.png")
    assert picture.stat().st_size > 10_000
