"""What `surefoot stand` and `surefoot walk` say: outcomes, tables, the laws as numbers, motors, time."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from surefoot.app.cli.console import Cell, Table
from surefoot.base.spatial import GRAVITY
from surefoot.records.audit import RunSummary, StandSummary, WalkSummary
from surefoot.records.audit.limits import LIMITS

if TYPE_CHECKING:
    from surefoot.records import Log

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
    laws, (limit, way) = summary.laws, summary.laws.add_softness()

    def mm(metres: float, form: str = "g") -> str:
        return f"{1e3 * metres:{form}} mm"

    rows = [
        ["1 unilateral: deepest penetration", mm(laws.penetration_max, ".3f"), mm(limit, ".3g")],
        ["1 unilateral: least normal force", f"{laws.unilateral_min:.3g} N", "0 N"],
        ["1 unilateral: widest gap under a force", mm(laws.separation_max, ".3f"), mm(limit, ".3g")],
        ["2 Coulomb: highest use of the cone", f"{laws.cone_use_max:.3f}", f"{LIMITS.laws.cone:g}"],
        ["3 dissipation: slide without friction", mm(laws.free_slide_max, ".3f"), mm(way, ".3g")],
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


def world_lines(summary: RunSummary) -> list[str]:
    """Return what is said about where the run took place: a line, or none."""
    soft = summary.unsolved_steps
    left = f"; steps whose contacts were not solved, and are MuJoCo's soft ones: {soft}" if soft else ""
    return [f"world: {summary.world}{left}"] if summary.world else []


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


STAND_OUTCOMES = OUTCOMES | {
    "stood": "stood",
    "slipped": "slipped: a foot slid over the ground",
    "displaced": "did not hold its place",
}


def stand_headline(summary: StandSummary) -> str:
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


FOOT_USE: dict[str, Cell] = {
    "share of m g": lambda foot: f"{100 * foot.weight_share:.1f} %",
    "highest cone use": lambda foot: f"{100 * foot.cone_use_max:.0f} %",
    "slip [mm]": lambda foot: f"{1e3 * foot.slip:.2f}",
}
"""Columns of every table of feet."""


def stand_tables(summary: StandSummary) -> list[Table]:
    """Return the table of feet."""
    feet: dict[str, Cell] = {
        "foot": lambda foot: foot.name,
        "normal force [N]": lambda foot: f"{foot.normal_force_mean:.2f}",
    }
    return [Table.of("Feet", summary.feet, feet | FOOT_USE)]


def stand_lines(summary: StandSummary) -> list[str]:
    """Return further figures, one line each."""
    base, weight, total = summary.base, summary.mass * GRAVITY, summary.normal_force_total_mean
    pressed = [
        f"centre of pressure of {foot.name} at least {1e3 * abs(foot.pressure_margin):.0f} mm inside its sole"
        for foot in summary.feet
        if foot.pressure_margin is not None
    ]
    return [
        *world_lines(summary),
        f"mean total normal force {total:.2f} N, {100 * total / weight:.2f} % of m g = {weight:.1f} N",
        f"base moved at most {1e3 * base.position_max:.1f} mm and {base.tilt_max_deg:.2f} deg, "
        f"ended {1e3 * base.position_end:.2f} mm and {base.tilt_end_deg:.2f} deg from its place",
        torque_line(summary),
        *pressed,
        f"wanted wrench possible in {100 * summary.attained_share:.1f} % of the steps",
        *motor_lines(summary),
        cost_line(summary),
    ]


WALK_OUTCOMES = OUTCOMES | {"walked": "walked", "did not follow": "did not follow its command: it moved"}
FOUND, LEVER = 0.01, 0.1
"""Share of the robot's mass or weight that counts as a load found, and arm of its moment [m]."""
AXES = (("forward", "m/s"), ("left", "m/s"), ("turn", "rad/s"))


