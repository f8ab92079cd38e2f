"""The picture of why a run went wrong: the robot at its events, friction, balance and torques over time."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from surefoot.app.viz.recorded_outlines import outline, shape_points
from surefoot.app.viz.style import (
    BAD,
    FORCE,
    GROUND,
    INK,
    MUTED,
    blank_figure,
    draw_columns,
    house_style,
    save,
)
from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError
from surefoot.base.spatial import rotation_from_quaternion
from surefoot.records.audit import AuditReport
from surefoot.records.audit.log_context import Setting, setting_of
from surefoot.records.audit.logged_robot import LoggedRobot
from surefoot.records.audit.story.signals import Signals

MOST_EVENTS = 6
"""Events that the robot is drawn at, and that are named on the time axis."""
MOST_JOINTS = 5
"""Joints whose torques are drawn: those of causes, then the hardest worked."""


def draw_story(report: AuditReport, path: Path) -> Path:
    """Draw the story of an audit into a new file.

    Raises
    ------
    ProblemError
        For a report that has no log.
    MissingExtra
        If matplotlib is not installed.
    """
    figure = blank_figure()
    with house_style():
        draw_panels_of_story(report, figure)
    return save(figure, path)


def draw_panels_of_story(report: AuditReport, figure: Any) -> None:
    """Draw the story of an audit into an empty figure; its height goes with the number of panels."""
    if report.log is None:
        raise ProblemError("the report has no log: audit one first")
    log = report.log
    setting = setting_of(log, None, report.limits)
    s = Signals(log, setting)
    panels = _panels(s, report)
    figure.set_size_inches(6.0, 2.6 + 1.3 * len(panels))  # letters that are read at 400 pixels, too
    ratios = {"height_ratios": [2.0] + [1.3] * len(panels), "hspace": 0.25, "right": 0.76, "left": 0.13}
    axes = figure.subplots(1 + len(panels), 1, squeeze=False, gridspec_kw=ratios)[:, 0]
    for axis, label in zip(axes[1:], panels, strict=True):
        axis.set_ylabel(label)
        if axis is not axes[1]:
            axis.sharex(axes[1])
        axis.tick_params(labelbottom=axis is axes[-1])
    axes[-1].set_xlabel("time [s]" if panels else "")
    moments = _moments(report, s)
    _draw_robots(axes[0], s, setting, moments)
    for axis, (curves, names, limit) in zip(axes[1:], panels.values(), strict=True):
        draw_columns(axis, s.time, curves, names)
        if limit is not None:
            axis.axhline(limit, color=BAD, lw=0.8, ls=":")
        axis.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize=8, handlelength=1.0)
    for axis in axes[1:]:
        for time, _, is_cause in moments:
            axis.axvline(time, color=BAD if is_cause else MUTED, lw=1.2 if is_cause else 0.8)
    if panels:
        axes[-1].set_xlim(report.start, max(report.end, report.start + 1e-6))
    figure.suptitle(_title(report), fontsize=10, color=INK, wrap=True)


def _title(report: AuditReport) -> str:
    """Return how it failed and its first cause, broken into lines: the rest stands in the paragraph."""
    import textwrap

    failed, first = report.story.failure, report.first_cause
    words = [] if failed is None else [f"{failed.time:.2f} s: {failed.name}, {failed.evidence}."]
    words += [] if first is None else [f"First cause: {first.name} at {first.where}, {first.evidence}."]
    return "\n".join(textwrap.wrap(" ".join(words) or str(report.story), 70)[:4])


def _moments(report: AuditReport, s: Signals) -> list[tuple[float, str, bool]]:
    """Return time, words and whether it is a cause of what is drawn: start, causes, failure, end."""
    story = report.story
    found = [(c.time, f"{c.name}\n{c.where}", True) for c in story.causes[:2]]
    if story.failure is not None:
        found.append((story.failure.time, story.failure.name, False))
    shown = {(round(t, 3), words) for t, words, _ in found}
    for event in story.events:
        if len(found) < MOST_EVENTS - 1 and not any(abs(event.time - t) < 0.05 for t, _ in shown):
            found.append((event.time, event.name, False))
            shown.add((round(event.time, 3), event.name))
    found.append((float(s.time[-1]), "end", False))
    return sorted(found)


def _panels(s: Signals, report: AuditReport) -> dict[str, tuple[FloatArray, list[str], float | None]]:
    """Return label -> (T, k) curves, their names and the limit that is drawn."""
    out: dict[str, tuple[FloatArray, list[str], float | None]] = {}
    if s.loaded.any() and np.isfinite(s.mu).all():
        used = np.where(s.loaded, np.minimum(s.friction_use, 1.5), np.nan)
        busy = np.argsort(-s.forces[..., 2].sum(axis=0))[:6]
        out["friction\nneeded / mu"] = used[:, busy], [s.names[k] for k in busy], 1.0
    if s.floating and s.loaded.any():
        curves = np.stack([100.0 * s.capture_outside, np.degrees(s.lean)], axis=1)
        out["balance"] = curves, ["capture point\noutside feet [cm]", "lean [deg]"], 0.0
    if s.torques.shape[1]:
        most = np.abs(s.torques).max(axis=0)
        limit = np.where(np.isfinite(s.torque_limits), s.torque_limits, np.maximum(most.max(), 1e-9))
        share = s.torques / np.maximum(limit, 1e-9)
        named = [k for k, name in enumerate(s.joints) if any(name in c.where for c in report.causes[:2])]
        hard = [k for k in np.argsort(-np.abs(share).mean(axis=0)).tolist() if k not in named]
        chosen = [*named, *hard][:MOST_JOINTS]
        out["torque\n/ largest"] = share[:, chosen], [s.joints[k] for k in chosen], 1.0
    return out


def _draw_robots(axis: Any, s: Signals, setting: Setting, moments: list[tuple[float, str, bool]]) -> None:
    """Draw the robot from its side at every moment, in a row, with its ground contacts and their forces."""
    axis.set_axis_off()
    axis.set_aspect("equal", adjustable="datalim")
    axis.set_xlim(0.0, len(moments))
    forward, shapes = _heading(s), shape_points(s.log) if s.jointless else []
    reach = max((float(np.linalg.norm(points, axis=1).max()) for points in shapes), default=0.1)
    size = 2.2 * max(s.height, reach)
    for place, (time, words, is_cause) in enumerate(moments):
        row = int(np.searchsorted(s.time, time).clip(0, len(s.time) - 1))
        centre = np.array([s.com[row] @ forward, s.com[row] @ s.up])

        def at(points: FloatArray, place: int = place, centre: FloatArray = centre) -> FloatArray:
            flat = np.stack([points @ forward, points @ s.up], axis=-1) - centre
            return np.asarray(flat / size + np.array([place + 0.5, 0.0]))

        axis.add_patch(_ground(s, row, at))
        if s.jointless:
            _draw_body(axis, shapes, s.numbers("q")[row], at)
        elif setting.robot is not None:
            _draw_links(axis, setting.robot, s, row, at)
        for k in np.flatnonzero(s.loaded[row]):
            foot = s.positions[row, k]
            ends = at(np.stack([foot, foot + s.world_forces[row, k] / s.weight * s.height]))
            axis.annotate("", ends[1], ends[0], arrowprops={"arrowstyle": "-|>", "color": FORCE})
        com = at(s.com[row][None])[0]
        axis.plot(*com, "o", color=INK, ms=3)
        colour = BAD if is_cause else INK
        axis.text(place + 0.5, 0.62, f"{time:.2f} s", ha="center", fontsize=8, color=colour)
        axis.text(
            place + 0.5, 0.78, words.replace(" ", "\n"), ha="center", va="bottom", fontsize=8, color=colour
        )
    axis.set_ylim(-0.8, 1.1)


def _heading(s: Signals) -> FloatArray:
    """Return the level direction (3,) in which the centre of mass goes farthest."""
    moved = s.com - s.com[0]
    moved = moved - np.outer(moved @ s.up, s.up)
    far = moved[int(np.abs(moved).sum(axis=1).argmax())]
    size = float(np.linalg.norm(far))
    if size > 1e-6:
        return np.asarray(far / size)
    return np.asarray(np.cross(s.up, np.eye(3)[int(np.abs(s.up).argmin())]))


def _ground(s: Signals, row: int, at: Any) -> Any:
    """Return a line for the ground under the loaded contacts of a row."""
    from matplotlib.patches import Polygon

    on = s.loaded[row] & ~s.on_movable
    level = s.positions[row][on] if on.any() else s.positions[row]
    if not len(level):
        level = s.com[row][None]
    middle = level[int((level @ s.up).argmin())]
    normal = s.normals[row][on][0] if on.any() else s.up
    along = _heading(s) - normal * (normal @ _heading(s))
    along = along / max(float(np.linalg.norm(along)), 1e-9) * 0.9 * max(s.height, 0.1)
    corners = np.stack(
        [middle - along, middle + along, middle + along - 0.1 * s.up, middle - along - 0.1 * s.up]
    )
    return Polygon(at(corners), facecolor=GROUND, edgecolor=MUTED, lw=0.6)


def _draw_body(axis: Any, shapes: list[FloatArray], q: FloatArray, at: Any) -> None:
    """Draw the outlines of a body without joints at a (7,) pose."""
    from matplotlib.patches import Polygon

    turn = rotation_from_quaternion(q[3:7])
    for points in shapes:
        corners = outline(at(points @ turn.T + q[:3]))
        axis.add_patch(Polygon(corners, facecolor="none", edgecolor=INK, lw=1.6))


def _draw_links(axis: Any, robot: LoggedRobot, s: Signals, row: int, at: Any) -> None:
    """Draw lines from joint to joint of a robot in a row of its log, and on to its feet."""
    import pinocchio

    data = robot.model.createData()
    pinocchio.forwardKinematics(robot.model, data, s.numbers("q")[row])
    places = np.array([data.oMi[j].translation for j in range(robot.model.njoints)])
    ends = [places[[int(robot.model.parents[j]), j]] for j in range(2, robot.model.njoints)]
    for k, owner in enumerate(robot.support):  # from the last joint of a leg to where it touches
        joint = max(
            (j for j in range(1, robot.model.njoints) if owner[robot.model.joints[j].idx_v]), default=1
        )
        if s.is_foot[k]:
            ends.append(np.stack([places[joint], s.positions[row, k]]))
    for pair in ends:
        line = at(pair)
        axis.plot(line[:, 0], line[:, 1], color=INK, lw=1.6, solid_capstyle="round")
