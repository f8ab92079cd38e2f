"""Where the feet are, how they turn and how well that is known, from the joints alone: body axes."""

from __future__ import annotations

from typing import Any

import numpy as np

from surefoot.arrays import BoolArray, FloatArray
from surefoot.kernels import kernel
from surefoot.numerics.points import point_velocity
from surefoot.robot import Robot

FLOOR = 1e-10
"""Least variance of a foot's place [m²]: a straight leg has no lever along itself, but is not exact either."""


@kernel
def feet_by_joints(
    twists: FloatArray, support: BoolArray, centres: FloatArray, speeds: FloatArray, variance: float,
    velocities: FloatArray, spreads: FloatArray,
) -> None:  # fmt: skip
    """Fill velocities (n, 3) and covariances (n, 3, 3) of the feet against the base.

    `twists` (6, nv) are the joints' columns with the base at the origin, `support` (n, nv) what moves each
    foot, `centres` (n, 3) where they are, `speeds` (nv - 6,) the joints'; an angle's variance gives J Jᵀ times
    it.
    """
    for k in range(centres.shape[0]):
        x, y, z = centres[k, 0], centres[k, 1], centres[k, 2]
        velocity, spread = velocities[k], spreads[k]
        for r in range(3):
            velocity[r] = 0.0
            for s in range(3):
                spread[r, s] = FLOOR if r == s else 0.0
        for j in range(6, twists.shape[1]):
            if support[k, j]:
                column = point_velocity(twists, j, x, y, z)
                for r in range(3):
                    velocity[r] += column[r] * speeds[j - 6]
                    for s in range(3):
                        spread[r, s] += variance * column[r] * column[s]


@kernel
def roll(
    rotation: FloatArray, turned: FloatArray, normals: FloatArray, radii: FloatArray, last: FloatArray,
    rolled: FloatArray,
) -> None:  # fmt: skip
    """Add to rolled (n, 3) how far the centres of round feet went by rolling since the last call, world axes.

    A sphere that turns by a small δθ without sliding moves by r δθ x n. `rotation` (3, 3) is the body's,
    `turned` (n, 3, 3) the feet's against it, `last` (n, 3, 3) the feet's in the world, which is replaced.
    """
    for k in range(radii.shape[0]):
        now = rotation @ turned[k]
        turn = now @ last[k].T
        a, b, c = (turn[2, 1] - turn[1, 2]) / 2, (turn[0, 2] - turn[2, 0]) / 2, (turn[1, 0] - turn[0, 1]) / 2
        n = normals[k]
        rolled[k, 0] += radii[k] * (b * n[2] - c * n[1])
        rolled[k, 1] += radii[k] * (c * n[0] - a * n[2])
        rolled[k, 2] += radii[k] * (a * n[1] - b * n[0])
        last[k] = now


class FootKinematics:
    """The feet of a robot as its joints have them; arrays are overwritten by the next `update`.

    Parameters
    ----------
    robot
        With a floating base and feet.
    deviation
        Standard deviation of a joint's angle [rad].

    Attributes
    ----------
    centres
        (n, 3) middles of the feet from the base's origin, base axes [m].
    rotations
        (n, 3, 3) rotation_base_foot.
    velocities
        (n, 3) of the middles against the base [m/s].
    spreads
        (n, 3, 3) covariances of the middles [m²].
    """

    def __init__(self, robot: Robot, deviation: float) -> None:
        points, n = robot.contact_points, len(robot.feet)
        self._model, self._data, self._variance = robot.model, robot.model.createData(), deviation**2
        self._q: FloatArray = np.zeros(robot.model.nq)
        self._q[6] = 1.0
        self._frames, self._middles, self._support = points.frames, points.middles, points.foot_support
        self.centres, self.velocities = np.zeros((n, 3)), np.zeros((n, 3))
        self.rotations, self.spreads = np.zeros((n, 3, 3)), np.zeros((n, 3, 3))

    def update(self, positions: FloatArray, speeds: FloatArray) -> None:
        """Move to (joints,) angles [rad] and speeds [rad/s]."""
        import pinocchio

        model: Any = self._model
        data: Any = self._data
        self._q[7:] = positions
        pinocchio.computeJointJacobians(model, data, self._q)
        for k, frame in enumerate(self._frames):
            pose = pinocchio.updateFramePlacement(model, data, frame)
            self.rotations[k], self.centres[k] = pose.rotation, pose.act(self._middles[k])
        twists = np.ascontiguousarray(data.J)
        feet_by_joints(
            twists, self._support, self.centres, speeds, self._variance, self.velocities, self.spreads
        )
