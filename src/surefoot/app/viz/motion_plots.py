"""The picture and the page of a certified motion: the robot in a row, residuals and forces over time."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from surefoot.app.viz.shapes import bones
from surefoot.app.viz.style import BAD, FORCE, GOOD, GROUND, INK, MUTED, WARN, blank_figure, house_style, save
from surefoot.base.arrays import FloatArray
from surefoot.base.spatial import GRAVITY, heading_of
from surefoot.records.certificates.motion_report import MotionReport

STRIP = 10
"""Robots in the row."""
COLOURS = {"possible": GOOD, "cannot tell": WARN, "impossible": BAD, "no window": MUTED}
"""Of verdicts."""


def draw_motion(report: MotionReport, path: Path) -> Path:
    """Draw a certified motion into a new file: robots with the force that nothing can give, shares over time.

    Raises
    ------
    MissingExtra
        If matplotlib is not installed.
    """
    figure = blank_figure((9.0, 6.0))
    with house_style():
        draw_panels_of_motion(report, figure)
    return save(figure, path)


def draw_panels_of_motion(report: MotionReport, figure: Any) -> None:
    """Draw a certified motion into an empty figure."""
    ratios = {"height_ratios": [2.0, 1.3, 1.0], "hspace": 0.3}
    strip, share, ground = figure.subplots(3, 1, gridspec_kw=ratios)
    _draw_robots(strip, report)
    _draw_share(share, report)
    _draw_ground(ground, report)
    figure.suptitle(str(report), fontsize=9, color=INK, wrap=True)


def write_motion_page(report: MotionReport, path: Path) -> Path:
    """Write a page with the picture and the table of a certified motion into a new file.

    Raises
    ------
    ProblemError
        If the file exists already.
    MissingExtra
        If matplotlib is not installed.
    """
    from tempfile import TemporaryDirectory

    from surefoot.app.viz.report import embed_picture, paragraph, table, write_report

    with TemporaryDirectory() as folder:
        drawn = embed_picture(draw_motion(report, Path(folder) / "motion.png"))
    header = ("from [s]", "to [s]", "cause", "where", "worst [m g]", "cure")
    rows = [
        (f"{s.start:.2f}", f"{s.end:.2f}", s.cause, s.where, f"{s.worst:.2f}", s.cure)
        for s in report.segments
    ]
    good = ", ".join(f"{a:.2f} to {b:.2f} s" for a, b in report.good()) or "none of a second"
    sections = [
        ("Frame by frame", drawn),
        ("Impossible stretches", table(header, rows) if rows else paragraph("none")),
        ("To train on", paragraph(good)),
        ("What was assumed", "".join(paragraph(line) for line in report.notes)),
    ]
    verdict = (str(report), report.verdict == "possible")
    return write_report(path, f"Is it possible? {report.motion.name}", verdict, sections, "sf.certify_motion")


def _draw_robots(axis: Any, report: MotionReport) -> None:
    """Draw the robot from its side at even times, with the force that is missing."""
    axis.set_axis_off()
    axis.set_aspect("equal")
    data, frames, q = report.data, report.frames, report.motion.q
    chosen = np.unique(np.linspace(0, len(q) - 1, min(STRIP, len(q))).astype(int))
    height = max(float(np.ptp(data.model.motion.origins[..., 2])), 0.3)
    headings = [heading_of(q[k, 3:7]) for k in chosen]
    views = [
        _project((bones(report.motion.robot, q[k]) - [*q[k, :2], 0.0]).reshape(-1, 3), side).reshape(-1, 2, 2)
        for k, side in zip(chosen, headings, strict=True)
    ]
    apart = max(0.9 * height, 1.15 * max(float(np.ptp(view[..., 0])) for view in views if len(view)))
    for place, (k, side, view) in enumerate(zip(chosen, headings, views, strict=True)):
        start = np.array([apart * place, 0.0])
        axis.plot(
            *np.moveaxis(view + start, -1, 0).swapaxes(1, 2), color=COLOURS[str(frames.verdict[k])], lw=1.6
        )
        missing = frames.force[k]
        if np.isfinite(missing).all() and frames.share[k] > report.possible:
            com = _project((data.model.motion.com[k] - [*q[k, :2], 0.0])[None], side)[0] + start
            arrow = 0.5 * height * _project(missing[None] / (data.model.rules.mass * GRAVITY), side)[0]
            drawn = {"arrowstyle": "->", "color": FORCE, "lw": 1.5}
            axis.annotate("", xy=com + arrow, xytext=com, arrowprops=drawn)
        axis.text(apart * place, -0.2 * height, f"{frames.time[k]:.1f} s", ha="center", va="top", fontsize=7)
    axis.axhline(0.0, color=GROUND, lw=3.0, zorder=0)


def _project(points: FloatArray, side: FloatArray) -> FloatArray:
    """Return (n, 3) points from the side: along (2,) a heading, and up."""
    return np.stack([points[:, :2] @ side[:2], points[:, 2]], axis=1)


def _draw_share(axis: Any, report: MotionReport) -> None:
    """Draw the residual over time, its verdicts as colours."""
    frames = report.frames
    for name, colour in COLOURS.items():
        of_it = frames.verdict == name
        axis.plot(frames.time[of_it], frames.share[of_it], ".", ms=3, color=colour, label=name)
    axis.axhline(report.impossible, color=BAD, lw=0.8, ls=":")
    axis.axhline(report.possible, color=COLOURS["possible"], lw=0.8, ls=":")
    axis.set_ylabel("left over [m g]")
    axis.legend(loc="upper right", fontsize=7, ncols=4)


def _draw_ground(axis: Any, report: MotionReport) -> None:
    """Draw how far the lowest point is above or in the ground."""
    frames = report.frames
    axis.plot(frames.time, 100.0 * (frames.gap - frames.penetration), color=INK)
    axis.axhline(0.0, color=MUTED, lw=0.8)
    axis.set_ylabel("lowest [cm]")
    axis.set_xlabel("time [s]")
