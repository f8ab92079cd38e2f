"""A joint rests on its mechanical stop, whose torque no log has."""

from __future__ import annotations

import numpy as np

from surefoot.audit.episode import Episode
from surefoot.audit.symptoms.symptom import Evidence, Symptom

AT_STOP = 0.01
"""A joint is at its stop within this [rad, m]."""


def _judge(e: Episode) -> Evidence | None:
    robot = e.rows.setting.robot
    if robot is None or not e.has("motion"):
        return None
    leg = robot.contact_points.support[e.column][robot.base_dof :]
    q = np.asarray(e.rows.log["q"])[e.rows.core, 7:]
    low, high = robot.model.lowerPositionLimit[7:], robot.model.upperPositionLimit[7:]
    if q.shape[1] != len(leg):
        return None  # joints whose configuration has more numbers than their velocity
    beyond = ((q < low + AT_STOP) | (q > high - AT_STOP)) & leg
    share = float(beyond.any(axis=1).mean())
    if share < 0.3:
        return None
    name = robot.joint_names[int(beyond.sum(axis=0).argmax())]
    return Evidence(1.0, f"{name} is at the end of its range in {100 * share:.0f} % of the rows")


SYMPTOM = Symptom(
    "joint stop",
    cause="a joint rests on its stop (the robot fell, or squats too deep), whose torque is not in the log",
    confirm="compare the joint's angle with its range",
    cure="keep away from the range's ends; log the constraint torques of the simulator",
    judge=_judge,
)
