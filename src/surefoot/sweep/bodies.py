"""What a sample changes about a body and the ground below it."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np

from surefoot.contact.laws.soft import ExactFriction, SpringDamper
from surefoot.errors import ProblemError
from surefoot.robot import Robot
from surefoot.sweep.space import Sample, Space
from surefoot.terrain import FlatTerrain, SlopeTerrain, Terrain, read_terrain, rough_ground

GROUNDS = ("slope", "roughness", "terrain")
OWN = {
    "rigid": ("restitution", "stiffness", "damping"),
    "mujoco": ("time_constant", "damping_ratio"),
}
"""World to the parameters of the ground that only it has."""
SOFT_DEFAULTS = (0.004, 1.0)
"""Time constant [s] and damping ratio of MuJoCo's ground where one of the two is drawn."""
BODY = ("mass", "inertia", "com_x", "com_y", "com_z")


def altered(robot: Robot, sample: Sample) -> Robot:
    """Return the robot with a sample's mass, inertia and centre of mass; geometry and limits stay.

    Masses are scaled by `mass`; inertias about the links' own centres by `mass` times `inertia`; the base's
    centre of mass moves by (com_x, com_y, com_z), in its own axes.
    """
    mass, inertia = sample.number("mass", 1.0), sample.number("inertia", 1.0)
    shift = np.array([sample.number(f"com_{axis}", 0.0) for axis in "xyz"])
    if mass == 1.0 and inertia == 1.0 and not shift.any():
        return robot
    model = robot.model.copy()
    for k in range(1, model.njoints):
        own = model.inertias[k]
        lever = own.lever + shift if k == 1 else own.lever
        model.inertias[k] = type(own)(mass * own.mass, lever, mass * inertia * own.inertia)
    out = copy.copy(robot)
    out.__dict__.pop("mass", None)  # a cached sum
    out.model, out.data = model, model.createData()
    return out


def ground(sample: Sample) -> Terrain:
    """Return a sample's terrain; flat if it has none."""
    values = sample.values
    if "terrain" in values:
        return read_terrain(str(values["terrain"]))
    if "slope" in values:
        return SlopeTerrain(sample.number("slope", 0.0))
    if "roughness" in values:
        return rough_ground(sample.seed, sample.number("roughness", 0.0))
    return FlatTerrain()


def soft_law(sample: Sample) -> SpringDamper | None:
    """Return a sample's soft ground, None for a rigid one."""
    if "stiffness" not in sample.values:
        return None
    friction = ExactFriction(sample.number("mu", 0.6))
    return SpringDamper(sample.number("stiffness", 0.0), sample.number("damping", 0.0), friction=friction)


def ground_options(world: str, sample: Sample) -> dict[str, Any]:
    """Return a world's options for a sample's ground; none where the sample leaves the world its own."""
    names = ("time_constant", "damping_ratio")
    if world == "rigid":
        return {"law": soft_law(sample), "restitution": sample.number("restitution", 0.0)}
    if not set(names) & set(sample.values):
        return {}
    return {"solref": tuple(sample.number(n, d) for n, d in zip(names, SOFT_DEFAULTS, strict=True))}


def check_ground(world: str, space: Space) -> None:
    """Refuse parameters of the ground that a world does not have.

    Raises
    ------
    ProblemError
        Naming the parameter and whose it is.
    """
    for owner, own in OWN.items():
        for name in own:
            if name in space.names and owner != world:
                raise ProblemError(f"{name} is of world {owner}, the settings say world {world}")
