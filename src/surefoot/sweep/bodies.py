"""What a sample changes about a body and the ground below it."""

from __future__ import annotations

import copy

import numpy as np

from surefoot.contact.laws.soft import ExactFriction, SpringDamper
from surefoot.robot import Robot
from surefoot.sweep.space import Sample
from surefoot.terrain import FlatTerrain, SlopeTerrain, Terrain, read_terrain, rough_ground

GROUNDS = ("slope", "roughness", "terrain")
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
