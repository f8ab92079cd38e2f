from __future__ import annotations

import json

import pytest

from surefoot.cli.main import main


def test_translate_proves_itself(capfd: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("mujoco")
    words = ["translate", "physical", "mujoco", "stiffness=2e4", "damping=40", "--mass", "4", "--dt", "1e-4"]
    assert main([*words, "--prove", "--json"]) == 0
    facts = json.loads(capfd.readouterr().out)
    assert facts["parameters"]["solref"] == [-4995.0, -10.0]
    for row in facts["agreement"].values():
        assert row["agrees"]
        assert row["measured"] == pytest.approx(row["given"], rel=0.01)
    assert main(words) == 0
    assert "lost: the force is proportional to the effective mass" in capfd.readouterr().out
