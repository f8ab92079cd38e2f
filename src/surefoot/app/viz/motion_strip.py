"""The picture of a motion reference: the robot from its side at even times."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from surefoot.app.viz.shapes import bones
from surefoot.app.viz.style import FOOT_COLOURS, GROUND
from surefoot.base.errors import ProblemError
from surefoot.base.spatial import heading_of

if TYPE_CHECKING:
    from surefoot.records.motions.motion import Motion

_MOST = 8
"""Robots in the row."""


def draw_strip(motion: Motion, axes: Any) -> None:
    """Draw a robot from its side at even times of a motion, one beside the other."""
    q = np.asarray(motion.q, dtype=np.float64)
    if not len(q):
        raise ProblemError(f"{motion.name} has no frames: there is nothing to draw")
    chosen = np.unique(np.linspace(0, len(q) - 1, min(_MOST, len(q))).astype(int))
    views = []
    for k in chosen:
        side = heading_of(q[k, 3:7]) if motion.robot.floating else np.array([1.0, 0.0])
        lines = bones(motion.robot, q[k]) - (np.array([*q[k, :2], 0.0]) if motion.robot.floating else 0.0)
        views.append(np.stack([lines[..., :2] @ side[:2], lines[..., 2]], axis=-1))
    width = 1.15 * max(float(np.ptp(view[..., 0])) for view in views)
    low = min(float(view[..., 1].min()) for view in views)
    for place, (k, view) in enumerate(zip(chosen, views, strict=True)):
        moved = view + np.array([place * width, 0.0])
        axes.plot(*np.moveaxis(moved, -1, 0).swapaxes(1, 2), color=FOOT_COLOURS[0], lw=1.6)
        axes.text(place * width, low - 0.16 * width, f"{k / motion.rate:.2f} s", ha="center", fontsize=7)
    axes.axhline(min(low, 0.0), color=GROUND, lw=3.0, zorder=0)
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.set_title(f"{motion.name}: {motion.robot.name}, {motion.duration:.2f} s")
