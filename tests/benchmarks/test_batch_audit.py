"""The bench of many environments counts those that the single audit judges otherwise."""

from __future__ import annotations

import json

import pytest

pytest.importorskip("mujoco")


@pytest.mark.long
def test_the_command_prints_that_both_agree(capsys: pytest.CaptureFixture[str]) -> None:
    from surefoot.app.cli.main import main

    assert main(["bench", "audit", "--batch", "--quick", "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert (record["compared"], record["differ"]) == (8, 0)
    assert record["cpu"] > 0.0
    assert record["step"] < record["step_kept"]
