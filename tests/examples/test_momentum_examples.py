"""The numbered examples on momentum and the rigid world run, and their claims hold."""

from __future__ import annotations

from pathlib import Path

import pytest

pytestmark = pytest.mark.long


@pytest.fixture
def facts_of(load):
    def facts(name: str, folder: Path) -> dict[str, float]:
        found = load(name).main(folder)
        pictures = list(folder.glob("*/*.png"))
        assert pictures
        assert all(p.stat().st_size > 10_000 for p in pictures)
        return found

    return facts


def test_jump_keeps_its_momentum(tmp_path, facts_of):
    facts = facts_of("20_jump_momentum", tmp_path)
    assert facts["angular_drift"] < 1e-9 * max(1.0, facts["angular_size"])
    assert facts["linear_drift"] < 1e-8
    assert facts["trunk_swing"] > 0.3  # while the trunk's share changes a lot


def test_backflip_lands_on_its_feet(tmp_path, facts_of):
    facts = facts_of("21_backflip_momentum", tmp_path)
    assert facts["pitch_landed_deg"] == pytest.approx(-360.0, abs=1e-3)
    assert facts["momentum_stiff"] == pytest.approx(facts["by_hand_stiff"], rel=1e-6)
    assert facts["momentum_tucked"] < 0.96 * facts["momentum_stiff"]
    assert facts["momentum_drift"] < 1e-8


def test_cat_turns_over_without_momentum(tmp_path, facts_of):
    facts = facts_of("22_falling_cat", tmp_path)
    for way in ("optimised", "by_momentum", "by_forces"):
        assert facts[f"turn_{way}"] == pytest.approx(180.0, abs=1e-3)
    assert facts["largest_momentum"] < 1e-7
    assert facts["largest_twist"] <= 150.0 + 1e-6


def test_arms_take_the_legs_yaw_away(tmp_path, facts_of):
    facts = facts_of("23_arm_swing", tmp_path)
    assert facts["cancelled"] > 0.85
    assert facts["yaw_torque_swung"] < 0.3 * facts["yaw_torque_still"]
    assert facts["pelvis_turn_swung_deg"] < 0.2 * facts["pelvis_turn_still_deg"]
    assert 0.3 < facts["shoulder_amplitude"] < 0.8


def test_flywheel_survives_more(tmp_path, facts_of):
    facts = facts_of("24_flywheel_push", tmp_path)
    assert facts["lipm_simulated"] == pytest.approx(facts["lipm_formula"], rel=2e-3)
    assert facts["flywheel_simulated"] == pytest.approx(facts["flywheel_formula"], rel=5e-3)
    assert facts["gain_percent"] > 5.0


def test_rigid_world_meets_closed_forms(tmp_path, facts_of):
    facts = facts_of("25_rigid_closed_forms", tmp_path)
    assert facts["slope_error"] < 1e-6
    assert facts["tips_below"] < 1e-6
    assert facts["tips_above"] > 0.05
    assert facts["error_block"] < 1e-9
    assert facts["error_ball"] < 1e-4
    assert facts["second_bounce"] == pytest.approx(0.64, abs=0.01)


def test_rigid_world_and_mujoco_differ_as_told(tmp_path, facts_of):
    facts = facts_of("26_rigid_and_mujoco", tmp_path)
    assert facts["standing_0deg_percent"] < 0.5
    assert facts["standing_10deg_percent"] < 0.5
    assert facts["rigid_distance"] == pytest.approx(facts["closed_form_distance"], rel=1e-5)
    assert facts["mujoco_distance"] == pytest.approx(
        facts["rigid_distance"], rel=3e-3
    )  # first order: v dt / 2
    assert facts["convex_distance"] == pytest.approx(facts["rigid_distance"], rel=1e-3)
    assert facts["rigid_highest_mm"] < 1e-6
    assert facts["convex_highest_mm"] > 20.0
    assert facts["rigid_creep"] < 1e-12 < facts["mujoco_creep"]


def test_shins_on_a_stair(tmp_path, facts_of):
    assert facts_of("28_bodies", tmp_path)["shins"] > 40.0
