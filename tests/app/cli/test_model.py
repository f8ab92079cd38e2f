from __future__ import annotations

import pytest


def test_go2(answer):
    found = answer("model", "go2")
    assert found["mass"] == pytest.approx(16.085, abs=1e-3)
    assert sum(j["mass"] for j in found["joints"]) == pytest.approx(found["mass"], rel=1e-9)
    assert found["contact_jacobian"] == {
        "rows": 12, "columns": 18, "rank": 12, "condition": pytest.approx(20, abs=20)
    }  # fmt: skip
    assert [f["rank"] for f in found["feet"]] == [3, 3, 3, 3]
    assert {j["effort"] for j in found["joints"] if "effort" in j} == {23.7, 45.43}
    assert found["centroidal"]["principal_moments"][0] > 0.05


def test_g1_feet_are_patches(answer):
    found = answer("model", "g1")
    assert [f["shape"] for f in found["feet"]] == ["sole", "sole"]
    assert [f["rank_of_its_leg"] for f in found["feet"]] == [6, 6]
    assert found["contact_jacobian"]["rank"] == 12


def test_fixed_arm_without_feet(answer):
    found = answer("model", "panda")
    assert found["feet"] == []
    assert not found["floating_base"]
    assert found["contact_jacobian"]["rank"] == 0


@pytest.mark.parametrize("name", ["go2", "g1", "ur5"])
def test_table_shows_everything(printed, name):
    text = printed("model", name)
    for part in ("Joints: link mass [kg]", "effort", "Centroidal inertia", "radius of gyration"):
        assert part in text
    assert ("contact Jacobian" in text) == (name != "ur5")
