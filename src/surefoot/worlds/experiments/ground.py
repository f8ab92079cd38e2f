"""The same ground in every world's own words: as hard as a step allows, or softened by one law."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.spatial import GRAVITY
from surefoot.contact import SpringDamper, translate

HARD = ("rigid", "mujoco-exact")
"""Worlds whose contacts are no springs: they bounce by Newton's coefficient."""
STEPS_OF_MUJOCO = 4.0
"""MuJoCo's time constant in steps: twice the shortest that it takes."""
NEAR_RIGID = (0.97, 0.99, 0.001, 0.5, 2.0)
"""MuJoCo's impedance of hard ground; bodies here do not turn fast over it."""
IMPEDANCE = 1e-4
"""The smallest that MuJoCo takes: the contact is then the spring and damper that is meant."""


def hard(world: str, dt: float) -> dict[str, Any]:
    """Return a world's options for ground that gets rigid as the step [s] gets short.

    The rigid world is rigid, Drake's own default follows its step, and MuJoCo is given a time constant that
    does.
    """
    if world != "mujoco":
        return {}
    return {"solref": (STEPS_OF_MUJOCO * dt, 1.0), "solimp": NEAR_RIGID}


def bouncing(world: str, restitution: float, mass: float, stiffness: float, dt: float) -> dict[str, Any]:
    """Return a world's options for bounces: Newton's coefficient, or a spring-damper of that restitution."""
    if world in HARD:
        return {"restitution": restitution}
    law = SpringDamper.bouncing(stiffness, restitution, mass)
    if world != "mujoco":
        return {"contact": translate(law, world, mass, dt=dt).parameters}
    return translate(law, "mujoco", mass, dt=dt, impedance=IMPEDANCE).parameters


def slid_down(time: FloatArray, degrees: float, mu: float) -> FloatArray:
    """Return how far a body slides down a slope [deg] in times (n,) [s], from rest: (n,) [m]."""
    theta = math.radians(degrees)
    return np.asarray(0.5 * GRAVITY * (math.sin(theta) - mu * math.cos(theta)) * time**2)
