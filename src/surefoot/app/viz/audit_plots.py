"""The picture of an audit: the feet over time, with violations marked."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from surefoot.app.viz.plots import spans
from surefoot.app.viz.style import BAD, FOOT_COLOURS, new_axis, save
from surefoot.records import Log
from surefoot.records.audit import AuditReport
from surefoot.records.audit.limits import LIMITS
from surefoot.records.audit.log_context import BODY

LEAST_WIDTH = 0.004
"""A violation is drawn at least so wide, as a share of the log."""


def draw_timeline(log: Log, report: AuditReport, path: Path) -> Path:
    """Draw when each contact was loaded (bars), and where which law was broken (red)."""
    rows = [*report.contacts, BODY]
    title = "Feet on the ground (bars) and broken laws (red)"
    figure, axis = new_axis((9.0, 0.45 * len(rows) + 1.4), title, xlabel="time [s]")
    span = max(report.end - report.start, 1e-9)
    time = np.nan_to_num(np.asarray(log["time"], dtype=np.float64))
    forces = np.asarray(log["forces"]) if "forces" in log else np.zeros((len(log), len(report.contacts), 3))
    for k, on in enumerate((forces[..., 2] > LIMITS.laws.loaded * report.weight).T):
        axis.broken_barh(
            spans(time, on), (len(rows) - 1 - k - 0.3, 0.6), color=FOOT_COLOURS[k % 8], alpha=0.35, lw=0
        )
    for one in report.violations:
        at = len(rows) - 1 - rows.index(one.contact)
        width = max(one.end - one.start, LEAST_WIDTH * span)
        axis.broken_barh([(one.start, width)], (at - 0.38, 0.76), facecolor="none", edgecolor=BAD, lw=1.2)
        axis.text(one.start, at + 0.4, one.law, color=BAD, fontsize=6, clip_on=True)
    axis.set_yticks(range(len(rows)), rows[::-1])
    axis.set_xlim(report.start, report.start + span)
    axis.grid(axis="y", visible=False)
    return save(figure, path)
