"""The picture of an audit: the feet over time, with violations marked."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from surefoot.audit import AuditReport
from surefoot.audit.laws import LOADED_SHARE
from surefoot.audit.setting import BODY
from surefoot.log import Log
from surefoot.viz.style import BAD, FOOT_COLOURS, new_axis, save

COLUMNS = 1500
"""The timeline has so many columns at most; a foot is drawn as loaded where it is in any row of one."""
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
