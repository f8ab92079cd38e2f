"""`surefoot walk --planner contact-implicit` and `surefoot bench plan`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from surefoot.app.cli.main import main


def test_a_walk_without_a_gait_says_how_it_plans(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    words = ["walk", "--planner", "contact-implicit", "--velocity", "0.5,0,0", "--duration", "0.6"]
    code = main([*words, "--no-video", "--no-report", "--json", "--out", str(tmp_path)])
    found = json.loads(capsys.readouterr().out)
    assert code in (0, 1)  # half a second says nothing of the velocity
    assert found["gait"] == "contact-implicit"
    assert found["outcome"] in ("walked", "did not follow")
    assert found["feasible_share"] == 1.0
    assert "25 knots of 20 ms" in found["notes"][0]


@pytest.mark.long
def test_the_benchmark_prints_json_alone(answer: Any) -> None:
    found = answer("bench", "plan", "--quick")
    solver, mpc, (ours, rival) = found["solver"], found["mpc"], found["jump"].values()
    assert ours["apart"] < 0.02
    assert "SUREFOOT_CROCODDYL_PYTHON names no" in rival or rival["replay_off"] < 0.05
    assert min(solver["derivative_ratio"], solver["knot"]["derivative"], *solver["ours"].values()) > 0.0
    assert solver["descent"]["ours"]["costs"][-1] < solver["descent"]["ours"]["costs"][0]
    assert mpc["walk"]["done"]
    assert mpc["pushes"][0]["done"]
    assert mpc["tick"]["processor"]["p99"] > 0.0
