"""Where the joints of a log's robot are, for pictures: frames, and lines from joint to joint to the feet."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.errors import SurefootError
from surefoot.log.log import Log
from surefoot.robot import Robot, load_robot
from surefoot.spatial import quaternion_from_rotation


@dataclass(frozen=True)
class Skeleton:
    """The joints of a robot.

    Attributes
    ----------
    robot
        Whose they are.
    names
        Of the joints.
    """

    robot: Robot
    names: tuple[str, ...]

    def poses(self, q: FloatArray) -> FloatArray:
        """Return position and quaternion x, y, z, w of every joint's frame at a (nq,) q: (k, 7)."""
        data = self._placed(q)
        out = np.empty((len(self.names), 7))
        for k, pose in enumerate(list(data.oMi)[1:]):
            out[k, :3], out[k, 3:] = pose.translation, quaternion_from_rotation(pose.rotation)
        return out

    def segments(self, q: FloatArray) -> FloatArray:
        """Return the lines from each joint to the next, and to the feet, at a (nq,) q: (m, 2, 3) [m]."""
        data, model = self._placed(q), self.robot.model
        places = np.array([pose.translation for pose in data.oMi])
        lines = [(places[int(model.parents[k])], places[k]) for k in range(2, model.njoints)]
        points = self.robot.contact_points
        for joint, place in zip(points.joints, points.places, strict=True):
            lines.append((places[int(joint)], data.oMi[int(joint)].act(place)))
        return np.array(lines).reshape(-1, 2, 3)

    def _placed(self, q: FloatArray) -> Any:
        import pinocchio

        data = self.robot.data
        pinocchio.forwardKinematics(self.robot.model, data, np.asarray(q, dtype=np.float64))
        return data


def robot_of(log: Log) -> Robot | None:
    """Return the robot that a log names; None where it names none that is known and fits."""
    if "q" not in log or "robot" not in log.facts:
        return None
    try:
        robot = load_robot(str(log.fact("robot")))
    except SurefootError:
        return None
    return robot if log["q"].shape[1] == int(robot.model.nq) else None


def skeleton_of(log: Log) -> Skeleton | None:
    """Return the skeleton of the robot that a log names; None as for `robot_of`, and without a free base."""
    robot = robot_of(log)
    if robot is None or not robot.floating:
        return None
    return Skeleton(robot, tuple(map(str, list(robot.model.names)[1:])))
