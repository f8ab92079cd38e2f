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
        of_q, of_v, of_joints, of_forces = robot.array_shapes
        q, v = sized_array("q", self.q, of_q), sized_array("v", self.v, of_v)
        contact, torques, forces = self.contact, self.torques, self.forces
        contact = None if contact is None else sized_flags("contact", contact, of_forces[0])
        torques = None if torques is None else sized_array("torques", torques, of_joints)
        forces = None if forces is None else sized_array("forces", forces, of_forces)
        same = q is self.q and v is self.v and contact is self.contact and torques is self.torques
        if same and forces is self.forces:  # as nearly always: a copy would take two microseconds
            return self
        return self._replace(q=q, v=v, contact=contact, torques=torques, forces=forces)
