"""From an optimiser's motion to an exact one: its torques, with feedback about it, through exact steps.

An optimiser leaves errors of 1e-8, and a robot on a point foot falls: without feedback, errors grow a
thousandfold within a second. With gains of a linear-quadratic regulator about the motion they stay what they
are. The torques that were applied in the end are those of the plan: they need no feedback to be run again.
"""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import NoSolution
from surefoot.mechanics import MomentumKnot, StepOptions, Stepper
from surefoot.motion.planning.trajectory import TOLERANCE, Trajectory, rollout
from surefoot.motion.planning.transcription.motion_errors import Motion
from surefoot.motion.planning.transcription.pair_rollout import PairProblem, rollout_with_pairs

EFFORT = 1e-4
"""Weight of a torque's square against that of a distance [m, rad] and of a velocity [m/s, rad/s]."""
SMOOTHING = 1e-6
"""Of the steps' derivative [J]: less than what contacts exchange, more than what solvers leave."""


def follow(problem: PairProblem, motion: Motion, feedback: bool = True) -> Trajectory:
    """Return where exact steps lead that follow a motion.

    Parameters
    ----------
    problem
        Where it starts, and how large torques may be.
    motion
        What to follow.
    feedback
        Whether torques correct what goes off; else they are the motion's own, as always where the problem has
        touches beside feet on the ground.
    """
    import pinocchio

    model, limits = problem.robot.model, problem.torque_limits
    assert limits is not None
    K = gains(problem, motion) if feedback and not problem.touches else None

    def policy(k: int, q: FloatArray, v: FloatArray) -> FloatArray:
        torques = motion.torques[k]
        if K is not None:
            off = np.concatenate([pinocchio.difference(model, motion.q[k], q), v - motion.v[k]])
            torques = torques - K[k] @ off
        return np.asarray(np.clip(torques, -limits, limits))

    if problem.touches:
        return rollout_with_pairs(problem, policy)
    return rollout(
        problem.robot, problem.q, problem.v, policy, dt=problem.dt, mu=problem.mu, terrain=problem.terrain,
        steps=problem.knots,
    )  # fmt: skip


def gains(problem: PairProblem, motion: Motion) -> FloatArray:
    """Return the feedback (N, joints, 2nv) of a linear-quadratic regulator about a motion.

    Zero from where a step of the motion has no derivative, backwards.
    """
    robot, limits = problem.robot, problem.torque_limits
    assert limits is not None
    options = StepOptions(dt=problem.dt, order=1, solver_tol=TOLERANCE)
    knot = MomentumKnot(Stepper(robot, problem.terrain, options))
    motors = np.flatnonzero(limits > 0.0)
    size = 2 * int(robot.model.nv)
    value, out = np.eye(size), np.zeros((problem.knots, robot.joints, size))
    for k in reversed(range(problem.knots)):
        torques = np.clip(motion.torques[k], -limits, limits)
        try:
            step = knot.step(motion.q[k], motion.v[k], torques, problem.mu)
            A, B, _ = knot.derivative(step, smoothing=SMOOTHING)
        except NoSolution:
            return out
        B = B[:, motors]
        # Discrete Riccati recursion of ||x||² + EFFORT ||u||²; joints without motors have no part in it.
        weight = B.T @ value
        gain = np.linalg.solve(EFFORT * np.eye(len(motors)) + weight @ B, weight @ A)
        value = np.eye(size) + A.T @ value @ (A - B @ gain)
        value = 0.5 * (value + value.T)
        out[k][motors] = gain
    return out
