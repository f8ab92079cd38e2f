"""`surefoot check`: can it stand here, with forces or a proof that there are none."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from rich.console import Console

from surefoot.app.cli import options
from surefoot.app.cli.console import say, say_verdict, show, table
from surefoot.app.cli.extras import draw_into
from surefoot.app.cli.stance_input import StanceOptions
from surefoot.base.spatial import GRAVITY

PUSHES = {
    "forward (+x)": (1, 0, 0),
    "back (-x)": (-1, 0, 0),
    "left (+y)": (0, 1, 0),
    "right (-y)": (0, -1, 0),
    "up (+z)": (0, 0, 1),
    "down (-z)": (0, 0, -1),
}


def check(
    *,
    stance: StanceOptions,
    out: options.PictureOut = Path("runs"),
    picture: options.Picture = True,
    as_json: options.AsJson = False,
) -> int:
    """Tell whether a stance can hold its robot at rest. Exit code 0 possible, 1 impossible, 2 bad input."""
    case = stance.case()
    facts, ground, motor = _facts(case)

    def draw(folder: Path) -> Path:
        from surefoot.app.viz.stance_plots import draw_check

        verdict = motor if ground.feasible and motor is not None else ground
        return draw_check(case.question, verdict, facts["verdict"], folder / "stance.png", case.robot, case.q)

    if as_json and len(case.question.stance):
        facts["com_region"] = _region(case.question)
    facts["lint"] = None
    if case.robot is not None:
        from surefoot.app.cli.lint import lint_line

        facts["lint"] = lint_line(case.robot)
    facts["picture"], facts["note"] = draw_into(picture, out, "check", draw)
    show(facts, as_json, _print)
    return 0 if facts["possible"] else 1


def _facts(case: Any) -> tuple[dict[str, Any], Any, Any]:
    """Return everything the command says, the ground's verdict and, for a robot, the motors'."""
    from surefoot.mechanics import can_stand, friction_needed

    question = case.question
    ground = can_stand(question.stance, question.com, question.mass, question.external_wrench)
    motor = None
    if case.robot is not None and len(question.stance):
        from surefoot.mechanics.statics import actuation

        motor = actuation.can_stand(case.robot, question.stance, case.q, question.external_wrench)
    needed = friction_needed(question.stance, question.com, question.mass, question.external_wrench)
    possible = ground.feasible and (motor is None or motor.feasible)
    best = motor if motor is not None and motor.feasible else ground
    facts: dict[str, Any] = {
        "name": question.name,
        "possible": possible,
        "verdict": _sentence(question, ground, motor, needed),
        "mass": question.mass,
        "com": question.com,
        "external_wrench": question.external_wrench,
        "margin": best.margin if possible else (ground if not ground.feasible else motor).margin,  # type: ignore[union-attr]
        "friction_needed": needed,
        "contacts": _contact_rows(question.stance, best if possible else None),
        "largest_push": {
            name: best.largest_disturbance([*axis, 0.0, 0.0, 0.0]) for name, axis in PUSHES.items()
        }
        if possible
        else None,
        "certificate": None if ground.feasible else ground.certificate,
        "motors": None
        if motor is None
        else {"possible": motor.feasible, "margin": motor.margin, "limiting": list(motor.limiting)},
        "picture": None,
    }
    return facts, ground, motor


def _region(question: Any) -> dict[str, Any]:
    """Return where the centre of mass may be."""
    from surefoot.mechanics.statics.com_region import com_region

    region = com_region(question.stance, question.mass, external_wrench=question.external_wrench)
    sizes = {"corners": region.inner, "area": region.area, "gap": region.gap}
    return {**sizes, "distance": region.distance(question.com)}


def _sentence(question: Any, ground: Any, motor: Any, needed: float) -> str:
    """Return the verdict in one line."""
    if not len(question.stance):
        return "impossible: nothing touches the ground"
    least = float(question.stance.mu.min())
    if ground.feasible and (motor is None or motor.feasible):
        best = ground if motor is None else motor
        edge = best.margin < 1e-6 * question.mass * GRAVITY
        margin = "without limit" if math.isinf(best.margin) else f"{best.margin:.3g} N"
        margin = "none, on the very edge" if edge else margin
        return f"possible: margin {margin}; friction needed {needed:.3f}, least friction here {least:g}"
    if "undecided" in (ground.status, "" if motor is None else motor.status):
        return "undecided: rounding leaves neither forces nor a proof that there are none"
    if not ground.feasible:
        if math.isinf(needed):
            return "impossible: no friction would be enough"
        return f"impossible: needs friction {needed:.3f} at every contact, least friction here is {least:g}"
    joints = ", ".join(name.split()[0] for name in motor.limiting[:3])
    return f"impossible for the motors, though not for the ground: short of torque at {joints}"


def _contact_rows(stance: Any, verdict: Any) -> list[dict[str, Any]]:
    """Return one row per contact: place, friction, force, share of the friction in use."""
    forces = verdict.by_contact() if verdict is not None else [None] * len(stance)
    return [
        {
            "name": contact.name,
            "position": contact.position,
            "tilt_deg": math.degrees(math.acos(max(-1.0, min(1.0, float(contact.normal[2]))))),
            "mu": contact.mu,
            "force": force,
            "world_force": None if force is None else contact.rotation_world_contact @ force[:3],
            "friction_used": None if force is None else _share(force, contact.mu),
        }
        for contact, force in zip(stance, forces, strict=True)
    ]


def _share(force: Any, mu: float) -> float:
    """Return the share of its friction that a force in contact axes uses."""
    side, limit = math.hypot(force[0], force[1]), mu * force[2]
    return side / limit if limit > 0.0 else (0.0 if side < 1e-9 else math.inf)


def _numbers(values: Any, digits: int) -> str:
    """Return numbers side by side, without negative zeros."""
    return "  ".join(f"{round(float(x), digits) + 0.0:.{digits}f}" for x in values)


def _print(console: Console, facts: dict[str, Any]) -> None:
    say_verdict(console, f"{facts['name']}: {facts['verdict']}", facts["possible"])
    say(console, facts["lint"] or "", style="red")
    rows = []
    for row in facts["contacts"]:
        force = "-" if row["force"] is None else _numbers(row["force"][:3], 2)
        world = "-" if row["world_force"] is None else _numbers(row["world_force"], 2)
        used = "-" if row["friction_used"] is None else f"{100 * row['friction_used']:.0f} %"
        place = _numbers(row["position"], 3)
        rows.append((row["name"], place, f"{row['tilt_deg']:.1f}", f"{row['mu']:g}", force, world, used))
    whole = ("position [m]", "force t, t, n [N]", "world x, y, z [N]")
    header = ("contact", whole[0], "tilt [deg]", "mu", whole[1], whole[2], "friction used")
    console.print(table(header, rows, left=7, whole=whole))
    if facts["largest_push"]:
        pushes = facts["largest_push"].items()
        sizes = [(name, "any" if math.isinf(size) else f"{size:.1f}") for name, size in pushes]
        console.print(table(("push at the centre of mass", "largest [N]"), sizes, left=2))
    if facts["certificate"] is not None:
        motion = facts["certificate"] / max(abs(x) for x in facts["certificate"])
        say(
            console,
            f"Proof: along the motion [{_numbers(motion[:3], 3)}] [{_numbers(motion[3:], 3)}] (linear, and "
            "angular about the centre of mass) gravity works, and no contact force against it. It is a "
            "proof's direction, one of many: how the robot will slide or fall is another question.",
        )
    say(console, f"picture: {facts['picture']}" if facts["picture"] else "", facts["note"])
