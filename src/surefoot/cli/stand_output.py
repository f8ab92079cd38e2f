"""What `surefoot stand` says: the verdict before, the table after, the sections of the report."""

from __future__ import annotations

import math
from typing import Any

from surefoot.audit.laws import CONE_LIMIT, PENETRATION_LIMIT, SLIDE_LIMIT
from surefoot.spatial import GRAVITY

OUTCOMES = {
    "stood": "stood",
    "slipped": "slipped: a foot slid over the ground",
    "fell": "fell",
    "displaced": "did not hold its place",
    "interrupted": "was interrupted",
    "stopped": "was stopped",
    "invalid": "was lost: the simulated state is no longer finite",
}


def headline(summary: dict[str, Any]) -> str:
    """Return one line that says how the run ended."""
    text = f"{summary['robot']} {OUTCOMES[summary['outcome']]}"
    if summary["error"]:
        text += f": {summary['error']}"
    if summary["laws_broken"]:
        text += "; laws broken: " + ", ".join(summary["laws_broken"])
    elif summary["stood"]:
        text += f" for {summary['duration']:.2f} s and no law was broken"
    return text


def statics_line(phase: str, possible: bool, margin: float, needed: float, mu: float) -> str:
    """Return one line that says whether a stance is statically possible."""
    if possible:
        inside = f"every foot {margin:.1f} N inside its cone"
        return f"{phase}: possible, {inside}; needs friction {needed:.2f} of {mu:g}"
    if math.isinf(needed):
        return f"{phase}: not possible with any friction"
    return f"{phase}: not possible with friction {mu:g}; {needed:.2f} would be needed"


def foot_rows(summary: dict[str, Any]) -> list[list[str]]:
    """Return the table of feet: name, mean normal force, share of weight, cone use, slip."""
    return [
        [
            foot["name"],
            f"{foot['normal_force_mean']:.2f}",
            f"{100 * foot['weight_share']:.1f} %",
            f"{100 * foot['cone_use_max']:.0f} %",
            f"{1e3 * foot['slip']:.2f}",
        ]
        for foot in summary["feet"]
    ]


FOOT_HEADER = ("foot", "normal force [N]", "share of m g", "highest cone use", "slip [mm]")


def law_rows(summary: dict[str, Any]) -> list[list[str]]:
    """Return the three laws as numbers."""
    laws, weight = summary["laws"], summary["mass"] * GRAVITY
    return [
        [
            "1 unilateral: deepest penetration",
            f"{1e3 * laws['penetration_max']:.3f} mm",
            f"{1e3 * PENETRATION_LIMIT:g} mm",
        ],
        ["1 unilateral: least normal force", f"{laws['unilateral_min']:.3g} N", "0 N"],
        [
            "1 unilateral: force times gap",
            f"{laws['complementarity_max']:.3g} N m",
            f"{PENETRATION_LIMIT * weight:.2g} N m",
        ],
        ["2 Coulomb: highest use of the cone", f"{laws['cone_use_max']:.3f}", f"{CONE_LIMIT:g}"],
        [
            "3 dissipation: slide without friction",
            f"{1e3 * laws['free_slide_max']:.3f} mm",
            f"{1e3 * SLIDE_LIMIT:g} mm",
        ],
    ]


LAW_HEADER = ("law", "measured", "limit")


def figure_lines(summary: dict[str, Any]) -> list[str]:
    """Return further figures, one line each."""
    base, step = summary["base"], summary["controller_step_us"]
    weight = summary["mass"] * GRAVITY
    total = summary["normal_force_total_mean"]
    pressed = [
        f"centre of pressure of {foot['name']} at least {1e3 * abs(foot['pressure_margin']):.0f} mm inside "
        "its sole"
        for foot in summary["feet"]
        if "pressure_margin" in foot
    ]
    return [
        f"mean total normal force {total:.2f} N, {100 * total / weight:.2f} % of m g = {weight:.1f} N",
        f"base moved at most {1e3 * base['position_max']:.1f} mm and {base['tilt_max_deg']:.2f} deg, "
        f"ended {1e3 * base['position_end']:.2f} mm and {base['tilt_end_deg']:.2f} deg from its place",
        f"hardest worked joint {summary['torque_use_joint']}, at {100 * summary['torque_use_max']:.0f} % of "
        "its limit",
        *pressed,
        f"wanted wrench possible in {100 * summary['attained_share']:.1f} % of the steps",
        f"controller step {step['median']:.0f} us median, {step['p99']:.0f} us at the 99th percentile; "
        f"the run {summary['real_time_factor']:.1f} times faster than real time",
    ]


def print_summary(console: Any, summary: dict[str, Any]) -> None:
    """Print the tables and figures of a run."""
    from rich.table import Table

    for header, rows in ((FOOT_HEADER, foot_rows(summary)), (LAW_HEADER, law_rows(summary))):
        table = Table()
        for k, name in enumerate(header):
            table.add_column(name, justify="left" if k == 0 else "right")
        for row in rows:
            table.add_row(*row)
        console.print(table)
    for line in figure_lines(summary):
        console.print(line, soft_wrap=True, highlight=False)


def report_sections(summary: dict[str, Any], statics: list[str]) -> list[tuple[str, str]]:
    """Return the report's sections of text and tables."""
    from surefoot.viz.report import paragraph, table

    return [
        ("Is the stance possible?", "".join(paragraph(line) for line in statics)),
        ("Feet", table(FOOT_HEADER, foot_rows(summary))),
        ("The three laws, from the world's own forces", table(LAW_HEADER, law_rows(summary))),
        ("Figures", "".join(paragraph(line) for line in figure_lines(summary))),
    ]
