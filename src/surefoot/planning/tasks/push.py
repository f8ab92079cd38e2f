"""The task `push`: a foot pushes a block to where it is to rest."""

from __future__ import annotations

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.planning.plan import Plan, plan_from
from surefoot.planning.tasks.softened import METHODS, search, told, within
from surefoot.planning.tasks.task import Request, Tell
from surefoot.planning.trajectory import Trajectory
from surefoot.planning.transcription import robots, textbook
from surefoot.planning.transcription.problem import SmallProblem
from surefoot.planning.transcription.replay import Replay, replay

NEAR = 1e-4
"""How far the end may be from the goal [m, m/s]."""


class Push:
    """A foot pushes a block; when it touches, slides along and lets go is the optimiser's affair.

    `Knot` knows feet on the ground only, so the steps are those of `transcription.replay`: the same
    arithmetic, every contact problem solved by `surefoot.solve` and certified by its residuals. The log has
    the ground's forces on block and foot; the push between them is in the channel of the torques, as what
    the foot's motors give, and in the fact ``push_impulses``.
    """

    name = "push"
    meaning = "a foot pushes a block, which then rests"
    amount = "distance [m]"
    default: float | None = 0.3
    robots = False
    methods = METHODS

    def plan(self, request: Request, tell: Tell) -> Plan:
        """Return the plan; see `Task`."""
        distance = within(request, "push", "m", 0.0, 1.0)
        problem = textbook.pushed_block(distance, request.mu, request.knots or 25, request.dt or 0.04)
        found = search(problem, request, tell)
        steps = replay(problem, found[0].motion.u)
        missed = max(abs(float(steps.motion.q[-1, 0]) - distance), float(np.abs(steps.motion.v[-1]).max()))
        apart = float(np.abs(steps.motion.q - found[0].motion.q).max())
        goal = (
            f"the block at rest {distance:g} m on; missed by {missed:.1e}, the optimiser's motion is "
            f"{apart:.1e} m from the exact one"
        )
        reached = found[0].outcome.solved and missed < NEAR
        trajectory = trajectory_of(problem, steps, request.mu)
        pushes = np.stack([steps.motion.friction[:, 1], steps.motion.normal[:, 1]], axis=1)
        return plan_from(
            trajectory, robots.block_and_foot(), told(request, "push", found, reached, goal),
            push_impulses=pushes,
        )  # fmt: skip


def trajectory_of(problem: SmallProblem, steps: Replay, mu: float) -> Trajectory:
    """Return exact steps of block and foot as a trajectory of `robots.block_and_foot`."""
    motion, N = steps.motion, problem.knots
    ground = [0, 2]  # the touches that are with the ground
    impulses, speeds = np.zeros((N, 2, 3)), np.zeros((N, 2, 3))
    impulses[:, :, 0], impulses[:, :, 2] = motion.friction[:, ground], motion.normal[:, ground]
    speeds[:, :, [0, 2]] = motion.v[1:].reshape(N, 2, 2)
    positions = np.zeros((N + 1, 2, 3))
    positions[:, :, [0, 2]] = motion.q.reshape(N + 1, 2, 2)
    positions[:, 1, 2] -= textbook.FOOT_RADIUS
    torques = np.concatenate([np.zeros((N, 2)), motion.u], axis=1)
    gaps: FloatArray = positions[:, :, 2].copy()
    return Trajectory(
        problem.dt, mu, motion.q, motion.v, torques, impulses, gaps, positions, speeds, steps.residuals,
        steps.solved,
    )  # fmt: skip


TASK = Push()
