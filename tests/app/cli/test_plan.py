"""`surefoot plan` on the command line: what it prints and leaves, and what it refuses in one line."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from surefoot.app.cli.main import main
from surefoot.mechanics.robot import load_robot, place
from surefoot.motion.planning import Plan

pytest.importorskip("casadi")


def test_a_ball_is_planned_and_saved(tmp_path: Path, answer: Any) -> None:
    facts = answer("plan", "ball", "--out", tmp_path)
    assert {"status", "cost", "law_residual", "iterations", "time", "contacts", "executed"} <= set(facts)
    assert facts["status"] == "solved"
    assert facts["law_residual"] <= 1e-8
    folder = Path(facts["folder"])
    assert {p.name for p in folder.iterdir()} >= {"plan.npz", "summary.json", "report.html", "contacts.png"}
    again = Plan.read(folder / "plan.npz")
    assert again.task == "ball"
    assert again.status.value == "solved"


@pytest.mark.long
def test_a_jump_is_planned_in_words(tmp_path: Path, printed: Any) -> None:
    pose = tmp_path / "pose.json"
    pose.write_text(json.dumps(place(load_robot("go2"), at=(0.1, 0.0)).tolist()))
    shown = ["--no-video", "--no-report", "--out", str(tmp_path), "--start", str(pose), "--over", "0.05"]
    said = printed("plan", "jump", "--dt", "0.02", *shown)
    assert "jump: solved" in said
    assert "the feet get 0.50" in said
    assert "FL_foot" in said
    (found,) = tmp_path.glob("plan-jump-*/plan.npz")
    assert main(["plan", "jump", "--dt", "0.02", "--near", str(found), "--max-iterations", "6", *shown]) == 0


def test_what_is_not_solved_is_exit_code_1(tmp_path: Path, printed: Any) -> None:
    shown = ["--no-video", "--no-report", "--out", str(tmp_path), "--max-iterations", "3"]
    said = printed("plan", "jump", "0.2", "--dt", "0.02", *shown, code=1)
    assert "the optimiser ended with Maximum_Iterations_Exceeded" in said
    assert "jump: solved" not in said
    assert list(tmp_path.glob("plan-jump-*/plan.npz"))
