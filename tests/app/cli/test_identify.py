"""`surefoot identify`: what it prints, what stands in its JSON, what it leaves on the disk."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from benchmarks.problems.tosses import random_tosses, write_tosses

TRUTH = [0.2, 0.1, 0.003]
QUICK = ("--resamples", "50")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("identify")
    for seed, name in enumerate(("train", "test")):
        write_tosses(random_tosses(8, TRUTH, seed=seed, frames=30), place / f"{name}.npz")
    return place


@pytest.mark.long
def test_json_holds_the_fit_and_both_errors(folder: Path, answer: Any) -> None:
    pytest.importorskip("mujoco")
    words = ("--test", folder / "test.npz", "--rivals", "mujoco", "--no-picture")
    facts = answer("identify", folder / "train.npz", *QUICK, *words)
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


@pytest.mark.long
def test_tables_laws_and_picture(folder: Path, tmp_path: Path, printed: Any) -> None:
    pytest.importorskip("matplotlib")
    words = ("--law", "rigid", "--law", "newton", "--rivals", "none", "--out", tmp_path)
    out = printed("identify", folder / "train.npz", *QUICK, *words)
    for word in ("mu", "restitution", "rounding", "com_z", "ground", "No --test", "95 % interval"):
        assert word in out
    (picture,) = tmp_path.glob("identify-*/tosses.png")
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert str(picture) in out.replace("\n", "")


@pytest.mark.long
def test_without_a_test_no_rival_runs_unasked(folder: Path, answer: Any) -> None:
    facts = answer("identify", folder / "train.npz", *QUICK, "--no-picture")
    assert facts["test"] is None
    assert facts["train"]["rivals"] == {}
    assert facts["picture"] is None
    assert {f.name for f in folder.iterdir()} == {"train.npz", "test.npz"}
