"""What the bench of robots says of a robot: its feet, its lint, its walk, in a line that people can read."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

import pytest

from benchmarks.robots import trial
from benchmarks.robots.drawings import draw_foot
from tests.standing_biped import BOX, write_biped

FEET = "left_foot,right_foot"


def answers(monkeypatch: pytest.MonkeyPatch, *runs: tuple[int, str, str]) -> list[list[str]]:
    """Let commands answer in turn with exit code, output and errors; return the list of what was typed."""
    asked: list[list[str]] = []

    def run(words: list[str], **_: Any) -> subprocess.CompletedProcess[str]:
        asked.append(words)
        code, out, err = runs[len(asked) - 1]
        return subprocess.CompletedProcess(words, code, out, err)

    monkeypatch.setattr(trial.subprocess, "run", run)
    return asked


def test_a_robot_that_walks_is_not_asked_to_stand(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked = answers(monkeypatch, (0, json.dumps({"outcome": "walked", "laws_broken": []}), ""))
    one = trial.Candidate("box", str(write_biped(tmp_path, BOX)), FEET, "a box")
    found = trial.attempt(one, 2.0, lint=True)
    assert (found.walk, found.stand, found.code, found.errors) == ("walks", "", 0, {})
    assert found.feet.startswith("2: a sole of 200 x 100 mm")
    assert len(asked) == 1
    assert asked[0][-1] == FEET


def test_a_refusal_is_told_in_the_commands_own_words(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = str(write_biped(tmp_path, BOX))
    fell = json.dumps({"outcome": "fell", "duration": 1.234, "laws_broken": ["Coulomb"]})
    answers(monkeypatch, (2, "", f"surefoot: {path} has\nno feet"), (1, fell, "compiling"))
    found = trial.attempt(trial.Candidate("box", path, FEET), 2.0, lint=False)
    assert found.walk == "refused: biped.urdf has no feet"
    assert found.stand == "falls after 1.2 s, breaks: Coulomb"
    assert (found.code, found.errors) == (2, None)


def test_published_robots_are_those_that_are_there(tmp_path: Path) -> None:
    assert trial.published(tmp_path) == []
    file = tmp_path / "BoosterRobotics+booster_gym/resources/T1/T1_locomotion.urdf"
    file.parent.mkdir(parents=True)
    file.touch()
    (found,) = trial.published(tmp_path)
    assert found.name == "T1 (Booster Gym)"
    assert Path(found.robot) == file


def test_a_foot_is_drawn(tmp_path: Path) -> None:
    one = trial.Candidate("box", str(write_biped(tmp_path, BOX)), FEET)
    assert draw_foot(one, tmp_path).stat().st_size > 1000
