"""Readings of a motion under one choice of conventions each, judged by their plausibility."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.libraries import import_pinocchio
from surefoot.records.motions.fields import MotionFields
from surefoot.records.motions.joint_orders import JointOrder
from surefoot.records.motions.plausibility import Plausibility, Ranges, judge, ranges_of, sample_pairs

if TYPE_CHECKING:
    from surefoot.mechanics import Robot

CLOSE = 0.05
"""Cost by which two readings of a motion are not told apart, see `Plausibility.cost`."""
EXCESS = 0.15
"""Angles beyond the ranges, summed over the joints [rad], from which an order is doubtful: executed motions
of the G1 leave the ranges of its URDF by up to 0.07, random orders by 0.3 and more.
"""
RARER = 0.1
"""What a set of joints must win by that is not the likeliest of its size."""
BODY_SCALE = 0.02
"""Distance of links from where a file has them that costs as much as a radian of tilt [m]."""

LEAST_BODIES = 3
"""Bodies whose places tell anything: the root is where it is in every reading."""


@dataclass
class Reading:
    """A motion's configurations under one choice of conventions.

    Attributes
    ----------
    quaternion, order
        Conventions: order of the quaternion's numbers, order of the joints.
    q
        (T, nq) configurations.
    seen_by
        How plausible they are.
    distance
        Median distance of links from where the file has them [m]; None where it does not say.
    """

    quaternion: str
    order: JointOrder
    q: FloatArray
    plausibility: Plausibility
    distance: float | None = None

    @property
    def cost(self) -> float:
        """How implausible the reading is, with what an unusual order must win by."""
        placed = 0.0 if self.distance is None else min(self.distance / BODY_SCALE, 10.0)
        return self.plausibility.cost + self.order.surprise + placed


class Readings:
    """Readings of one motion.

    Parameters
    ----------
    robot, fields
        The robot, and what the file has, in radians, metres and with unit quaternions.
    columns
        Columns of the file's joints that are the robot's.
    rate
        [Hz], None where it is not known yet.
    """

    def __init__(
        self, robot: Robot, fields: MotionFields, columns: tuple[int, ...], rate: float | None
    ) -> None:
        self.robot, self.fields, self.columns = robot, fields, columns
        self.ranges: Ranges = ranges_of(robot)
        self.pairs = sample_pairs(len(fields.joints), rate)

    def configurations(self, quaternion: str, order: JointOrder) -> FloatArray:
        """Return the (T, nq) configurations under some conventions, absent joints at the nominal angle."""
        robot, fields = self.robot, self.fields
        q = np.tile(robot.nominal, (len(fields.joints), 1))
        first = len(robot.nominal) - robot.joints
        place = {name: first + k for k, name in enumerate(robot.joint_names)}
        q[:, [place[name] for name in order.joints]] = fields.joints[:, list(self.columns)]
        if robot.floating:
            assert fields.place is not None
            q[:, :3], q[:, 3:7] = fields.place, self._turns(quaternion)
        return q

    def _turns(self, quaternion: str) -> FloatArray:
        """Return (T, 4) unit quaternions x, y, z, w out of numbers in some order, or their inverses."""
        assert self.fields.quaternion is not None
        turns = self.fields.quaternion
        if quaternion.removesuffix(" inverse") == "wxyz":
            turns = turns[:, [1, 2, 3, 0]]
        return turns * [-1.0, -1.0, -1.0, 1.0] if quaternion.endswith(" inverse") else turns

    def read(self, quaternion: str, order: JointOrder) -> Reading:
        """Return the reading under some conventions, judged."""
        q = self.configurations(quaternion, order)
        return Reading(quaternion, order, q, judge(self.robot, self.ranges, q, self.pairs), self._distance(q))

    def _distance(self, q: FloatArray) -> float | None:
        """Return the median distance of links from the places that the file has for them [m]."""
        bodies, robot = self.fields.bodies, self.robot
        if bodies is None:
            return None
        pinocchio = import_pinocchio()
        data = robot.model.createData()
        named = {name: k for k, name in enumerate(self.fields.body_names)}
        frames = enumerate(robot.model.frames)
        links = [(k, f) for k, f in frames if f.type.name == "BODY" and (not named or f.name in named)]
        if min(len(links), bodies.shape[1]) < LEAST_BODIES:
            return None
        apart = list[float]()
        for row in np.unique(np.linspace(0, len(q) - 1, 8).astype(int)):
            pinocchio.framesForwardKinematics(robot.model, data, q[row])
            places = np.array([data.oMf[k].translation for k, _ in links])
            if named:
                own = [named[link.name] for _, link in links]
                gaps = np.linalg.norm(bodies[row, own] - places, axis=1)
            else:  # files that name no bodies may have some of them only: each is near some link
                gaps = np.linalg.norm(bodies[row][:, None] - places, axis=2).min(axis=1)
            apart += gaps.tolist()
        return float(np.median(apart))
