"""The numbered examples on walking run, and their claims hold."""

from __future__ import annotations

from pathlib import Path

import pytest


def test_a_trot_over_bumps_takes_a_push(tmp_path: Path, load) -> None:
    facts = load("30_trot").main(tmp_path, duration=4.0)
    assert facts["walked"] == 1.0
    assert facts["forward"] == pytest.approx(0.4, rel=0.1)
    assert facts["commanded_excess"] == 0.0
    assert facts["cone_use"] <= 1.001
    assert len(list(tmp_path.rglob("*.png"))) == 2


def test_an_own_gait_walks_from_phases_and_from_a_file(tmp_path: Path, load) -> None:
    speeds = load("31_own_gait").main(tmp_path, duration=3.5)
    assert speeds["phases"] == pytest.approx(0.4, rel=0.1)
    assert speeds["file"] == pytest.approx(speeds["phases"], abs=0.01)
    assert speeds["refused"] == 1.0


def test_whole_body_control_gives_what_friction_allows(tmp_path: Path, load) -> None:
    facts = load("32_whole_body_step").main(tmp_path)
    assert 0.7 * facts["friction"] < facts["largest"] <= facts["friction"] + 1e-6
    assert facts["use"] == pytest.approx(1.0, abs=1e-6)