def walk_headline(summary: WalkSummary) -> str:
    """Return one line that says how the run ended."""
    v = summary.velocity
    text = f"{summary.robot} {WALK_OUTCOMES[summary.outcome]}"
    text += f" {'after' if summary.outcome in ('fell', 'lost') else 'for'} {summary.duration:.2f} s"
    text += f" and {summary.distance:.2f} m{error_and_laws(summary)}"
    if summary.good:
        text += ", no law was broken"
    if summary.outcome == "did not follow":
        axes = [getattr(v, axis) for axis, _ in AXES]
        wanted, reached = (
            ", ".join(f"{getattr(axis, key):.2f}" for axis in axes) for key in ("commanded", "measured")
        )
        text += f"; commanded {wanted} (m/s, m/s, rad/s), reached {reached}"
    if summary.success and not v.within:
        text += "; its velocity was more than 10 % off"
    return text


def walk_tables(summary: WalkSummary) -> list[Table]:
    """Return the walk_tables of velocities and of feet."""
    velocity: dict[str, Cell] = {
        "velocity after 2 s": lambda pair: f"{pair[0]} [{pair[1]}]",
        "commanded": lambda pair: f"{getattr(summary.velocity, pair[0]).commanded:.3f}",
        "measured mean": lambda pair: f"{getattr(summary.velocity, pair[0]).measured:.3f}",
        "error": lambda pair: f"{getattr(summary.velocity, pair[0]).error:+.3f}",
        "within 10 %": lambda pair: "yes" if getattr(summary.velocity, pair[0]).within else "no",
    }
    feet: dict[str, Cell] = {
        "foot": lambda foot: foot.name,
        "footfalls": lambda foot: str(foot.footfalls),
        "on the ground": lambda foot: f"{100 * (foot.duty or 0.0):.0f} %",
    }
    return [Table.of("Velocity", AXES, velocity), Table.of("Feet", summary.feet, feet | FOOT_USE)]


def walk_lines(summary: WalkSummary) -> list[str]:
    """Return further figures, one line each."""
    excess = summary.commanded_cone_excess
    return [
        *world_lines(summary),
        *summary.notes,
        "the controller counts on no forces"
        if math.isnan(excess)
        else "no commanded force left its friction cone"
        if excess <= 1e-9
        else f"commanded forces left their cones by up to {excess:.3g} N",
        f"base climbed {summary.climb:.2f} m and leant at most {summary.tilt_max_deg:.1f} deg",
        torque_line(summary),
        f"whole-body step possible within all limits in {100 * summary.feasible_share:.2f} % of the steps",
        *motor_lines(summary),
        *estimate_lines(summary),
        *load_lines(summary),
        *([f"no fresh state came for {summary.stale:.3f} s: joints were damped"] if summary.stale else []),
        cost_line(summary),
    ]


def load_lines(summary: WalkSummary) -> list[str]:
    """Return what is said about the load that the controller found: a line, or none."""
    load = summary.load
    if load is None:
        return []
    least = FOUND * summary.mass * GRAVITY
    found = []
    if abs(load.mass) >= FOUND * summary.mass:
        at = "" if load.place is None else f" at ({load.place[0]:.3f}, {load.place[1]:.3f}) m from its origin"
        found.append(f"carries {load.mass:.2f} kg{at}")
    for values, unit, size in ((load.force, "N", least), (load.moment, "N m", LEVER * least)):
        if math.hypot(*values) >= size:
            found.append(f"is pulled by ({' '.join(f'{round(x, 1) + 0.0:.1f}' for x in values)}) {unit}")
    return [f"estimated: the base {' and '.join(found)}"] if found else []


def estimate_lines(summary: WalkSummary) -> list[str]:
    """Return what is said about the state estimate: a line, or none."""
    e = summary.estimate
    if e is None:
        return []
    share = "" if e.drift_share is None else f" ({100 * e.drift_share:.2f} % of the way)"
    return [
        f"state estimate: velocity off by {1e3 * e.velocity_rms:.1f} mm/s rms, "
        f"place by {1e3 * e.drift:.0f} mm at the end{share}, tilt by {e.tilt_rms_deg:.2f} deg rms, "
        f"heading by {e.heading_deg:+.2f} deg; {e.step_us.median:.0f} us a step"
    ]
