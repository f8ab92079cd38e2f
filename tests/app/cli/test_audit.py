"""`surefoot audit`: exit codes, JSON, the page; a broken file is one line."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from surefoot.app.cli.main import main
from tests.records.audit.logs import TROT, changed, log_of
from tests.worlds.mujoco.strangers import thrown_crate


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a clean log, a spoilt one, and files that are none."""
    place = tmp_path_factory.mktemp("audit")
    log = log_of(TROT)
    changed(log).save(place / "clean.npz")
    gaps = np.array(log["gaps"])
    gaps[200:300, 0] -= 8e-3
    changed(log, gaps=gaps).save(place / "sunk.npz")
    data = (place / "clean.npz").read_bytes()
    (place / "cut.npz").write_bytes(data[: len(data) // 2])
    (place / "text.npz").write_text("no log")
    (place / "other.xyz").write_text("no log")
    np.savez(place / "plain.npz", a=np.zeros(3))
    return place


def test_a_clean_log_ends_with_zero(folder: Path, printed: Any) -> None:
    said = printed("audit", folder / "clean.npz")
    assert "lawful: all 13 laws that could be judged hold (1200 rows, 1.2 s); the task was attained" in said


def test_json_is_the_report_and_nothing_else(folder: Path, answer: Any) -> None:
    told = answer("audit", folder / "sunk.npz", code=1)
    assert told["verdict"] == "broken"
    (one,) = (v for v in told["violations"] if v["law"] == "penetration")
    assert (one["law"], one["contact"]) == ("penetration", "FL_foot")
    assert (one["start"], one["end"]) == pytest.approx((0.2, 0.3), abs=2e-3)
    assert told["symptoms"][0]["name"] == "sinking"


def test_the_checklist_answers_from_the_log(folder: Path, answer: Any) -> None:
    changed(log_of(TROT), keep=("forces", "mu")).save(folder / "forces.npz")
    unsaid = np.full(np.shape(log_of(TROT)["forces_commanded"]), np.nan)
    changed(log_of(TROT), forces_commanded=unsaid).save(folder / "policy.npz")
    answered = {}
    for name, code in (("clean", 0), ("sunk", 1), ("forces", 3), ("policy", 0)):
        rows = answer("audit", folder / f"{name}.npz", "--checklist", code=code)["checklist"]
        answered[name] = {row["question"]: row["answer"] for row in rows}
    assert set(answered["clean"].values()) == {"yes"}
    ground = "Do feet stay out of the ground?"
    assert [answered[name][ground] for name in answered] == ["yes", "no", "cannot tell", "yes"]
    assert answered["forces"]["Does friction stay in the cone?"] == "yes"
    for name in ("forces", "policy"):  # whose commands are not there, or hold no numbers
        assert answered[name]["Did the controller ask for what contacts can give?"] == "cannot tell"


def test_the_page_holds_verdict_timeline_and_tables(folder: Path, tmp_path: Path) -> None:
    assert main(["audit", str(folder / "sunk.npz"), "--out", str(tmp_path)]) == 1
    (made,) = tmp_path.iterdir()
    page = (made / "report.html").read_text(encoding="utf-8")
    assert 'class="verdict">broken: 4 violations of gap rate, penetration, gap place' in page
    assert page.count("data:image/png;base64,") == 2  # the story and the timeline
    for title in ("Timeline", "Symptoms", "Violations", "What could be judged", "Friction of the ground"):
        assert f"<h2>{title}" in page
    assert json.loads((made / "audit.json").read_text())["verdict"] == "broken"


def test_a_log_without_motion_or_places_is_drawn_too(folder: Path, tmp_path: Path) -> None:
    log = changed(log_of(TROT), keep=("forces", "gaps", "mu"))
    forces = np.array(log["forces"])
    forces[100:200, 0] *= -1.0
    changed(log, forces=forces).save(tmp_path / "contacts.npz")
    assert main(["audit", str(tmp_path / "contacts.npz"), "--out", str(tmp_path / "runs")]) == 1
    (made,) = (tmp_path / "runs").iterdir()
    assert (made / "timeline.png").exists()


def test_a_recording_is_replayed_in_the_model_beside_it_on_trust_alone(tmp_path: Path, printed: Any) -> None:
    refused = partial(printed, code=2)
    path = tmp_path / "thrown.npz"
    thrown_crate(12.0).save(path)
    assert "thrown.mjb: --trust replays in that" in refused("audit", path, "--replay", "mujoco-exact")
    said = printed("audit", path, "--replay", "mujoco-exact", "--trust", code=1)
    assert "the motion is lost in the world mujoco-exact" in said
    assert "--trust is for the model of a --replay" in refused("audit", path, "--trust")
    assert "mujoco-exact" in refused("audit", path, "--replay", "rigid", "--trust")
    (tmp_path / "thrown.mjb").unlink()
    assert "thrown.mjb cannot be read" in refused("audit", path, "--replay", "mujoco", "--trust")
