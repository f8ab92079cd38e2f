"""`surefoot sweep`: exit codes, JSON, going on after an interrupt."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("pyarrow", reason="tables are written by pyarrow: pip install -e '.[sweep]'")
BALLS = """
experiment: drop
samples: 30
settings: {body: ball, dt: 0.01, duration: 0.1}
ranges: {mu: [0.1, 1.0], restitution: [0, 0.5], terrain: [flat, "slope:10"]}
"""


@pytest.fixture
def balls(tmp_path: Path) -> Path:
    file = tmp_path / "balls.yaml"
    file.write_text(BALLS)
    return file


def test_table_pictures_and_json(balls: Path, tmp_path: Path, printed: Any, answer: Any) -> None:
    words = ["sweep", str(balls), "--out", str(tmp_path / "a"), "--backend", "serial"]
    facts = answer(*words)
    assert (facts["samples"], facts["done"], facts["errors"], facts["resumed"]) == (30, 30, 0, 0)
    assert sum(one["samples"] for one in facts["parameters"]["mu"]) == 30
    assert set(facts["parameters"]) == {"mu", "restitution", "terrain"}
    assert all(one["medians"]["force_max"] >= 0.0 for one in facts["parameters"]["terrain"])
    assert facts["share"]["low"] <= facts["share"]["value"] <= facts["share"]["high"]
    assert [Path(p).name for p in facts["pictures"]] == ["survival.png", "survival-map.png"]
    assert all(Path(p).stat().st_size > 5000 for p in facts["pictures"])
    said = printed(*words, "--no-picture")
    assert "0 samples in" in said
    assert "30 were there before" in said
    assert "rested over" in said


def test_samples_with_errors_are_told(
    tmp_path: Path, balls: Path, printed: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    from surefoot.base.errors import SimulationError
    from surefoot.worlds.sweep.drop import DropExperiment

    def fail(self: DropExperiment, seed: int) -> None:
        raise SimulationError("motion", 0.1, 1e-3, "root_joint", 1e9)

    monkeypatch.setattr(DropExperiment, "run", fail)
    words = ["sweep", str(balls), "--out", str(tmp_path / "a"), "--backend", "serial"]
    said = printed(*words, code=1)
    assert "no sample is done" in said
    assert "30 errors, 0 crashed; sample 0: at 0.1 s the motion became non-finite" in said


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
@pytest.mark.long
def test_an_interrupt_keeps_what_is_written(
    number: signal.Signals, code: int, tmp_path: Path, answer: Any
) -> None:
    file = tmp_path / "many.yaml"
    file.write_text(BALLS.replace("samples: 30", "samples: 3000"))
    words = ["sweep", str(file), "--out", str(tmp_path / "a"), "--backend", "serial"]
    process = subprocess.Popen([sys.executable, "-m", "surefoot", *words, "--json"], stderr=subprocess.PIPE)
    rows, deadline = tmp_path / "a" / "sweep.sqlite", time.monotonic() + 120.0
    while not rows.exists() or rows.stat().st_size < 20_000:
        assert time.monotonic() < deadline
        assert process.poll() is None
        time.sleep(0.02)
    os.kill(process.pid, number)
    _, said = process.communicate(timeout=60)
    assert process.returncode == code
    assert b"the same command goes on from there" in said
    assert b"Traceback" not in said
    assert [p.name for p in (tmp_path / "a").iterdir()] == ["sweep.sqlite"]
    facts = answer(*words, "--no-picture")
    assert facts["samples"] == 3000
    assert 0 < facts["resumed"] < 3000
