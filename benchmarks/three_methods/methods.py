"""The methods: each takes a task's problem and a start, and returns an exact motion; listed in METHODS."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from benchmarks.three_methods.task import JumpTask, reached
from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError
from surefoot.mechanics.dynamics import StepOptions, Stepper
from surefoot.motion.planning.direct import DirectProblem, Guess, plan_direct, plan_with_modes
from surefoot.motion.planning.shooting import (
    Costs,
    Shooting,
    ShootingProblem,
    ShootingSettings,
    StateCost,
    TorqueCost,
)
from surefoot.motion.planning.trajectory import Trajectory, rollout
from surefoot.motion.planning.transcription.motion_errors import exact_cost, window_miss

PRICES = (1e3, 1e4, 1e5)
"""Of missing the end and the height, where a method can only price them: per m² and rad²; speeds a tenth."""
MOST = 300
"""Iterations of shooting at each price."""


@dataclass(frozen=True)
class Outcome:
    """What a method made of a task.

    Attributes
    ----------
    solved
        By `task.reached`.
    seconds
        Processor time [s].
    iterations
        Of the method's own.
    cost
        Of the exact motion, by the task's weights, for all methods alike.
    law_residual
        Of the exact motion.
    miss
        How far outside its bounds it is [m, rad].
    """

    solved: bool
    seconds: float
    iterations: int
    cost: float
    law_residual: float
    miss: float


Method = Callable[[JumpTask, DirectProblem, np.random.Generator | None], tuple[Trajectory, int]]
"""Task, the problem (perhaps one of its variations) and noise for a random start, to motion, iterations."""


def solve_task(method: Method, task: JumpTask, problem: DirectProblem, seed: int | None) -> Outcome:
    """Return what a method makes of a problem, from its own start (None) or a random one."""
    rng = None if seed is None else np.random.default_rng(seed)
    begin = time.process_time()
    motion, iterations = method(task, problem, rng)
    spent = time.process_time() - begin
    miss = window_miss(problem, motion)
    return Outcome(
        reached(problem, motion), spent, iterations, exact_cost(problem, motion), motion.law_residual, miss
    )


def _guess(task: JumpTask, problem: DirectProblem, rng: np.random.Generator | None) -> Guess:
    """Return the straight way to the goal, or one with noise on every state."""
    straight = Guess.between(problem)
    if rng is None:
        return straight
    q, v = straight.q.copy(), straight.v.copy()
    q[1:] += task.noise * rng.normal(size=q[1:].shape)
    v[1:] += 10.0 * task.noise * rng.normal(size=v[1:].shape)
    share = rng.uniform(0.0, 2.0, size=straight.impulses.shape[:2])
    return Guess(q, v, straight.torques, share[..., None] * straight.impulses)


def given_schedule(
    task: JumpTask, problem: DirectProblem, rng: np.random.Generator | None
) -> tuple[Trajectory, int]:
    """Optimise the whole body over the task's schedule: the modes' equations, by Ipopt."""
    found = plan_with_modes(problem, task.modes(problem), guess=_guess(task, problem, rng))
    return found.trajectory, found.plan.iterations


def direct(task: JumpTask, problem: DirectProblem, rng: np.random.Generator | None) -> tuple[Trajectory, int]:
    """Run the direct method: softened laws among the constraints, by Ipopt, then the modes' equations."""
    found = plan_direct(problem, guess=_guess(task, problem, rng))
    return found.trajectory, found.plan.iterations


def shooting(
    task: JumpTask, problem: DirectProblem, rng: np.random.Generator | None
) -> tuple[Trajectory, int]:
    """Shoot: exact steps forward, smoothed derivatives backward; bounds of the goal are prices that rise."""
    limits = np.maximum(_limits(problem), 1e-9)
    torques = np.tile(np.clip(holding(problem), -limits, limits), (problem.knots, 1))
    if rng is not None:
        torques += task.noise * limits * rng.normal(size=torques.shape)
    iterations = 0
    for price in PRICES:
        costs = Costs(_states(problem, price), TorqueCost(2.0 * problem.dt * problem.weights.torque))
        shot = ShootingProblem(
            problem.robot, costs, problem.knots, problem.dt, problem.mu, problem.terrain,
            limits,
        )  # fmt: skip
        settings = ShootingSettings(max_iterations=MOST)
        try:
            found = Shooting(shot).solve(problem.q, problem.v, torques, settings)
        except ProblemError:  # it cannot begin where the steps of its guess are lost
            return _led(problem, torques), iterations
        torques, iterations = found.trajectory.torques, iterations + found.iterations
        if not found.trajectory.lawful:
            break
    return found.trajectory, iterations


def _limits(problem: DirectProblem) -> FloatArray:
    """Return the torque limits (joints,) [N m]."""
    limits = problem.torque_limits
    assert limits is not None
    return limits


def _states(problem: DirectProblem, price: float) -> StateCost:
    """Return the task's own weights, the height at its knot and the end as heavy ones."""
    nv, n, w = int(problem.robot.model.nv), problem.knots, problem.weights
    weights = np.tile(2.0 * problem.dt * np.repeat([w.posture, w.velocity], nv), (n, 1))
    terminal = np.repeat([price, 0.1 * price], nv)
    wanted = problem.references.copy()
    for k, window in problem.windows.items():
        assert window.q_low is not None
        for entry in np.flatnonzero(np.isfinite(window.q_low)):  # of the base's place: the same entry of v
            weights[k, entry], wanted[k, entry] = price, window.q_low[entry]
    return StateCost(weights, terminal, wanted, np.zeros(nv))


def _led(problem: DirectProblem, torques: FloatArray) -> Trajectory:
    """Return where torques lead from the start."""
    return rollout(
        problem.robot, problem.q, problem.v, torques, dt=problem.dt, mu=problem.mu, terrain=problem.terrain
    )


def holding(problem: DirectProblem) -> FloatArray:
    """Return the torques (joints,) [N m] that hold the start with the least forces at the feet."""
    import pinocchio

    robot, model = problem.robot, problem.robot.model
    stepper = Stepper(robot, problem.terrain, StepOptions(order=1))
    seen = stepper.contacts(stepper.start(problem.q))
    weight = np.array(pinocchio.computeGeneralizedGravity(model, model.createData(), problem.q))
    driven = np.concatenate([np.zeros(robot.base_dof, dtype=bool), _limits(problem) > 0.0])
    forces = np.linalg.lstsq(seen.J.T[~driven], weight[~driven], rcond=None)[0]
    return np.where(driven, weight - seen.J.T @ forces, 0.0)[robot.base_dof :]


METHODS: dict[str, Method] = {
    "given schedule": given_schedule,
    "own shooting": shooting,
    "direct method": direct,
}
"""By name, in the order of the table."""
