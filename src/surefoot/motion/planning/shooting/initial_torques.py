"""Torques to start a search from."""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.mechanics import Robot, StepOptions, Stepper, Terrain

TOUCHING = 0.01
"""A foot counts as on the ground below this gap [m]."""


def holding_torques(robot: Robot, q: FloatArray, terrain: Terrain | None = None) -> FloatArray:
    """Return the torques (m,) [N m] that hold a robot at q (nq,) with the least forces at its touching feet.

    The forces at the contact points balance the base as well as they can, whatever friction allows: a place
    to start from, not an answer. A robot in the air gets the torques of its joints' own weight.
    """
    import pinocchio

    stepper = Stepper(robot, terrain, StepOptions(order=1))
    state = stepper.start(q)
    model = robot.model
    weight = np.array(pinocchio.computeGeneralizedGravity(model, model.createData(), state.q))
    base, seen = robot.base_dof, stepper.contacts(state)
    near = np.flatnonzero(seen.gaps < TOUCHING)
    if base and near.size:
        J = np.asarray(seen.J).reshape(-1, 3, model.nv)[near].reshape(-1, model.nv)
        forces = np.linalg.lstsq(J[:, :base].T, weight[:base], rcond=None)[0]
        weight = weight - J.T @ forces
    return np.asarray(np.clip(weight[base:], -robot.effort_limits, robot.effort_limits))
