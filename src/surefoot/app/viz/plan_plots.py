"""Plots of a plan: who touches when, forces, torques."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from surefoot.app.viz.plots import draw_cone_use, draw_normal_forces, draw_torques
from surefoot.app.viz.style import draw_foot_bars, new_axis, save

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
    bars = {name: [(p.start, p.end - p.start) for p in plan.contacts if p.foot == name] for name in names}
    draw_foot_bars(axis, bars)
    axis.set(xlim=(0.0, plan["time"][-1] + float(plan.facts["dt"])))


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
