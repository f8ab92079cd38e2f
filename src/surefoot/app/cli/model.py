"""`surefoot model`: what a robot model says about itself, in one table."""

from __future__ import annotations

from typing import Any

import numpy as np
from rich.console import Console

from surefoot.app.cli import options
from surefoot.app.cli.console import say, show, table


def model(
    robot: options.RobotName = None,
    feet: options.FootFrames = None,
    as_json: options.AsJson = False,
) -> int:
    """Print masses, joints and limits, feet, ranks of the contact Jacobian and the centroidal inertia."""
    from surefoot.app.cli.robots import load

    show(describe(load(robot, feet)), as_json, _print)
    return 0


def describe(robot: Any) -> dict[str, Any]:
    """Return the facts about a robot in its nominal pose, as plain values."""
    from surefoot.mechanics import contact_jacobian
    from surefoot.mechanics.robot.centroidal import centroidal_inertia, momentum

    q, body = robot.nominal, robot.model
    stance = robot.stance(q)
    J = contact_jacobian(robot, q, stance)
    inertia = centroidal_inertia(robot, q)[3:, 3:]
    moving = momentum(robot, q, np.zeros(body.nv))
    singular = np.linalg.svd(J, compute_uv=False) if J.size else np.zeros(0)
    rank = int((singular > 1e-9 * singular[0]).sum()) if J.size else 0
    return {
        "robot": robot.name,
        "floating_base": robot.floating,
        "mass": robot.mass,
        "nq": int(body.nq),
        "nv": int(body.nv),
        "joints": _joints(robot),
        "feet": _feet(robot, stance, J),
        "missing_meshes": robot.missing_meshes,
        "frames": [str(f.name) for f in body.frames if f.type.name == "BODY"],
        "nominal": q,
        "contact_jacobian": {
            "rows": J.shape[0],
            "columns": J.shape[1],
            "rank": rank,
            "condition": float(singular[0] / singular[rank - 1]) if rank else None,
        },
        "centroidal": {
            "com": moving.com,
            "inertia": inertia,
            "principal_moments": np.linalg.eigvalsh(inertia),
            "radii_of_gyration": np.sqrt(np.diag(inertia) / moving.mass),
        },
    }


def _joints(robot: Any) -> list[dict[str, Any]]:
    """Return every joint with the mass of its own link, and its limits."""
    body, out = robot.model, []
    for index in range(1, body.njoints):
        joint = body.joints[index]
        entry: dict[str, Any] = {
            "name": str(body.names[index]),
            "parent": str(body.names[body.parents[index]]),
            "type": joint.shortname().removeprefix("JointModel"),
            "mass": float(body.inertias[index].mass),
        }
        if joint.nv == 1:
            speed = float(body.velocityLimit[joint.idx_v])
            entry["effort"] = float(robot.effort_limits[joint.idx_v - robot.base_dof])
            entry["speed"] = speed if 0.0 < speed < 1e100 else np.inf
        if joint.nq == 1:  # a continuous joint has two coordinates and no limits
            entry["lower"] = float(body.lowerPositionLimit[joint.idx_q])
            entry["upper"] = float(body.upperPositionLimit[joint.idx_q])
        out.append(entry)
    return out


def _feet(robot: Any, stance: Any, J: Any) -> list[dict[str, Any]]:
    """Return every foot with its shape, place and what its own joints can do there."""
    return [
        {
            "name": foot.name,
            "shape": "sole" if foot.flat else "point",
            "size": list(foot.size) if foot.flat else [2.0 * foot.radius],
            "corners": foot.corners,
            "position": contact.position,
            "why": foot.why,
            "rows": contact.dim,
            "rank": int(np.linalg.matrix_rank(J[rows], tol=1e-9)),
            "rank_of_its_leg": int(np.linalg.matrix_rank(J[rows, robot.base_dof :], tol=1e-9)),
        }
        for foot, contact, rows in zip(robot.feet, stance, stance.slices, strict=True)
    ]


def _print(console: Console, facts: dict[str, Any]) -> None:
    """Print the facts as tables."""
    base = "floating base" if facts["floating_base"] else "fixed base"
    size = f"nq = {facts['nq']}, nv = {facts['nv']}, {len(facts['frames'])} bodies"
    say(console, f"{facts['robot']}: {facts['mass']:.3f} kg, {base}, {size}", style="bold")
    console.print(_joint_table(facts["joints"]))
    if facts["feet"]:
        console.print(_foot_table(facts["feet"]))
        J = facts["contact_jacobian"]
        shape = f"contact Jacobian {J['rows']} x {J['columns']}"
        say(console, f"{shape}: rank {J['rank']}, condition {J['condition']:.1f}")
        say(console, *(foot["why"] for foot in facts["feet"]))
    else:
        say(console, "no feet (name them with --feet)")
    for link, names in facts["missing_meshes"].items():
        say(console, f"{link} lacks shapes: not found: {', '.join(names)}")
    console.print(_inertia_table(facts["centroidal"]))


def _joint_table(joints: list[dict[str, Any]]) -> Any:
    rows = []
    for joint in joints:
        limits = [joint.get(key) for key in ("lower", "upper", "effort", "speed")]
        cells = ["-" if x is None or abs(x) > 1e100 else f"{x:.2f}" for x in limits]
        rows.append((joint["name"], f"{joint['mass']:.3f}", *cells))
    title = "Joints: link mass [kg], range [rad], effort [N m], speed [rad/s]"
    header = ("joint", "mass", "lower", "upper", "effort", "speed")
    return table(header, rows, title, whole=header)


def _foot_table(feet: list[dict[str, Any]]) -> Any:
    rows = []
    for foot in feet:
        size = " x ".join(f"{1e3 * s:.0f}" for s in foot["size"])
        place = (f"{round(x, 3) + 0.0:.3f}" for x in foot["position"])
        ranks = (f"{foot['rank']}/{foot['rows']}", f"{foot['rank_of_its_leg']}/{foot['rows']}")
        rows.append((foot["name"], foot["shape"], size, *place, *ranks))
    header = ("foot", "shape", "size", "x", "y", "z", "rank", "by its leg")
    return table(header, rows, "Feet in the nominal pose: size [mm], place [m]", whole=header)


def _inertia_table(centroidal: dict[str, Any]) -> Any:
    place = ", ".join(f"{x:.3f}" for x in centroidal["com"])
    title = f"Centroidal inertia [kg m²] about ({place}) m, joints locked"
    inertia = zip("xyz", centroidal["inertia"], centroidal["radii_of_gyration"], strict=True)
    rows = ((axis, *(f"{x + 0.0:.4f}" for x in row), f"{radius:.3f}") for axis, row, radius in inertia)
    return table(("", "x", "y", "z", "radius of gyration [m]"), rows, title, left=0)
