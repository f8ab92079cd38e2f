"""Drawings of gaits on given axes: which foot is on the ground when."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from surefoot.app.viz.style import INK, draw_foot_bars
from surefoot.base.errors import ProblemError
from surefoot.base.numerics.phases import runs_of
from surefoot.motion.gaits.contact_schedule import ContactSchedule

_CYCLES = 2.0
"""Cycles that are drawn."""
_LONGEST = 2.0
"""Time that is drawn of a schedule without a period [s]."""
_SAMPLES = 800


def draw_gait(
    gait: ContactSchedule, axes: Any, feet: Sequence[str] | None = None, until: float | None = None
) -> None:
    """Draw the stances of every foot as bars over time.

    Parameters
    ----------
    gait, axes
        What is drawn where.
    feet
        Their names; numbers where none are given.
    until
        Time that is drawn [s]; two cycles without it.
    """
    names = [f"foot {k}" for k in range(gait.feet)] if feet is None else list(feet)
    if len(names) != gait.feet:
        raise ProblemError(f"feet must be {gait.feet} names, got {len(names)}")
    end = (_CYCLES * gait.period or _LONGEST) if until is None else until
    times = np.linspace(0.0, end, _SAMPLES, endpoint=False)
    on = gait.contacts(times)
    step = end / _SAMPLES
    bars = {name: [(a * step, (b - a) * step) for a, b in runs_of(on[:, k])] for k, name in enumerate(names)}
    draw_foot_bars(axes, bars)
    for cycle in range(1, int(np.ceil(end / gait.period)) if gait.period > 0.0 else 1):
        axes.axvline(cycle * gait.period, color=INK, lw=0.8, ls=":")
    axes.set(xlim=(0.0, end), xlabel="time [s]", title=gait.name)
