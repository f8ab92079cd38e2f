"""The numbered example on model-predictive control runs, and its claims hold."""

from __future__ import annotations

import importlib.util
from pathlib import Path

FILE = Path(__file__).parents[2] / "examples" / "33_plan_on_a_slope.py"


def test_a_kick_on_a_slope_is_planned_away(tmp_path: Path) -> None:
    spec = importlib.util.spec_from_file_location("example_33", FILE)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    facts = module.main(tmp_path, kick=0.4)
    assert facts["left"] < 0.4 * 0.4
    assert 0.99 < facts["use"] < 1.0 + 1e-9
    assert facts["error"] < 1e-2
    assert (tmp_path / "33_plan_on_a_slope" / "plan.png").stat().st_size > 10_000
