"""Where flat feet press: the centre of pressure inside every sole."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from surefoot.audit import sole_pressures
from surefoot.log import Log
from surefoot.viz.plots import thinned
from surefoot.viz.shapes import ring
from surefoot.viz.style import FOOT_COLOURS, GROUND, INK, MUTED, new_figure, save


def draw_pressure(log: Log, path: Path) -> Path | None:
    """Draw the centre of pressure of every flat foot in its sole; None if no foot is flat."""
    soles = sole_pressures(log)
    if not soles:
        return None
    figure, axes = new_figure(1, len(soles), size=(4.2 * len(soles), 2.4), sharex=True, sharey=True)
    pushed = np.any(log["push"] != 0.0, axis=1)
    for axis, sole in zip(axes[0], soles, strict=True):
        colour = FOOT_COLOURS[sole.foot % 8]
        closed = 1e3 * ring(sole.outline)
        axis.fill(*closed.T, color=GROUND, lw=0)
        axis.plot(*closed.T, color=INK, lw=1.1)
        trace = 1e3 * sole.centres
        axis.plot(*trace[thinned(len(log))].T, color=colour, lw=0.9)
        axis.scatter(*trace[pushed].T, s=6, color=FOOT_COLOURS[3], lw=0, zorder=3)
        loaded = trace[np.isfinite(trace[:, 0])]
        if len(loaded):
            axis.scatter(*loaded[-1], s=22, color=colour, edgecolor="white", zorder=4)
        name = log.facts["feet"][sole.foot]
        axis.set_title(f"{name}: at least {1e3 * abs(sole.margin):.0f} mm from the edge", fontsize=9)
        axis.set_aspect("equal")
        axis.tick_params(colors=MUTED)
    figure.supxlabel("along the foot [mm]", fontsize=9)
    figure.supylabel("across [mm]", fontsize=9)
    return save(figure, path)
