"""The task `hopper`: a one-legged planar robot stands up to a distance further on."""

from __future__ import annotations

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.planning.plan import Plan, plan_from
from surefoot.planning.tasks.softened import METHODS, search, told, within
from surefoot.planning.tasks.task import Request, Tell
from surefoot.planning.trajectory import Policy, rollout
from surefoot.planning.transcription import robots, textbook
from surefoot.planning.transcription.problem import Motion

NEAR = 1e-3
"""How far the end may be from the goal [m, rad, m/s, rad/s]."""
GAINS = np.array([[25.0, 1.2], [150.0, 5.0]])
"""What holds hip and leg to the optimiser's motion: per rad and rad/s [N m], per m and m/s [N]."""


class Hopper:
    """From standing to standing, further on; when the foot leaves the ground is the optimiser's affair.

    Balancing on a point is unstable: torques found to 1e-9 lead astray by a millimetre within a second. So
    the exact steps are taken with gains that hold the joints to the optimiser's motion, and the torques that
    these give are the plan's.
    """

    name = "hopper"
    meaning = "a one-legged planar hopper stands further on"
    amount = "distance [m]"
    default: float | None = 0.3
    robots = False
    methods = METHODS

    def plan(self, request: Request, tell: Tell) -> Plan:
        """Return the plan; see `Task`."""
        distance = within(request, "hopper", "m", -1.0, 1.0)
        problem = textbook.hopper(distance, request.mu, request.knots or 30, request.dt or 0.03)
        found = search(problem, request, tell)
        robot, wanted = robots.hopper(), found[0].motion
        motion = rollout(
            robot, problem.q, problem.v, follower(wanted), dt=problem.dt, mu=request.mu, steps=problem.knots
        )
        end = np.array([distance, textbook.LEG, 0.0, textbook.LEG])
        missed = float(np.abs(np.concatenate([motion.q[-1] - end, motion.v[-1]])).max())
        apart = float(np.abs(motion.q - wanted.q).max())
        goal = (
            f"at rest {distance:g} m on; missed by {missed:.1e}, the optimiser's motion is {apart:.1e} from "
            "the exact one"
        )
        reached = found[0].outcome.solved and missed < NEAR
        return plan_from(motion, robot, told(request, "hopper", found, reached, goal))


def follower(wanted: Motion) -> Policy:
    """Return the policy that holds hip and leg to a motion, within their limits: (k, q, v) to (4,)."""
    limit = np.array(textbook.HOPPER_LIMIT)

    def policy(k: int, q: FloatArray, v: FloatArray) -> FloatArray:
        held = GAINS[:, 0] * (wanted.q[k] - q)[2:] + GAINS[:, 1] * (wanted.v[k] - v)[2:]
        return np.concatenate([np.zeros(2), np.clip(wanted.u[k] + held, -limit, limit)])

    return policy


TASK = Hopper()
