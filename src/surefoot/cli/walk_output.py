"""What `surefoot walk` says: the verdict and the tables."""

from __future__ import annotations

import math

from surefoot.audit import WalkSummary
from surefoot.cli.console import Cell, Table
from surefoot.cli.run_output import OUTCOMES, cost_line, error_and_laws, motor_lines, torque_line
from surefoot.spatial import GRAVITY

WALK_OUTCOMES = OUTCOMES | {"walked": "walked", "did not follow": "did not follow its command: it moved"}
FOUND, LEVER = 0.01, 0.1
"""Share of the robot's mass or weight that counts as a load found, and arm of its moment [m]."""
AXES = (("forward", "m/s"), ("left", "m/s"), ("turn", "rad/s"))


def headline(summary: WalkSummary) -> str:
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


def tables(summary: WalkSummary) -> list[Table]:
    """Return the tables of velocities and of feet."""
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
        "share of m g": lambda foot: f"{100 * foot.weight_share:.1f} %",
        "highest cone use": lambda foot: f"{100 * foot.cone_use_max:.0f} %",
        "slip [mm]": lambda foot: f"{1e3 * foot.slip:.2f}",
    }
    return [Table.of("Velocity", AXES, velocity), Table.of("Feet", summary.feet, feet)]


def figure_lines(summary: WalkSummary) -> list[str]:
    """Return further figures, one line each."""
    excess = summary.commanded_cone_excess
    return [
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
