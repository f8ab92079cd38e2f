from __future__ import annotations

from typing import Any

import pytest


def test_translate_proves_itself(printed: Any, answer: Any) -> None:
    pytest.importorskip("mujoco")
    words = ["translate", "physical", "mujoco", "stiffness=2e4", "damping=40", "--mass", "4", "--dt", "1e-4"]
    facts = answer(*words, "--prove")
    assert facts["parameters"]["solref"] == [-4995.0, -10.0]
    for row in facts["agreement"].values():
        assert row["agrees"]
        assert row["measured"] == pytest.approx(row["given"], rel=0.01)
    assert "lost: the force is proportional to the effective mass" in printed(*words)
