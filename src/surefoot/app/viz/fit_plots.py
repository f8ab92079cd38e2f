"""Pictures of fits: what was found, with its 95 % intervals, and forces that a model gives."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from surefoot.app.viz.plots import stride_of
from surefoot.app.viz.style import BAD, FOOT_COLOURS, INK, MUTED
from surefoot.base.errors import ProblemError

if TYPE_CHECKING:
    from surefoot.records.identification.force_model import FootForces, ForceModel
    from surefoot.records.identification.walked_robot import RobotFit


def draw_robot_fit(fit: RobotFit, axes: Any) -> None:
    """Draw what a walk shows of a robot: numbers with their 95 % intervals, each over its own value."""
    rows = {
        f"{name} {one.value:.3g} {one.unit}".strip(): (one.value, one.low, one.high)
        for name, one in fit.parameters.items()
    }
    _draw_intervals(axes, rows)


def draw_force_model(model: ForceModel, axes: Any) -> None:
    """Draw what each joint of a leg keeps to itself, with 95 % intervals, each over its own value."""
    rows = {
        f"{joint} {term} {value:.3g}": (value, low, high)
        for joint, terms in model.joints.items()
        for term, (value, low, high) in terms.items()
    }
    _draw_intervals(axes, rows)


def _draw_intervals(axes: Any, rows: dict[str, tuple[float, float, float]]) -> None:
    """Draw intervals as shares of their values: 1 is the value itself."""
    if not rows:
        raise ProblemError("nothing was found: there is nothing to draw")
    for place, (value, low, high) in zip(range(len(rows))[::-1], rows.values(), strict=True):
        size = abs(value) or 1.0
        ends = [low / size, high / size if math.isfinite(high) else 2.0]
        sure = low > 0.0 or high < 0.0
        axes.plot(ends, [place, place], color=FOOT_COLOURS[0] if sure else MUTED, lw=2.5)
        axes.plot(value / size, place, "o", color=INK, ms=4)
    axes.axvline(0.0, color=BAD, lw=0.8, ls="--")
    axes.set_yticks(range(len(rows))[::-1], [*rows])
    axes.set(xlabel="95 % interval, over the value itself", ylim=(-0.6, len(rows) - 0.4))
    axes.grid(axis="y", visible=False)


def draw_foot_forces(forces: FootForces, axes: Any) -> None:
    """Draw the force on a foot along each of its sensor's axes, with 95 % intervals."""
    thin = stride_of(len(forces.time))
    time = forces.time[thin]
    for k, name in enumerate("xyz"):
        axes.fill_between(
            time, forces.low[thin, k], forces.high[thin, k], color=FOOT_COLOURS[k], alpha=0.2, lw=0
        )
        axes.plot(time, forces.forces[thin, k], color=FOOT_COLOURS[k], label=name)
    share = 100.0 * float(np.mean(forces.contact))
    axes.set(xlabel="time [s]", ylabel="force [N]", title=f"on the ground {share:.0f} % of the time")
    axes.legend(fontsize=8)
