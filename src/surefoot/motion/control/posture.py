"""The joints outside the legs: they hold their pose, and a biped's arms swing against its legs."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.memory import Remembering
from surefoot.mechanics import Robot, chain

ALONG = 0.8
"""A joint swings an arm ahead if its axis is the lateral one by this much (cosine)."""
ASIDE = 0.3
"""What hangs on it lies beside the body by more than this share of the feet's distance from the middle."""


class Posture(Remembering):
    """Wanted accelerations of the joints outside the legs.

    An arm swings by the first of its joints that turns it ahead, in proportion to how far the foot of its own
    side is behind the other one: the moment of the legs about the vertical is taken up by the arms.

    Parameters
    ----------
    robot
        With a left and a right foot where arms swing.
    frequency
        Natural frequency of the joints' feedback [rad/s].
    swing
        Angle of the arms over the distance of the feet along the heading [rad/m].

    Attributes
    ----------
    free
        (joints,) which joints are outside the legs.
    swing
        (joints,) angle of each joint over how far the left foot is ahead of the right one [rad/m].
    """

    MEMORY = ("_rest",)

    def __init__(self, robot: Robot, frequency: float, swing: float) -> None:
        self._rest = robot.nominal[7:].copy()
        support = robot.contact_points.foot_support
        self.free: BoolArray = np.logical_not(support.any(axis=0))[6:]
        self._stiffness = np.where(self.free, frequency**2, 0.0)
        self._damping = np.where(self.free, 2.0 * frequency, 0.0)
        self.swing = np.zeros(robot.joints)
        if swing != 0.0:
            for joint, sense in _shoulders(robot, self.free).items():
                self.swing[joint] = sense * swing

    def hold(self, q: FloatArray) -> None:
        """Hold the pose of an (nq,) configuration, in place of the nominal one."""
        self._rest = q[7:].copy()

    def accelerations(
        self, q: FloatArray, v: FloatArray, lead: float = 0.0, lead_rate: float = 0.0
    ) -> FloatArray:
        """Return wanted joint accelerations (joints,) [rad/s²].

        Parameters
        ----------
        q, v
            (nq,), (nv,) the state, Pinocchio's order.
        lead, lead_rate
            How far the left foot is ahead of the right one [m], and how fast that changes [m/s].
        """
        miss = self._rest + self.swing * lead - q[7:]
        return np.asarray(self._stiffness * miss + self._damping * (self.swing * lead_rate - v[6:]))


def _shoulders(robot: Robot, free: BoolArray) -> dict[int, float]:
    """Return the joints that swing arms, and the sense that moves the left arm back, the right one ahead.

    A turn about the axis to the left moves what hangs down backwards.
    """
    import pinocchio

    model, data = robot.model, robot.model.createData()
    q = robot.nominal
    pinocchio.computeJointJacobians(model, data, q)
    pinocchio.centerOfMass(model, data, q, True)
    base = data.oMi[1]
    aside = ASIDE * float(np.abs(robot.foot_positions(q)[:, 1] - base.translation[1]).mean())
    out: dict[int, float] = {}
    swinging: set[int] = set()
    for index in range(2, model.njoints):
        parent, joint = int(model.parents[index]), model.joints[index]
        if parent in swinging:
            swinging.add(index)
            continue
        if joint.nv != 1 or not free[joint.idx_v - 6]:
            continue
        axis = base.rotation.T @ data.J[3:, joint.idx_v]
        hanging = data.oMi[index].act(data.com[index]) - base.translation
        left = float((base.rotation.T @ hanging)[1])
        if abs(axis[1]) > ALONG and abs(left) > aside:
            out[joint.idx_v - 6] = float(np.sign(axis[1]) * np.sign(left))
            swinging.add(index)
    return out


def stretching(robot: Robot, share: float) -> float:
    """Return how far a robot has to rise from its nominal pose [m] to have legs as long as `share` of all.

    A leg reaches from its second joint, at the hip, to the last one, at the ankle.
    """
    import pinocchio

    model, data = robot.model, robot.model.createData()
    pinocchio.forwardKinematics(model, data, robot.nominal)
    out = 0.0
    for foot in robot.feet:
        places = [data.oMi[joint].translation for joint in chain(model, foot.frame)[1:]]
        length = float(sum(np.linalg.norm(b - a) for a, b in pairwise(places)))
        out = max(out, share * length - float(places[0][2] - places[-1][2]))
    return out


def leg_share(robot: Robot) -> float:
    """Return the share of a robot's mass that its legs have."""
    legs = {joint for foot in robot.feet for joint in chain(robot.model, foot.frame)}
    return float(sum(robot.model.inertias[joint].mass for joint in legs)) / robot.mass
