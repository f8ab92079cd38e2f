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


def test_momentum_is_weighed_and_not_forbidden(tmp_path: Path, load: Callable[[str], ModuleType]) -> None:
    facts = load("34_momentum_in_the_plan").main(tmp_path)
    for name in ("weight 30", "bound 0.08"):
        assert facts[f"limit, {name}, peak"] < 0.9 * facts["limit, free, peak"]
        assert facts[f"limit, {name}, tilt"] < 0.9 * facts["limit, free, tilt"]
    assert facts["limit, weight 1e5, peak"] > facts["limit, free, peak"]
    assert facts["trot, weight 1e5, tilt"] > 5.0 * facts["trot, free, tilt"]
    assert (tmp_path / "34_momentum_in_the_plan" / "tilt.png").stat().st_size > 10_000
