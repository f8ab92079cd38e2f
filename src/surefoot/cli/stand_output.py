"""What `surefoot stand` says: the verdict before, the tables after."""

from __future__ import annotations

import math

from surefoot.audit import StandSummary
from surefoot.cli.console import Cell, Table
from surefoot.cli.run_output import OUTCOMES, cost_line, error_and_laws, motor_lines, torque_line
from surefoot.spatial import GRAVITY

STAND_OUTCOMES = OUTCOMES | {
    "stood": "stood",
    "slipped": "slipped: a foot slid over the ground",
    "displaced": "did not hold its place",
}


def headline(summary: StandSummary) -> str:
    """Return one line that says how the run ended."""
    text = f"{summary.robot} {STAND_OUTCOMES[summary.outcome]}{error_and_laws(summary)}"
    return f"{text} for {summary.duration:.2f} s and no law was broken" if summary.good else text


def statics_line(phase: str, possible: bool, margin: float, needed: float, mu: float) -> str:
    """Return one line that says whether a stance is statically possible."""
    if possible:
        inside = f"every foot {margin:.1f} N inside its cone"
        return f"{phase}: possible, {inside}; needs friction {needed:.2f} of {mu:g}"
    if math.isinf(needed):
        return f"{phase}: not possible with any friction"
    return f"{phase}: not possible with friction {mu:g}; {needed:.2f} would be needed"


def tables(summary: StandSummary) -> list[Table]:
    """Return the table of feet."""
    feet: dict[str, Cell] = {
        "foot": lambda foot: foot.name,
        "normal force [N]": lambda foot: f"{foot.normal_force_mean:.2f}",
        "share of m g": lambda foot: f"{100 * foot.weight_share:.1f} %",
        "highest cone use": lambda foot: f"{100 * foot.cone_use_max:.0f} %",
        "slip [mm]": lambda foot: f"{1e3 * foot.slip:.2f}",
    }
    return [Table.of("Feet", summary.feet, feet)]


def figure_lines(summary: StandSummary) -> list[str]:
    """Return further figures, one line each."""
    base, weight, total = summary.base, summary.mass * GRAVITY, summary.normal_force_total_mean
    pressed = [
        f"centre of pressure of {foot.name} at least {1e3 * abs(foot.pressure_margin):.0f} mm inside its sole"
        for foot in summary.feet
        if foot.pressure_margin is not None
    ]
    return [
        f"mean total normal force {total:.2f} N, {100 * total / weight:.2f} % of m g = {weight:.1f} N",
        f"base moved at most {1e3 * base.position_max:.1f} mm and {base.tilt_max_deg:.2f} deg, "
        f"ended {1e3 * base.position_end:.2f} mm and {base.tilt_end_deg:.2f} deg from its place",
        torque_line(summary),
        *pressed,
        f"wanted wrench possible in {100 * summary.attained_share:.1f} % of the steps",
        *motor_lines(summary),
        cost_line(summary),
    ]
