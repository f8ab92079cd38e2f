"""`--payload KG@X,Y,Z`: where the mass is, what the robot finds of it, and what statics says."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from surefoot.cli.main import main

SILENT = ["--no-video", "--no-report"]


def test_a_walk_finds_its_payload_and_says_so(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    options = ["go2", "--payload", "4@0.1,0.06,0.08", "--duration", "2", *SILENT, "--out", str(tmp_path)]
    assert main(["walk", *options]) == 0
    assert "estimated payload" in " ".join(capfd.readouterr().out.split())
    load = json.loads(next(tmp_path.glob("*/summary.json")).read_text())["load"]
    assert load["mass"] == pytest.approx(4.0, rel=0.05)
    assert load["place"][:2] == pytest.approx([0.1, 0.06], abs=0.015)


def test_without_a_payload_no_place_is_told(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["walk", "go2", "--duration", "1", "--json", *SILENT, "--out", str(tmp_path)]) == 0
    load = json.loads(capfd.readouterr().out)["load"]
    assert abs(load["mass"]) < 0.3
    assert "place" not in load


def test_statics_of_a_stand_count_where_the_payload_is(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    def said(payload: str) -> list[dict[str, float]]:
        options = [
            "go2",
            "--payload",
            payload,
            "--duration",
            "0.3",
            "--json",
            *SILENT,
            "--out",
            str(tmp_path),
        ]
        main(["stand", *options])
        return list(json.loads(capfd.readouterr().out)["statics"])

    assert said("30@0,0,0")[0]["possible"]
    assert not said("30@0,1,0")[0]["possible"]
