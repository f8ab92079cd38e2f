"""Plots of a plan: who touches when, forces, the base's motion, torques."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from surefoot.viz.plots import draw_cone_use, draw_normal_forces, draw_torques
from surefoot.viz.style import FOOT_COLOURS, INK, draw_columns, new_axis, new_figure, save

if TYPE_CHECKING:
    from surefoot.planning.plan import Plan

LEAST_SPAN = 0.02
"""Least range of an axis of positions [m]: a motion of nothing should look like nothing."""


def draw_contacts(plan: Plan, path: Path) -> Path:
    """Draw when each foot is on the ground, as bars."""
    names = plan.facts["feet"]
    title = "Contacts as planned"
    figure, axis = new_axis((8.0, 0.45 * len(names) + 1.3), title, xlabel="time [s]")
    for k, name in enumerate(names):
        row = len(names) - 1 - k
        spans = [(p.start, p.end - p.start) for p in plan.contacts if p.foot == name]
        axis.broken_barh(spans, (row - 0.33, 0.66), color=FOOT_COLOURS[k % 8])
    axis.set_yticks(range(len(names)), names[::-1])
    axis.set(ylim=(-0.7, len(names) - 0.3), xlim=(0.0, _ends(plan)[-1]))
    axis.grid(axis="y", visible=False)
    return save(figure, path)


def draw_plan_motion(plan: Plan, path: Path) -> Path:
    """Draw the first coordinates of the configuration, and where the contact points go."""
    figure, axes = new_figure(2, 1, size=(8.0, 4.8))
    q = np.vstack([plan["q"], np.asarray(plan.facts["end_q"])])
    floating = plan.robot is None or plan.robot.floating
    labels = ("x [m]", "y [m]", "z [m]") if floating else tuple(map(str, plan.facts["joints"]))
    upper, lower = axes[0, 0], axes[1, 0]
    shown = min(len(labels), 8, q.shape[1])
    draw_columns(upper, _ends(plan), q[:, :shown], labels)
    upper.set(title="The base" if floating else "The joints", xlabel="time [s]")
    _least_range(upper)
    upper.legend(ncols=4, fontsize=8)
    points = plan["contact_positions"]
    lower.plot(q[:, 0], q[:, 2] if floating else q[:, min(1, q.shape[1] - 1)], color=INK, lw=1.2)
    if floating:
        for k, name in enumerate(plan.facts["feet"]):
            first = int(np.flatnonzero(np.asarray(plan.facts["contact_foot"]) == k)[0])
            colour = FOOT_COLOURS[k % 8]
            lower.plot(points[:, first, 0], points[:, first, 2], color=colour, lw=0.8, label=name)
        lower.set(xlabel="x [m]", ylabel="z [m]", title="Paths of base and feet, from the side")
        lower.set_aspect("equal", adjustable="datalim")
        lower.legend(ncols=4, fontsize=8)
    else:
        lower.set(xlabel=labels[0], ylabel=labels[min(1, len(labels) - 1)], title="The first two coordinates")
        _least_range(lower)
    return save(figure, path)


def draw_plan(plan: Plan, folder: Path) -> list[Path]:
    """Draw every plot of a plan into a folder and return their paths."""
    made = [
        draw_contacts(plan, folder / "contacts.png"),
        draw_normal_forces(plan, folder / "normal_forces.png"),
        draw_cone_use(plan, folder / "cone_use.png"),
        draw_plan_motion(plan, folder / "motion.png"),
    ]
    if plan["torques"].shape[1]:
        made.append(draw_torques(plan, folder / "torques.png"))
    return made


def _ends(plan: Plan) -> np.ndarray:
    """Return the times of all states, the last one's included [s]."""
    return np.append(plan["time"], plan["time"][-1] + float(plan.facts["dt"]))


def _least_range(axis: object) -> None:
    """Widen an axis whose values hardly differ."""
    low, high = axis.get_ylim()  # type: ignore[attr-defined]
    if high - low < LEAST_SPAN:
        middle = 0.5 * (low + high)
        axis.set_ylim(middle - 0.5 * LEAST_SPAN, middle + 0.5 * LEAST_SPAN)  # type: ignore[attr-defined]
