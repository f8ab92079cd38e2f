"""Backflip: a full turn backwards in the air."""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.motion.planning.plan import Plan
from surefoot.motion.planning.tasks.jump import at_rest
from surefoot.motion.planning.tasks.scheduled import PATIENCE, mover, scheduled_plan
from surefoot.motion.planning.tasks.task import PlanRequest, Tell
from surefoot.motion.planning.trajectory import Trajectory

OFF = math.radians(8.0)
"""How far the whole turn may be from a full one [rad]."""


class Backflip:
    """A full turn backwards, from standing to standing."""

    name, amount, robots = "backflip", "", True
    default: float | None = None
    takes: tuple[str, ...] = ("start", "payload", "near")

    def plan(self, request: PlanRequest, tell: Tell) -> Plan:
        """Return the plan of a backflip, see `Task.plan`."""
        from surefoot.motion.planning.schedule.motions import backflip

        robot = mover(request)
        problem = backflip(robot, request.mu, request.dt, request.start)

        def goal(motion: Trajectory) -> tuple[bool, str]:
            angle = pitch_of_motion(motion.q)
            still, said = at_rest(motion, problem.q)
            whole = abs(angle + 2.0 * math.pi) <= OFF
            return bool(whole and still), f"turns by {math.degrees(angle):.0f} deg, {said}"

        return scheduled_plan(self.name, problem, request, tell, goal, 2.0 * PATIENCE)


def pitch_of_motion(q: FloatArray) -> float:
    """Return the angle by which (T, nq) configurations turn about the base's y axis, turns added up [rad]."""
    angle = np.unwrap(2.0 * np.arctan2(q[:, 4], q[:, 6]), period=2.0 * math.pi)
    return float(angle[-1] - angle[0])


BACKFLIP = Backflip()
