"""`surefoot identify`: what it prints, what stands in its JSON, what it leaves on the disk."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from benchmarks.problems.tosses import random_tosses, write_tosses
from surefoot.cli.main import main

TRUTH = [0.2, 0.1, 0.003]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("identify")
    for seed, name in enumerate(("train", "test")):
        write_tosses(random_tosses(8, TRUTH, seed=seed, frames=90), place / f"{name}.npz")
    return place


def run(folder: Path, capfd: pytest.CaptureFixture[str], *words: str) -> Any:
    code = main(["identify", str(folder / "train.npz"), "--resamples", "50", *words])
    assert code == 0
    return capfd.readouterr().out


@pytest.mark.long
def test_json_holds_the_fit_and_both_errors(folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("mujoco")
    words = ("--test", str(folder / "test.npz"), "--rivals", "mujoco", "--no-picture", "--json")
    facts = json.loads(run(folder, capfd, *words))
    for name, truth in (("mu", 0.2), ("restitution", 0.1), ("com_z", 0.0)):
        estimate = facts["fit"][name]
        assert estimate["low"] <= estimate["value"] <= estimate["high"]
        assert estimate["value"] == pytest.approx(truth, abs=0.05)
    assert {"tilt_x", "tilt_y", "gravity", "rounding", "ground", "scale"} <= set(facts["fit"])
    for part in ("train", "test"):
        ours, rival = facts[part], facts[part]["rivals"]["mujoco"]
        assert ours["tosses"] == len(ours["position_error"]) == 8
        assert ours["position_error_mean"] < rival["position_error_mean"]
        gap = rival["ours_less_theirs"]["position"]
        difference = ours["position_error_mean"] - rival["position_error_mean"]
        assert gap["value"] == pytest.approx(difference)
        assert gap["low"] <= gap["value"] <= gap["high"]
    assert set(rival["fit"]) >= {"mu", "solref_time", "solref_ratio", "solimp_least", "solimp_most"}


def test_tables_laws_and_picture(folder: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("matplotlib")
    words = ("--law", "rigid", "--law", "newton", "--rivals", "none", "--out", str(tmp_path))
    out = run(folder, capfd, *words)
    for word in ("mu", "restitution", "rounding", "com_z", "ground", "No --test", "95 % interval"):
        assert word in out
    (picture,) = tmp_path.glob("identify-*/tosses.png")
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert str(picture) in out.replace("\n", "")


def test_without_a_test_no_rival_runs_unasked(folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    facts = json.loads(run(folder, capfd, "--no-picture", "--json"))
    assert facts["test"] is None
    assert facts["train"]["rivals"] == {}
    assert facts["picture"] is None
    assert {f.name for f in folder.iterdir()} == {"train.npz", "test.npz"}
