"""Plots of a walk: velocity tracking, footfall diagram, path."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from surefoot.app.viz.plots import (
    draw_cone_use,
    draw_normal_forces,
    draw_torques,
    mark_events,
    spans,
    stride_of,
)
from surefoot.app.viz.style import (
    FOOT_COLOURS,
    GROUND,
    INK,
    MUTED,
    draw_foot_bars,
    most_of,
    new_axis,
    new_panels,
    save,
)
from surefoot.mechanics import read_terrain
from surefoot.records import Log
from surefoot.records.audit.motion import heading_velocity, touching

FOOTFALL_SPAN = 3.0
"""Length of the footfall diagram [s]: the end of the run."""


def draw_velocity(log: Log, path: Path) -> Path:
    """Draw the base's velocity in its heading frame against the commanded one."""
    labels = ("forward [m/s]", "left [m/s]", "yaw rate [rad/s]")
    figure, axes = new_panels(labels, (8.0, 5.6), "Velocity of the base in its heading frame")
    thin, measured = stride_of(len(log)), heading_velocity(log)
    for k, axis in enumerate(axes):
        axis.plot(log["time"][thin], measured[thin, k], color=FOOT_COLOURS[k], lw=0.9, label="measured")
        axis.plot(log["time"][thin], log["command"][thin, k], color=INK, lw=1.1, ls="--", label="commanded")
        span = max(float(np.abs(log["command"][:, k]).max()), 0.1)
        low, high = np.percentile(measured[:, k], [0.2, 99.8])
        wanted = log["command"][:, k]
        limits = min(low, wanted.min()) - 0.3 * span, max(high, wanted.max()) + 0.3 * span
        most_of(axis, log["time"], measured[:, k], *limits)
        mark_events(axis, log)
    axes[0].legend(ncols=2, fontsize=8)
    return save(figure, path)


def draw_footfalls(log: Log, path: Path) -> Path:
    """Draw when each foot was on the ground (bars) and when the gait has it there (lines), at the end."""
    names = log.facts["feet"]
    plans = "planned" in log
    title = "Footfalls: bars measured" + ", dark lines planned" * plans
    figure, axis = new_axis((8.0, 0.45 * len(names) + 1.2), title, xlabel="time [s]")
    recent = _end(log)
    time, down = recent["time"], touching(recent)
    draw_foot_bars(axis, {name: spans(time, down[:, k]) for k, name in enumerate(names)})
    for k in range(len(names)):
        row = len(names) - 1 - k
        for begin, length in spans(time, recent["planned"][:, k]) if plans else ():
            axis.plot([begin, begin + length], [row - 0.42] * 2, color=INK, lw=1.4, solid_capstyle="butt")
    axis.set(xlim=(time[0], time[-1]))
    return save(figure, path)


def draw_path(log: Log, path: Path) -> Path:
    """Draw the base's path from above and from the side, with every footfall."""
    title = "Path of the base and footfalls, from above and from the side"
    figure, axes = new_panels(("y [m]", "z [m]"), (8.0, 4.6), title, "x [m]", sharex=False)
    thin, down = stride_of(len(log)), touching(log)
    owner = np.asarray(log.facts["contact_foot"])
    for row, axis in enumerate(axes, start=1):
        axis.plot(log["q"][thin, 0], log["q"][thin, row], color=INK, lw=1.0)
        for k in range(len(log.facts["feet"])):
            begins = np.flatnonzero(down[1:, k] & ~down[:-1, k]) + 1
            place = log["contact_positions"][begins][:, np.flatnonzero(owner == k)[0]]
            axis.scatter(place[:, 0], place[:, row], s=6, color=FOOT_COLOURS[k % 8], lw=0)
        axis.set_aspect("equal", adjustable="datalim")
    _draw_ground(axes[1], log)
    return save(figure, path)


def _draw_ground(axis: Any, log: Log) -> None:
    """Draw the ground below the base's path, where the log says which it is."""
    if not log.facts.get("terrain"):
        return
    path = log["q"][stride_of(len(log)), :2]
    turns = np.flatnonzero(np.diff(np.sign(np.diff(path[:, 0]))) != 0)
    if len(turns) > len(path) // 4:  # it marks time: there is no side view of a way
        return
    way, feet = path[np.argsort(path[:, 0])], log["contact_positions"][stride_of(len(log)), :, 0]
    x = np.linspace(min(feet.min(), way[0, 0]), max(feet.max(), way[-1, 0]), 600)
    beside = np.interp(x, *way.T)
    z = read_terrain(str(log.facts["terrain"])).height(np.column_stack([x, beside]))
    axis.fill_between(x, z, z.min() - 0.05, color=GROUND, lw=0, zorder=0)
    axis.plot(x, z, color=MUTED, lw=0.9, zorder=1)


def draw_walk(log: Log, folder: Path) -> list[Path]:
    """Draw every plot of a walk into a folder and return their paths."""
    return [
        draw_velocity(log, folder / "velocity.png"),
        draw_footfalls(log, folder / "footfalls.png"),
        draw_cone_use(log, folder / "cone_use.png"),
        draw_normal_forces(_end(log), folder / "normal_forces.png"),
        draw_path(log, folder / "path.png"),
        draw_torques(log, folder / "torques.png"),
    ]


def _end(log: Log) -> Log:
    """Return the last `FOOTFALL_SPAN` seconds of a log."""
    return log.rows(log["time"] >= log["time"][-1] - FOOTFALL_SPAN)
