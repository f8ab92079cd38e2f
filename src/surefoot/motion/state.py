"""What is known of a robot at one step: its state, sensed or estimated, and what a range sensor has seen."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, sized_array, sized_flags
from surefoot.mechanics import Robot

_ARRAY, _FLOAT, _BOOL = np.ndarray, np.dtype(np.float64), np.dtype(np.bool_)


class HeightScan(NamedTuple):
    """What a range sensor saw of the ground.

    Attributes
    ----------
    time
        When it looked [s].
    points
        (k, 3) in base axes at that time, from the base's origin [m].
    variances
        (k,) of their heights [m²].
    origin
        (3,) where its rays begin, likewise; None where that is not known [m].
    """

    time: float
    points: FloatArray
    variances: FloatArray
    origin: FloatArray | None = None


class RobotState(NamedTuple):
    """What a controller knows at one step.

    Attributes
    ----------
    q, v
        (nq,), (nv,) configuration [m, -, rad] and velocity [m/s, rad/s], Pinocchio's order.
    time
        Since the run began [s].
    contact
        (n,) which feet touch the ground; None where nothing measures that.
    torques
        (joints,) that the motors say they gave in the step before [N m]; None where they say nothing.
    forces
        (n, 3) on the feet, world axes [N], as measured or estimated; None where nothing tells them.
    scan
        What a range sensor has seen, at the steps at which it tells; else None.
    """

    q: FloatArray
    v: FloatArray
    time: float = 0.0
    contact: BoolArray | None = None
    torques: FloatArray | None = None
    forces: FloatArray | None = None
    scan: HeightScan | None = None

    def fitting(self, robot: Robot) -> RobotState:
        """Return the state with arrays of a robot's sizes; NaN is let through.

        Raises
        ------
        ProblemError
            For what is no array of its shape.
        """
        q, v, _, contact, torques, forces, _ = self
        of_q, of_v, of_contact, of_joints, of_forces = robot.array_shapes
        # nearly every state, in one expression: a call for each array would be a twentieth of a walk's step
        if (
            type(q) is type(v) is _ARRAY
            and (q.dtype == v.dtype == _FLOAT and q.shape == of_q and v.shape == of_v)
            and (contact is None or (type(contact) is _ARRAY and contact.dtype == _BOOL))
            and (contact is None or contact.shape == of_contact)
            and (torques is None or (type(torques) is _ARRAY and torques.dtype == _FLOAT))
            and (torques is None or torques.shape == of_joints)
            and (forces is None or (type(forces) is _ARRAY and forces.dtype == _FLOAT))
            and (forces is None or forces.shape == of_forces)
        ):
            return self
        return self._replace(
            q=sized_array("q", q, of_q),
            v=sized_array("v", v, of_v),
            contact=None if contact is None else sized_flags("contact", contact, *of_contact),
            torques=None if torques is None else sized_array("torques", torques, of_joints),
            forces=None if forces is None else sized_array("forces", forces, of_forces),
        )
