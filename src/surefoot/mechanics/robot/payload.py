"""What a robot carries on its base: the same load in every world, in estimates and in audits."""

from __future__ import annotations

from copy import copy
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import finite_array
from surefoot.mechanics.robot.robot import Robot

SPREAD = 1e-3
"""Inertia of a load over its mass [m²], that of a ball of 5 cm radius: no body is a point."""


def loaded_model(model: Any, payload: float, position: ArrayLike = (0.0, 0.0, 0.0)) -> Any:
    """Return a copy of Pinocchio's model with a payload [kg] on its base, at (3,) base axes [m].

    Raises
    ------
    ProblemError
        For a position that is not three finite numbers.
    """
    import pinocchio

    model, place = model.copy(), finite_array("payload_position", position, (3,))
    if payload > 0.0:
        load = pinocchio.Inertia(payload, place, SPREAD * payload * np.eye(3))
        model.inertias[1] = model.inertias[1] + load
    return model


def loaded_robot(robot: Robot, payload: float) -> Robot:
    """Return a robot that carries a payload [kg] on its base; the robot itself for none."""
    if not payload:
        return robot
    out = copy(robot)
    out.__dict__.pop("mass", None)  # a cached sum
    out.model = loaded_model(robot.model, payload if robot.floating else 0.0)
    out.data = out.model.createData()
    return out
