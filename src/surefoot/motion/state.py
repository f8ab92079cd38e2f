"""What is known of a robot at one step: its state, sensed or estimated, and what a range sensor has seen."""

from __future__ import annotations

from typing import NamedTuple

from surefoot.base.arrays import BoolArray, FloatArray, sized_array, sized_flags
from surefoot.mechanics import Robot


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
        feet, joints, model = len(robot.feet), (robot.joints,), robot.model
        return self._replace(
            q=sized_array("q", self.q, (model.nq,)),
            v=sized_array("v", self.v, (model.nv,)),
            contact=None if self.contact is None else sized_flags("contact", self.contact, feet),
            torques=None if self.torques is None else sized_array("torques", self.torques, joints),
            forces=None if self.forces is None else sized_array("forces", self.forces, (feet, 3)),
        )
