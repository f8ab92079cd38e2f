"""The same ground in every world's own words: as hard as a step allows, or softened by one law."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.contact.engines import translate
from surefoot.contact.laws.soft import SpringDamper
from surefoot.contact.laws.soft.law import SoftLaw
from surefoot.spatial import GRAVITY

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
    if world not in ("mujoco", "mjx"):
        return {}
    return {"solref": (STEPS_OF_MUJOCO * dt, 1.0), "solimp": NEAR_RIGID}


def soft(world: str, law: SoftLaw, mass: float, dt: float) -> dict[str, Any]:
    """Return a world's options for a contact of a law, on which one mass [kg] lies."""
    return _SOFT[world](law, mass, dt)


def bouncing(world: str, restitution: float, mass: float, stiffness: float, dt: float) -> dict[str, Any]:
    """Return a world's options for bounces: Newton's coefficient, or a spring-damper of that restitution."""
    if world == "rigid":
        return {"restitution": restitution}
    return soft(world, SpringDamper.bouncing(stiffness, restitution, mass), mass, dt)


def _rigid(law: SoftLaw, mass: float, dt: float) -> dict[str, Any]:
    return {"law": law}


def _mujoco(law: SoftLaw, mass: float, dt: float) -> dict[str, Any]:
    words = translate(law, "mujoco", mass, dt=dt, impedance=IMPEDANCE).parameters
    return {"solref": tuple(words["solref"]), "solimp": tuple(words["solimp"])}


def _bullet(law: SoftLaw, mass: float, dt: float) -> dict[str, Any]:
    return {"contact": translate(law, "bullet", mass, dt=dt).parameters}


def _drake(law: SoftLaw, mass: float, dt: float) -> dict[str, Any]:
    return {"contact": translate(law, "drake", mass, dt=dt).parameters}


_SOFT: dict[str, Callable[[SoftLaw, float, float], dict[str, Any]]] = {
    "rigid": _rigid, "mujoco": _mujoco, "mjx": _mujoco, "bullet": _bullet, "drake": _drake,
}  # fmt: skip


def slid_down(time: FloatArray, degrees: float, mu: float) -> FloatArray:
    """Return how far a body slides down a slope [deg] in times (n,) [s], from rest: (n,) [m]."""
    theta = math.radians(degrees)
    return np.asarray(0.5 * GRAVITY * (math.sin(theta) - mu * math.cos(theta)) * time**2)
