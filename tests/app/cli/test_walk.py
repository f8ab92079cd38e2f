"""`surefoot walk` at the command line: files, JSON, exit codes."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from surefoot.app.cli.main import main
from surefoot.records.log.reading import read_log

QUICK = ("--duration", "1.2", "--no-video")
ALIKE = ("a1", "anymal_c", "b1", "go1", "hyq", "laikago")


def test_walk_writes_everything(tmp_path: Path, printed: Any) -> None:
    said = printed("walk", "go2", *QUICK, "--seed", "3", "--out", tmp_path)
    assert "go2 walked for 1.20 s" in said
    assert "no commanded force left its friction cone" in said
    (folder,) = tmp_path.iterdir()
    names = {path.name for path in folder.iterdir()}
    pictures = {"velocity", "footfalls", "cone_use", "normal_forces", "path", "torques"}
    assert {"log.npz", "summary.json", "report.html"} | {f"{p}.png" for p in pictures} <= names
    log = read_log(folder / "log.npz")
    assert log["planned"].shape == (1200, 4)
    assert log["command"].shape == (1200, 3)
    report = (folder / "report.html").read_text()
    assert "Footfalls" in report
    assert "The three laws" in report


@pytest.mark.parametrize("robot", ["centauro", "solo8", *ALIKE])
@pytest.mark.long
def test_every_quadruped_walks_as_a_new_user_calls_it(robot: str, tmp_path: Path, printed: Any) -> None:
    said = printed("walk", robot, "--duration", "2.0", "--no-video", "--no-report", "--out", tmp_path)
    assert f"{robot} walked for 2.00 s" in said
    assert "state estimate: velocity off by" in said


def test_an_impossible_speed_is_slowed_and_said(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    main(
        ["walk", "--duration", "0.5", "--no-video", "--no-report", "--velocity", "9", "--out", str(tmp_path)]
    )
    assert "is more than this gait can do: slowed to" in capfd.readouterr().out


@pytest.mark.long
def test_a_walk_finds_its_payload_and_says_so(tmp_path: Path, printed: Any) -> None:
    options = ["--duration", "2", "--no-video", "--no-report", "--out", str(tmp_path)]
    said = printed("walk", "go2", "--payload", "4@0.1,0.06,0.08", *options)
    assert "estimated: the base carries" in " ".join(said.split())
    load = json.loads(next(tmp_path.glob("*/summary.json")).read_text())["load"]
    assert load["mass"] == pytest.approx(4.0, rel=0.05)
    assert load["place"][:2] == pytest.approx([0.1, 0.06], abs=0.015)


def test_a_fall_is_exit_code_one(tmp_path: Path, printed: Any) -> None:
    options = ["--push", "0.5:0,1500,0:0.2", "--duration", "3", "--no-video", "--no-report"]
    assert "go2 fell after" in printed("walk", *options, "--out", tmp_path, code=1)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--gait", "walk"], "takes no --gait or period"),
        (["--dropout", "0.1:0.1"], "takes no --commands, --dropout"),
    ],
)
def test_a_planner_without_gait_refuses_what_is_of_gaits(
    options: list[str], words: str, printed: Any, tmp_path: Path
) -> None:
    ask = ["walk", "go2", "--planner", "contact-implicit", *options, "--no-video", "--out", tmp_path]
    assert words in printed(*ask, code=2)
    assert not list(tmp_path.iterdir())
