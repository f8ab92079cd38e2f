"""Plots of a plan: who touches when, forces, torques."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from surefoot.app.viz.plots import draw_cone_use, draw_normal_forces, draw_torques
from surefoot.app.viz.style import FOOT_COLOURS, new_axis, save

if TYPE_CHECKING:
    from surefoot.motion.planning.plan import Plan


def draw_contacts(plan: Plan, path: Path) -> Path:
    """Draw when each foot is on the ground, as bars."""
    figure, axis = new_axis((8.0, 0.45 * len(plan.facts["feet"]) + 1.3))
    draw_phases(plan, axis)
    return save(figure, path)


def draw_phases(plan: Plan, axis: Any) -> None:
    """Draw when each foot is on the ground, as bars on given axes."""
    names = plan.facts["feet"]
    axis.set(title="Contacts as planned", xlabel="time [s]")
    for k, name in enumerate(names):
        row = len(names) - 1 - k
        spans = [(p.start, p.end - p.start) for p in plan.contacts if p.foot == name]
        axis.broken_barh(spans, (row - 0.33, 0.66), color=FOOT_COLOURS[k % 8])
    axis.set_yticks(range(len(names)), names[::-1])
    axis.set(ylim=(-0.7, len(names) - 0.3), xlim=(0.0, plan["time"][-1] + float(plan.facts["dt"])))
    axis.grid(axis="y", visible=False)


def draw_plan(plan: Plan, folder: Path) -> list[Path]:
    """Draw every plot of a plan into a folder and return their paths."""
    made = [
        draw_contacts(plan, folder / "contacts.png"),
        draw_normal_forces(plan, folder / "normal_forces.png"),
        draw_cone_use(plan, folder / "cone_use.png"),
    ]
    if plan["torques"].shape[1]:
        made.append(draw_torques(plan, folder / "torques.png"))
    return made
