"""What `surefoot stand` and `surefoot walk` both say: outcomes, the laws as numbers, motors, time."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from surefoot.audit import RunSummary
from surefoot.audit.laws import CONE_LIMIT, PENETRATION_LIMIT, SLIDE_LIMIT
from surefoot.cli.console import Table

if TYPE_CHECKING:
    from surefoot.log import Log

IDLE = 0.9
"""CPU over real time of a run below which its longest times are not its own."""
OUTCOMES = {
    "fell": "fell",
    "interrupted": "was interrupted",
    "stopped": "was stopped",
    "lost": "lost the estimate of its state and stopped",
    "invalid": "was lost: the simulated state is no longer finite",
}
"""How runs end that did not go as they should, whatever the robot did."""


def law_table(summary: RunSummary) -> Table:
    """Return the three laws as numbers."""
    laws, limit = summary.laws, max(PENETRATION_LIMIT, summary.laws.sinking)

    def mm(metres: float, form: str = "g") -> str:
        return f"{1e3 * metres:{form}} mm"

    rows = [
        ["1 unilateral: deepest penetration", mm(laws.penetration_max, ".3f"), mm(limit, ".3g")],
        ["1 unilateral: least normal force", f"{laws.unilateral_min:.3g} N", "0 N"],
        ["1 unilateral: widest gap under a force", mm(laws.separation_max, ".3f"), mm(limit, ".3g")],
        ["2 Coulomb: highest use of the cone", f"{laws.cone_use_max:.3f}", f"{CONE_LIMIT:g}"],
        ["3 dissipation: slide without friction", mm(laws.free_slide_max, ".3f"), mm(SLIDE_LIMIT)],
    ]
    return Table("The three laws, from the world's own forces", ("law", "measured", "limit"), rows)


def error_and_laws(summary: RunSummary) -> str:
    """Return what a headline says about an error and broken laws; empty if there is neither."""
    text = f": {summary.error}" if summary.error else ""
    for what, lines in (("laws broken", summary.laws_broken), ("limits not kept", summary.limits_broken)):
        text += f"; {what}: " + ", ".join(lines) if lines else ""
    return text


def torque_line(summary: RunSummary) -> str:
    """Return one line about the joints' torques."""
    if summary.torque_use_max == 0.0:  # a torque over no limit
        return "how hard joints worked is not known: the robot's file says nothing of their torque limits"
    use = 100 * summary.torque_use_max
    return f"hardest worked joint {summary.torque_use_joint}, at {use:.0f} % of its limit"


def motor_lines(summary: RunSummary) -> list[str]:
    """Return what is said about the use of the motors: a line, or none."""
    use = summary.motors
    if use is None:
        return []
    cut = "motors cut off" if use.actuators != "ideal" else "real motors would cut off"
    return [
        f"{use.actuators} actuators: fastest joint {use.speed_use_joint} at {100 * use.speed_use_max:.0f} %"
        f" of its largest speed, some joint beyond it in {100 * use.over_speed_share:.2g} % of the steps; "
        f"{cut} torque in {100 * use.beyond_curve_share:.2g} % of them"
    ]


def busy_line(log: Log) -> list[str]:
    """Return what is said about times where the machine was busy: a line, or none."""
    share = float(log.facts.get("cpu_time", math.inf)) / max(float(log.facts.get("wall_time", 0.0)), 1e-9)
    if not share < IDLE:
        return []
    return [
        f"the run had {100 * share:.0f} % of a core: the machine was busy, or another process worked, "
        "and longest times are not the controller's own"
    ]


def cost_line(summary: RunSummary) -> str:
    """Return one line about time."""
    step = summary.controller_step_us
    return (
        f"controller step {step.median:.0f} us median, {step.p99:.0f} us at the 99th percentile, "
        f"{step.largest:.0f} us at most; "
        f"the run {summary.real_time_factor:.1f} times faster than real time"
    )
