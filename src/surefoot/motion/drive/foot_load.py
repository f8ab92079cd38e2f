"""Whether the feet of a robot that holds a posture carry it, by what its motors give."""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.memory import Remembering
from surefoot.base.spatial import GRAVITY, skew
from surefoot.mechanics import Robot
from surefoot.motion.drive.readings import RobotReadings

NOTHING = 0.15
"""Share of the weight below which feet carry nothing [-]: dry friction of the motors is taken for 0.05 of a
Go2's, while a robot that stands carries 1, and 0.3 with most of its weight in a gantry."""
LITTLE = 0.5
"""Share of the weight below which the feet of a robot that moves may carry nothing [-]."""
STEADY = 0.2
"""Time after which a robot that takes a posture has it [s]."""
HANGS = "the feet carry nothing: the robot hangs, or lies on something; let it down to its feet"
MAYBE_HANGS = "; if it hangs, the feet carry nothing: keep its trunk level, and let it down to balance"
"""What is said where a robot is not carried by its feet, and where it may not be."""


def load_share(robot: Robot, readings: RobotReadings) -> float:
    """Return the share of its weight that the feet of a robot at rest carry [-]; nan without torques.

    The forces F of the feet are those that explain the torques best: g(q) - tau = J^T F, in the joints' rows.

    Parameters
    ----------
    robot
        With a floating base and feet.
    readings
        Joints in the robot's order; torques that are all 0 are taken for none that are measured.
    """
    import pinocchio

    if not np.any(readings.torques):
        return math.nan
    model, data = robot.model, robot.model.createData()
    quaternion = readings.quaternion / np.linalg.norm(readings.quaternion)
    q = np.concatenate([np.zeros(3), quaternion, readings.positions])
    weight = np.array(pinocchio.computeGeneralizedGravity(model, data, q))
    pinocchio.computeJointJacobians(model, data, q)
    pinocchio.updateFramePlacements(model, data)
    rows = []
    for foot in robot.feet:
        jacobian = pinocchio.getFrameJacobian(model, data, foot.frame, pinocchio.LOCAL_WORLD_ALIGNED)
        arm = data.oMf[foot.frame].rotation @ foot.centre
        rows.append((jacobian[:3] - skew(arm) @ jacobian[3:])[:, robot.base_dof :])
    left = weight[robot.base_dof :] - readings.torques
    forces = np.linalg.lstsq(np.vstack(rows).T, left, rcond=None)[0]
    return float(forces[2::3].sum() / (robot.mass * GRAVITY))


def hint(robot: Robot, readings: RobotReadings | None) -> str:
    """Return what to say of a robot that lost its balance if its feet may carry next to nothing, else ""."""
    return "" if readings is not None and load_share(robot, readings) > LITTLE else MAYBE_HANGS


class FootLoad(Remembering):
    """What feet carry on average while a posture is held: a moment of one that swings or shakes says little.

    Parameters
    ----------
    robot
        With a floating base and feet.
    """

    MEMORY = ("_sum", "_count")

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self.reset()

    def reset(self) -> None:
        """Begin anew."""
        self._sum, self._count = 0.0, 0

    def look(self, held: float, readings: RobotReadings | None) -> None:
        """See readings, None for none, of a robot that has held its posture for a time [s]."""
        if held < STEADY:
            self.reset()
            return
        share = math.nan if readings is None else load_share(self.robot, readings)
        if math.isfinite(share):  # without torques it says nothing
            self._sum, self._count = self._sum + share, self._count + 1

    @property
    def nothing(self) -> bool:
        """Whether the feet carry nothing; not where nothing was read, or no torques."""
        return self._count > 0 and self._sum / self._count < NOTHING
