"""What `surefoot walk` says: the verdict, the tables, the sections of the report."""

from __future__ import annotations

from typing import Any

from surefoot.cli.stand_output import LAW_HEADER, law_rows

OUTCOMES = {
    "walked": "walked",
    "did not follow": "did not follow its command: it moved",
    "fell": "fell",
    "interrupted": "was interrupted",
    "stopped": "was stopped",
    "invalid": "was lost: the simulated state is no longer finite",
}
VELOCITY_HEADER = ("velocity after 2 s", "commanded", "measured mean", "error", "within 10 %")
FOOT_HEADER = ("foot", "footfalls", "on the ground", "share of m g", "highest cone use", "slip [mm]")


def headline(summary: dict[str, Any]) -> str:
    """Return one line that says how the run ended."""
    text = f"{summary['robot']} {OUTCOMES[summary['outcome']]}"
    text += f" {'after' if summary['outcome'] == 'fell' else 'for'} {summary['duration']:.2f} s"
    text += f" and {summary['distance']:.2f} m"
    if summary["error"]:
        text += f": {summary['error']}"
    if summary["laws_broken"]:
        text += "; laws broken: " + ", ".join(summary["laws_broken"])
    elif summary["walked"]:
        text += ", no law was broken"
    if summary["outcome"] == "did not follow":
        v = summary["velocity"]
        wanted, reached = (
            ", ".join(f"{v[axis][key]:.2f}" for axis in ("forward", "left", "turn"))
            for key in ("commanded", "measured")
        )
        text += f"; commanded {wanted} (m/s, m/s, rad/s), reached {reached}"
    if summary["walked"] and not summary["velocity"]["within"]:
        text += "; its velocity was more than 10 % off"
    return text


def velocity_rows(summary: dict[str, Any]) -> list[list[str]]:
    """Return the table of velocities."""
    rows = []
    for axis, unit in (("forward", "m/s"), ("left", "m/s"), ("turn", "rad/s")):
        v = summary["velocity"][axis]
        rows.append(
            [
                f"{axis} [{unit}]",
                f"{v['commanded']:.3f}",
                f"{v['measured']:.3f}",
                f"{v['error']:+.3f}",
                "yes" if v["within"] else "no",
            ]
        )
    return rows


def foot_rows(summary: dict[str, Any]) -> list[list[str]]:
    """Return the table of feet."""
    return [
        [
            foot["name"],
            str(foot["footfalls"]),
            f"{100 * foot['duty']:.0f} %",
            f"{100 * foot['weight_share']:.1f} %",
            f"{100 * foot['cone_use_max']:.0f} %",
            f"{1e3 * foot['slip']:.2f}",
        ]
        for foot in summary["feet"]
    ]


def figure_lines(summary: dict[str, Any]) -> list[str]:
    """Return further figures, one line each."""
    step = summary["controller_step_us"]
    excess = summary["commanded_cone_excess"]
    return [
        *summary["notes"],
        "no commanded force left its friction cone"
        if excess <= 1e-9
        else f"commanded forces left their cones by up to {excess:.3g} N",
        f"base climbed {summary['climb']:.2f} m and leant at most {summary['tilt_max_deg']:.1f} deg",
        f"hardest worked joint {summary['torque_use_joint']} "
        f"at {100 * summary['torque_use_max']:.0f} % of its limit",
        f"whole-body step possible within all limits in {100 * summary['feasible_share']:.2f} % of the steps",
        f"controller step {step['median']:.0f} us median, {step['p99']:.0f} us at the 99th percentile; "
        f"the run {summary['real_time_factor']:.1f} times faster than real time",
    ]


def print_summary(console: Any, summary: dict[str, Any]) -> None:
    """Print the tables and figures of a run."""
    from rich.table import Table

    tables = (
        (VELOCITY_HEADER, velocity_rows(summary)),
        (FOOT_HEADER, foot_rows(summary)),
        (LAW_HEADER, law_rows(summary)),
    )
    for header, rows in tables:
        table = Table()
        for k, name in enumerate(header):
            table.add_column(name, justify="left" if k == 0 else "right")
        for row in rows:
            table.add_row(*row)
        console.print(table)
    for line in figure_lines(summary):
        console.print(line, soft_wrap=True, highlight=False)


def report_sections(summary: dict[str, Any]) -> list[tuple[str, str]]:
    """Return the report's sections of text and tables."""
    from surefoot.viz.report import paragraph, table

    return [
        ("Velocity", table(VELOCITY_HEADER, velocity_rows(summary))),
        ("Feet", table(FOOT_HEADER, foot_rows(summary))),
        ("The three laws, from the world's own forces", table(LAW_HEADER, law_rows(summary))),
        ("Figures", "".join(paragraph(line) for line in figure_lines(summary))),
    ]
