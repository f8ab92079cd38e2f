"""The numbered example on model-predictive control runs, and its claims hold."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import ModuleType


def test_a_kick_on_a_slope_is_planned_away(tmp_path: Path, load: Callable[[str], ModuleType]) -> None:
    facts = load("33_plan_on_a_slope").main(tmp_path, kick=0.4)
    assert facts["left"] < 0.4 * 0.4
    assert 0.99 < facts["use"] < 1.0 + 1e-9
    assert facts["error"] < 1e-2
    assert (tmp_path / "33_plan_on_a_slope" / "plan.png").stat().st_size > 10_000
