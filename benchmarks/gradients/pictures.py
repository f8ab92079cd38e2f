"""The picture of the landscapes: the loss and its smoothed cousin, and the slope that each method tells."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.gradients.estimators import Grid
from surefoot.app.viz.style import FOOT_COLOURS, MUTED, new_figure, save

SPREAD = 25
"""Points at which slopes of smoothing and penalty are computed."""


def draw_landscapes(grids: Sequence[Grid], smoothing: float, stiffness: float, path: Path) -> Path:
    """Draw a column for each task: the loss above, below the slopes of the methods."""
    figure, axes = new_figure(2, len(grids), size=(max(4.2 * len(grids), 6.0), 6.4))
    for column, grid in enumerate(grids):
        _draw_loss(axes[0, column], grid)
        _draw_slopes(axes[1, column], grid, smoothing, stiffness)
    axes[0, 0].set_ylabel("loss")
    axes[1, 0].set_ylabel("slope of the loss")
    above, below = (axes[row, 0].get_legend_handles_labels() for row in (0, 1))
    figure.legend(above[0] + below[0], above[1] + below[1], loc="outside lower center", ncols=4, fontsize=9)
    return save(figure, path)


def _draw_loss(axis: Any, grid: Grid) -> None:
    theta, losses = grid.theta[grid.inside], grid.loss[grid.inside]
    mean = [float(grid.density(t) @ grid.loss) for t in theta]
    axis.plot(theta, losses, color=FOOT_COLOURS[0], lw=1.6, label="loss")
    axis.plot(theta, mean, color=FOOT_COLOURS[2], lw=1.2, ls="--", label="loss, randomised smoothing")
    axis.set_title(grid.task.name, fontsize=11)


def _draw_slopes(axis: Any, grid: Grid, smoothing: float, stiffness: float) -> None:
    task, theta = grid.task, grid.theta[grid.inside]
    moments = [grid.moments(t) for t in theta]
    some = np.linspace(task.low, task.high, SPREAD)
    exact, zeroth = grid.slope[grid.inside], np.array([m.zeroth for m in moments])
    smooth = np.array([task.smooth(t, smoothing) for t in some])
    soft = np.array([task.penalty_slope(t, stiffness) for t in some])
    axis.plot(theta, exact, color=FOOT_COLOURS[0], lw=1.6, label="implicit, exact")
    axis.plot(some, smooth, ".", color=FOOT_COLOURS[1], ms=6, label=f"implicit, smoothed {smoothing:g} W")
    axis.plot(some, soft, "x", color=MUTED, ms=4, label=f"penalty, {stiffness:g} N/m")
    axis.plot(theta, zeroth, color=FOOT_COLOURS[2], lw=1.2, ls="--", label="randomised, zeroth order (mean)")
    first = [m.first for m in moments]
    axis.plot(theta, first, color=FOOT_COLOURS[3], lw=1.2, ls=":", label="randomised, first order (mean)")
    slopes = np.concatenate([exact, zeroth, smooth])
    margin = 0.08 * max(float(np.ptp(slopes)), 1e-6)
    low, high = float(slopes.min()) - margin, float(slopes.max()) + margin
    axis.set_ylim(low, high)
    beyond = int(np.count_nonzero((soft < low) | (soft > high)))
    if beyond:
        text = f"{beyond} of {SPREAD} penalty slopes outside"
        axis.text(0.98, 0.03, text, transform=axis.transAxes, ha="right", fontsize=8)
    axis.set_xlabel("parameter")
