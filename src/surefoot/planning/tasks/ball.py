"""The task `ball`: an optimiser is to find how a ball falls, lands and rests."""

from __future__ import annotations

import numpy as np

from surefoot.planning.plan import Plan, plan_from
from surefoot.planning.tasks.softened import METHODS, search, told, within
from surefoot.planning.tasks.task import Request, Tell
from surefoot.planning.trajectory import rollout
from surefoot.planning.transcription import robots, textbook

SAME = 1e-6
"""The optimiser found the motion if it is nowhere further from the exact steps [m]."""


class Ball:
    """A ball falls and stays where it lands: nothing drives it, so only the laws can tell the motion.

    The plan is the motion of exact steps, and SOLVED where the optimiser's own is the same to 1e-6 m.
    """

    name = "ball"
    meaning = "a ball falls, lands and rests"
    amount = "height of the fall [m]"
    default: float | None = 1.0
    robots = False
    methods = METHODS

    def plan(self, request: Request, tell: Tell) -> Plan:
        """Return the plan; see `Task`."""
        height = within(request, "ball", "m", 0.0, 3.0)
        dt = request.dt or 0.02
        knots = request.knots or max(10, round((np.sqrt(2.0 * height / 9.81) + 0.5) / dt))
        found = search(textbook.falling_ball(height, knots, dt), request, tell)
        robot = robots.ball()
        q = robot.nominal.copy()
        q[2] += height
        motion = rollout(robot, q, np.zeros(6), np.zeros((knots, 0)), dt=dt, mu=request.mu)
        # the first knot's gap is the height: q counts from the ball's lowest point
        apart = float(np.abs(found[0].motion.q[:, 0] - motion.gaps[:, 0]).max())
        goal = f"rest on the ground; the optimiser's motion is {apart:.1e} m from the exact one"
        reached = found[0].outcome.solved and apart < SAME
        return plan_from(motion, robot, told(request, "ball", found, reached, goal))


TASK = Ball()
