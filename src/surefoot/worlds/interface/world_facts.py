"""What a log says about the world that it comes from: its ground, its load and its own softness.

A world may leave out both attributes that are asked for here: then the log says that much less.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from surefoot.mechanics import Actuators
from surefoot.worlds.interface.world import World, kind_of


def facts_before(world: World) -> dict[str, Any]:
    """Return what is known of a world before the run: robot, terrain, mass, payload, motors, substeps."""
    robot, payload = world.robot, float(getattr(world, "payload", 0.0))
    out: dict[str, Any] = {
        "robot": robot.name, "world": kind_of(world), "dt": world.dt,
        "feet": list(robot.foot_names), "joints": list(robot.joint_names),
        "contact_foot": world.contact_foot,
        "contact_centres": np.vstack([foot.centres for foot in robot.feet]),
        "mass": robot.mass + payload, "payload": payload, "speed_limits": robot.speed_limits,
    }  # fmt: skip
    actuators: Actuators | None = getattr(world, "actuators", None)
    if actuators is not None:
        limits = actuators.limits
        out |= {"actuators": actuators.name, "speed_limits": limits.speed, "effort_limits": limits.effort}
        out |= {"motor_knee": limits.knee, "motor_driving": limits.driving, "armature": actuators.armature}
        out |= {"viscous_friction": actuators.damping, "dry_friction": actuators.friction}
    if payload > 0.0:
        out["payload_position"] = np.array(getattr(world, "payload_position", np.zeros(3)))
    parts = int(getattr(world, "substeps", 1))
    if parts > 1:  # of the engine, in each row
        out["substeps"] = parts
    if world.terrain.text:
        out["terrain"] = world.terrain.text
    return out
