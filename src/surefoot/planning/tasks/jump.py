"""Jump: the feet leave the ground together and land further on, or where they were."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from surefoot.arrays import FloatArray, real_number
from surefoot.errors import ProblemError
from surefoot.planning.plan import Plan
from surefoot.planning.tasks.scheduled import DIRECT, ROAD, direct_plan, scheduled_plan
from surefoot.planning.tasks.task import PlanRequest, Tell
from surefoot.planning.trajectory import Trajectory
from surefoot.robot import Robot, load_robot
from surefoot.spatial import rotation_from_quaternion

if TYPE_CHECKING:
    from surefoot.planning.direct.problem import DirectProblem

MORE = 0.03
"""What is planned beyond what is asked for [m]: an execution loses a little."""
SHORT = 0.01
"""How much less than asked for still is a jump of that length or height [m]."""
KNOT, LASTS, HOP = 0.03, 0.6, 0.1
"""On the direct road: length of a knot and of the motion [s], and how far a jump forward rises [m]."""
LEAN, SLOW = math.radians(6.0), 0.15
"""Largest tilt [rad] and speed [m/s, rad/s] at the end."""


class Jump:
    """A jump forward: the number is how far the feet get."""

    name, meaning = "jump", "all feet leave the ground and land further ahead"
    amount, default, robots = "distance [m]", 0.4, True
    roads: tuple[str, ...] = (ROAD, DIRECT)
    up = False

    def plan(self, request: PlanRequest, tell: Tell) -> Plan:
        """Return the plan of a jump, see `Task.plan`."""
        from surefoot.planning.schedule.motions import jump, time_scale

        robot = request.robot or load_robot("go2")
        asked = self.default if request.amount is None else request.amount
        reach = 3.0 * float(robot.nominal[2])
        real_number(self.amount, asked, low=0.0 if self.up else -reach, high=reach)
        if self.up and asked < 0.02:
            raise ProblemError(f"height [m] must be at least 0.02, got {asked:g}")
        more = MORE * time_scale(robot) ** 2
        forward = 0.0 if self.up else asked + math.copysign(more, asked)
        rise = asked + more if self.up else 0.0
        feet = len(robot.contact_points)

        def goal(motion: Trajectory) -> tuple[bool, str]:
            got = _risen(motion) if self.up else _moved(motion)
            still, said = at_rest(motion)
            flown = bool((motion.impulses[:, :feet, 2] <= 0.0).all(axis=1).any())
            enough = got >= asked - SHORT if self.up or asked >= 0.0 else got <= asked + SHORT
            words = f"{'rises by' if self.up else 'the feet get'} {got:.3f} m of {asked:g} asked for, {said}"
            return bool(enough and still and flown), words

        if request.road == DIRECT:
            return direct_plan(self.name, _any_contacts(robot, forward, rise, request), request, tell, goal)
        problem = jump(robot, forward, rise, request.mu, request.dt)
        return scheduled_plan(self.name, problem, request, tell, goal)


class JumpUp(Jump):
    """A jump in place: the number is how high the base rises above where it stood."""

    name, meaning = "jump-up", "all feet leave the ground and land where they were"
    amount, default = "height [m]", 0.15
    up = True


def _any_contacts(robot: Robot, forward: float, rise: float, request: PlanRequest) -> DirectProblem:
    """Return the jump as a problem of the direct method: only its height says that it flies."""
    from surefoot.planning.direct.motions import rest_to_rest
    from surefoot.planning.schedule.motions import time_scale

    scale = time_scale(robot)
    dt = KNOT * scale if request.dt is None else request.dt
    knots = request.knots or round(LASTS * scale / dt)
    return rest_to_rest(robot, forward, rise or HOP * scale**2, knots=knots, dt=dt, mu=request.mu)


def _moved(motion: Trajectory) -> float:
    """Return how far the middle of the feet got [m]."""
    return float((motion.positions[-1] - motion.positions[0])[:, 0].mean())


def _risen(motion: Trajectory) -> float:
    """Return how far the base rose above its first height [m]."""
    return float(motion.q[:, 2].max() - motion.q[0, 2])


def lean(q: FloatArray) -> float:
    """Return the tilt of the base in (nq,) q [rad]."""
    return math.acos(float(np.clip(rotation_from_quaternion(q[3:7])[2, 2], -1.0, 1.0)))


def at_rest(motion: Trajectory) -> tuple[bool, str]:
    """Return whether a motion ends upright, slow and on all feet, and how it ends, in words."""
    tilt, speed = lean(motion.q[-1]), float(np.abs(motion.v[-1, :6]).max())
    down = bool((motion.impulses[-1, :, 2] > 0.0).all())
    feet = "on all feet" if down else "not on all feet"
    said = f"ends leaning {math.degrees(tilt):.1f} deg at {speed:.2f} m/s, {feet}"
    return tilt <= LEAN and speed <= SLOW and down, said


JUMP, JUMP_UP = Jump(), JumpUp()
