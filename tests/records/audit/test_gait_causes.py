"""Causes that a gait's own history tells: footholds beside the earlier ones."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from surefoot.records.audit.story.gait_causes import Landing, beside
from surefoot.records.audit.story.signals import Signals
from surefoot.records.audit.story.story_limits import STORY_LIMITS


def footholds(*places: float, change: float) -> tuple[Signals, list[Landing]]:
    """Return landings of a foot ahead of the body [m], the last at a speed changed by so much [m/s]."""
    landed = [Landing(20 * k, 20 * k + 10, np.array([x, 0.0]), np.zeros(2)) for k, x in enumerate(places)]
    landed[-1] = landed[-1]._replace(velocity=np.array([change, 0.0]))
    signals = SimpleNamespace(height=0.3, time=0.01 * np.arange(20 * len(places)), limits=STORY_LIMITS)
    return cast(Signals, signals), landed


@pytest.mark.parametrize(
    ("step", "change", "amiss"),
    [(0.02, 0.0, False), (0.04, 0.0, True), (0.07, 0.5, False), (0.09, 0.5, True), (-0.04, 0.5, True)],
)
def test_a_foothold_may_follow_a_changed_speed_by_half_of_a_stance(
    step: float, change: float, amiss: bool
) -> None:
    signals, landed = footholds(0.2, 0.2, 0.2, 0.2 + step, change=change)
    sign = beside(signals, "foot", landed)
    assert (sign is not None) == amiss
    if sign is not None:
        assert sign.time == pytest.approx(0.7)
        assert f"{100.0 * abs(step):.0f} cm from where it has landed before" in sign.evidence
        assert f"{100.0 * step:+.0f} cm ahead" in sign.evidence
