"""Pictures of an audit: the feet over time with violations marked, and the worst moments in space."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.audit import AuditReport, Violation
from surefoot.audit.laws import LOADED_SHARE
from surefoot.audit.setting import BODY
from surefoot.log import Log
from surefoot.log.scene import frames_of, friction_of, robot_of
from surefoot.viz.shapes import bones, cone_rim
from surefoot.viz.style import BAD, FOOT_COLOURS, FORCE, GROUND, INK, MUTED, new_axis, new_figure, save

COLUMNS = 1500
"""The timeline has so many columns at most; a foot is drawn as loaded where it is in any row of one."""
MOMENTS = 3
"""Worst moments that are drawn."""
ARROW, CONE = 0.35, 0.08
"""Length of the arrow of a force of m g, and height of a cone [m]."""
LEAST_WIDTH = 0.004
"""A violation is drawn at least so wide, as a share of the log."""


def draw_timeline(log: Log, report: AuditReport, path: Path) -> Path:
    """Draw when each contact was loaded (bars), and where which law was broken (red)."""
    rows = [*report.contacts, BODY]
    title = "Feet on the ground (bars) and broken laws (red)"
    figure, axis = new_axis((9.0, 0.45 * len(rows) + 1.4), title, xlabel="time [s]")
    span = max(report.end - report.start, 1e-9)
    for k, spans in enumerate(_loaded(log, report)):
        axis.broken_barh(spans, (len(rows) - 1 - k - 0.3, 0.6), color=FOOT_COLOURS[k % 8], alpha=0.35, lw=0)
    for one in report.violations:
        at = len(rows) - 1 - rows.index(one.contact)
        width = max(one.end - one.start, LEAST_WIDTH * span)
        axis.broken_barh([(one.start, width)], (at - 0.38, 0.76), facecolor="none", edgecolor=BAD, lw=1.2)
        axis.text(one.start, at + 0.4, one.law, color=BAD, fontsize=6, clip_on=True)
    axis.set_yticks(range(len(rows)), rows[::-1])
    axis.set_xlim(report.start, report.start + span)
    axis.grid(axis="y", visible=False)
    return save(figure, path)


def _loaded(log: Log, report: AuditReport) -> list[list[tuple[float, float]]]:
    """Return (begin, length) of the times when each contact was loaded."""
    if "forces" not in log:
        return []
    count, time = len(log), np.asarray(log["time"], dtype=np.float64)
    starts = np.unique(np.linspace(0, count - 1, min(COLUMNS, count)).astype(int))
    on = np.empty((len(starts), len(report.contacts)), dtype=bool)
    for i, (a, b) in enumerate(zip(starts, [*starts[1:], count], strict=True)):
        on[i] = (np.asarray(log["forces"][a:b, :, 2]) > LOADED_SHARE * report.weight).any(axis=0)
    edges = np.append(time[starts], time[-1])
    width = np.maximum(np.nan_to_num(np.diff(edges)), 0.0)
    return [
        [(float(edges[i]), float(width[i])) for i in np.flatnonzero(on[:, k])] for k in range(on.shape[1])
    ]


def worst_moments(report: AuditReport) -> list[Violation]:
    """Return the violations furthest beyond their limits, one of each law."""
    best: dict[str, Violation] = {}
    for one in report.violations:
        if one.law not in best or _excess(one) > _excess(best[one.law]):
            best[one.law] = one
    chosen = [v for v in best.values() if v.law not in ("finite", "clock")]
    return sorted(chosen, key=_excess, reverse=True)[:MOMENTS]


def _excess(one: Violation) -> float:
    return one.value / one.limit if one.limit > 0.0 else one.value


def draw_moment(log: Log, report: AuditReport, moment: Violation, path: Path) -> Path | None:
    """Draw the robot with forces and cones in the middle of a violation; None where the log has no places."""
    if "contact_positions" not in log or "forces" not in log:
        return None
    time = np.asarray(log["time"], dtype=np.float64)
    row = int(np.nanargmin(np.abs(time - 0.5 * (moment.start + moment.end))))
    places = np.nan_to_num(np.asarray(log["contact_positions"][row], dtype=np.float64))
    forces = np.nan_to_num(np.asarray(log["forces"][row], dtype=np.float64))
    frames, mu = frames_of(log, row), friction_of(log, row)
    figure, axes = new_figure(size=(6.0, 5.0), subplot_kw={"projection": "3d"})
    axis = axes[0, 0]
    robot = robot_of(log)
    for bone in [] if robot is None else bones(robot, np.nan_to_num(np.asarray(log["q"][row]))):
        axis.plot(*bone.T, color=INK, lw=2.5, solid_capstyle="round")
    for k, place in enumerate(places):
        force = frames[k] @ forces[k] * (ARROW / report.weight)
        colour = BAD if report.contacts[k] == moment.contact else FORCE
        if forces[k, 2] > LOADED_SHARE * report.weight and 0.0 < mu[k] < np.inf:
            _cone(axis, place, frames[k], mu[k])
        axis.quiver(*place, *force, color=colour, lw=1.8, arrow_length_ratio=0.15)
        axis.text(*place, f" {report.contacts[k]}", fontsize=7, color=colour)
    _ground(axis, places)
    axis.set_title(f"{moment.law} of {moment.contact} at {time[row]:.3f} s: {moment.value:.3g} {moment.unit}")
    axis.set_aspect("equal")
    return save(figure, path)


def _cone(axis: Any, apex: FloatArray, frame: FloatArray, mu: float) -> None:
    rim = apex + cone_rim(mu, CONE, frame, 24)
    axis.plot(*rim.T, color=MUTED, lw=0.8)
    for edge in rim[::4]:
        axis.plot(*np.stack([apex, edge], axis=1), color=MUTED, lw=0.5)


def _ground(axis: Any, places: FloatArray) -> None:
    low, high = places.min(axis=0) - 0.1, places.max(axis=0) + 0.1
    x, y = np.meshgrid([low[0], high[0]], [low[1], high[1]])
    axis.plot_surface(x, y, np.full(x.shape, places[:, 2].min()), color=GROUND, alpha=0.4, lw=0)


def draw_audit(log: Log, report: AuditReport, folder: Path) -> list[Path]:
    """Draw an audit's timeline and worst moments into a folder and return their paths."""
    made = [draw_timeline(log, report, folder / "timeline.png")]
    for k, moment in enumerate(worst_moments(report), 1):
        drawn = draw_moment(log, report, moment, folder / f"moment_{k}_{moment.law}.png")
        made += [] if drawn is None else [drawn]
    return made
