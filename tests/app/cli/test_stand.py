from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from surefoot.app.cli.main import main
from surefoot.records.log.reading import read_log

QUIET = ["--no-video", "--no-report"]


def test_stand_writes_everything(tmp_path: Path, printed: Any) -> None:
    said = printed("stand", "go2", "--duration", "0.5", "--out", tmp_path, "--no-video")
    assert "go2 stood for 0.50 s and no law was broken" in said
    (folder,) = tmp_path.iterdir()
    assert {path.stem for path in folder.glob("*.png")} >= {"normal_forces", "cone_use", "base", "torques"}
    assert {path.name for path in folder.iterdir()} >= {"log.npz", "summary.json", "report.html"}
    assert json.loads((folder / "summary.json").read_text())["stood"] is True


@pytest.mark.long
def test_a_stand_of_which_nothing_is_asked_shows_cones_at_work(tmp_path: Path, answer: Any) -> None:
    summary = answer("stand", "go2", "--out", tmp_path, *QUIET)
    assert [phase["phase"] for phase in summary["statics"]] == ["stance", "with FL_foot lifted"]
    assert max(foot["cone_use_max"] for foot in summary["feet"][1:]) > 0.5
    log = read_log(next(tmp_path.iterdir()) / "log.npz")
    times = log["time"]
    normal = log["forces"].reshape(times.size, -1, 3)[:, 0]
    assert np.linalg.norm(normal[(times > 2.5) & (times < 3.5)], axis=1).max() == 0.0
    again = answer("stand", "go2", "--mu", "0.3", "--duration", "0.1", "--out", tmp_path, *QUIET)
    assert [phase["phase"] for phase in again["statics"]] == ["stance"]


def test_each_run_gets_a_new_folder(tmp_path: Path) -> None:
    for _ in range(2):
        main(["stand", "--duration", "0.1", "--out", str(tmp_path), "--no-video", "--json"])
    assert len(list(tmp_path.iterdir())) == 2


def test_impossible_slope_is_told_not_run(tmp_path: Path, printed: Any, answer: Any) -> None:
    said = printed("stand", "--slope", "35", "--mu", "0.6", "--out", tmp_path, code=1)
    assert "not possible with friction 0.6; 0.70 would be needed" in said
    assert not list(tmp_path.iterdir())
    facts = answer("stand", "--slope", "35", "--mu", "0.6", "--out", tmp_path, code=1)
    assert (facts["stood"], facts["outcome"]) == (False, "impossible")
    assert facts["statics"][0]["friction_needed"] == pytest.approx(0.7002, abs=1e-3)


@pytest.mark.long
def test_anyway_runs_and_is_honest(tmp_path: Path, answer: Any) -> None:
    options = ["--slope", "35", "--mu", "0.6", "--anyway", "--duration", "2", "--no-video"]
    summary = answer("stand", *options, "--out", tmp_path, code=1)
    assert summary["outcome"] in ("slipped", "fell")
    assert summary["stood"] is False


@pytest.mark.long
def test_without_a_gl_the_run_finishes(tmp_path: Path, printed: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    import mujoco

    def broken(*arguments: object, **options: object) -> None:
        raise RuntimeError("no display")

    monkeypatch.setattr(mujoco, "Renderer", broken)
    said = printed("stand", "--duration", "0.2", "--out", tmp_path)
    assert "no pictures: MuJoCo found no OpenGL to draw with (no display)" in said


@pytest.mark.parametrize("name", ["talos", "icub"])
def test_humanoids_stand(name: str, tmp_path: Path, answer: Any) -> None:
    assert answer("stand", name, "--duration", "0.3", "--out", tmp_path, "--no-video")["stood"]


def test_the_rigid_world_puts_the_same_load_on_each_foot_and_breaks_no_law(
    tmp_path: Path, answer: Any
) -> None:
    loads = []
    for world in ("mujoco", "rigid"):
        options = ["--world", world, "--duration", "1", "--slope", "5", "--push", "0.2:40,0,0:0.1", *QUIET]
        found = answer("stand", "go2", *options, "--out", tmp_path / world)
        assert (found["stood"], found["laws_broken"]) == (True, [])
        loads.append([foot["normal_force_mean"] for foot in found["feet"]])
    np.testing.assert_allclose(*loads, rtol=0.02)
    assert sum(loads[1]) == pytest.approx(16.085 * 9.81 * math.cos(math.radians(5.0)), rel=0.01)
    assert read_log(next(tmp_path.glob("rigid/*/log.npz")))["gaps"].min() > -1e-5


def test_statics_count_where_the_payload_is(tmp_path: Path, answer: Any) -> None:
    possible = []
    for place in ("30@0,0,0", "30@0,1,0"):
        options = ["--payload", place, "--duration", "0.3", *QUIET, "--out", tmp_path]
        possible.append(answer("stand", "go2", *options, code=1)["statics"][0]["possible"])
    assert possible == [True, False]
