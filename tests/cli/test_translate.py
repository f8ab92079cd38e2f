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


@pytest.mark.parametrize(
    "words",
    [
        ["nobody", "mujoco"],
        ["physical", "nobody", "stiffness=1", "damping=0"],
        ["physical", "ode", "stiffness=1"],
        ["physical", "ode", "stiffness", "damping=1"],
        ["physical", "ode", "stiffness=1", "stiffness=2", "damping=1"],
        ["physical", "ode", "stiffness=1e4", "damping=1", "--dt", "0"],
        ["physical", "ode", "stiffness=1e4", "damping=1", "--prove"],
        ["physical", "mujoco", "stiffness=1e4", "damping=1", "--mass", "-1"],
        ["mujoco", "physical", "solref=0.02"],
    ],
)
def test_wrong_input_is_one_line(words: list[str], capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["translate", *words]) == 2
    said = capfd.readouterr().err
    assert said.startswith("surefoot: ")
    assert said.count("\n") == 1
