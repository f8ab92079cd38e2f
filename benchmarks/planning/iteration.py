"""What one iteration of the shooting solver costs, beside iLQR on MuJoCo's finite differences."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from benchmarks.planning.mujoco_ilqr import MujocoIteration
from benchmarks.timing import least_time
from surefoot.base.arrays import FloatArray
from surefoot.mechanics.dynamics import Knot, StepOptions, Stepper
from surefoot.mechanics.robot import Robot, place
from surefoot.motion.planning.shooting.costs import Costs, FootCost, StateCost, TorqueCost
from surefoot.motion.planning.shooting.initial_torques import holding_torques
from surefoot.motion.planning.shooting.iteration import ShootingIteration
from surefoot.motion.planning.shooting.shooting_problem import ShootingProblem

KNOTS, DT, MU = 20, 0.025, 0.6
RIVAL_DT = 0.005
"""Of the comparison with MuJoCo, whose stiff contacts lose the robot in steps of `DT` [s]."""
SMOOTHING = 0.1
ITERATIONS = 10
"""Of both solvers."""
PARTS = ("derivative", "riccati", "rollout")


def problem(robot: Robot, feet: bool, dt: float) -> ShootingProblem:
    """Return a quick squat to one side, with or without a price on slipping feet."""
    q = place(robot)
    q[:3] += [0.03, 0.02, -0.05]
    weights = np.concatenate([np.full(6, 100.0), np.full(12, 1.0), np.full(6, 1.0), np.full(12, 0.02)])
    slip = FootCost(slip=1.0) if feet else FootCost()
    return ShootingProblem(
        robot, Costs(StateCost(weights, 10.0 * weights, q), TorqueCost(1e-3), slip), KNOTS, dt, MU
    )


least = partial(least_time, clock=time.process_time)
"""Least processor time: other work on the machine is kept out."""


def time_knot(robot: Robot, repeats: int) -> dict[str, float]:
    """Return the processor time of a knot's step and derivatives, standing on four feet [s]."""
    knot = Knot(Stepper(robot, options=StepOptions(dt=DT, order=1)))
    q, v, torques = place(robot), np.zeros(robot.model.nv), holding_torques(robot, place(robot))
    out = knot_arrays(robot)
    block = 50  # the clock's own resolution is a microsecond

    def many(call: Callable[[], Any]) -> float:
        def loop() -> None:
            for _ in range(block):
                call()

        loop()
        return least(loop, repeats) / block

    step = knot.step(q, v, torques, MU)
    return {
        "step": many(lambda: knot.step(q, v, torques, MU)),
        "derivative": many(lambda: knot.derivative(step, 0.0, out)),
        "smoothed derivative": many(lambda: knot.derivative(step, SMOOTHING, out)),
    }


def knot_arrays(robot: Robot) -> tuple[FloatArray, FloatArray]:
    """Return arrays for A and B."""
    n = int(robot.model.nv)
    return np.empty((2 * n, 2 * n)), np.empty((2 * n, robot.joints))


def start(iteration: ShootingIteration) -> float:
    """Put the torques that hold the robot into an iteration; return the motion's cost."""
    robot = iteration.problem.robot
    q, v = place(robot), np.zeros(robot.model.nv)
    iteration.gains[:] = iteration.steps[:] = 0.0
    iteration.damping = 1e-3
    iteration.now.q[:], iteration.now.v[:], iteration.now.torques[:] = q, v, holding_torques(robot, q)
    iteration.choose([(iteration.policy, 0.0)], np.inf)
    return iteration.now.cost


def iterate(iteration: ShootingIteration) -> float:
    """Take one iteration; return the share of the step."""
    iteration.differentiate(SMOOTHING)
    for _ in range(20):
        share = iteration.search((1.0, 0.5, 0.25, 0.1)) if iteration.backward() else 0.0
        iteration.damping = max(0.3 * iteration.damping, 1e-6) if share else 10.0 * iteration.damping
        if share:
            return share
    return 0.0


def time_iteration(iteration: ShootingIteration, repeats: int) -> dict[str, float]:
    """Return the least processor time of the parts of one iteration, and of a whole one [s]."""
    start(iteration)
    iterate(iteration)
    parts = {
        "derivative": least(lambda: iteration.differentiate(SMOOTHING), repeats),
        "riccati": least(iteration.backward, repeats),
    }
    policy, bounds = iteration.policy, iteration.bounds
    first = iteration.now.q[0].copy(), iteration.now.v[0].copy()

    def roll() -> None:
        iteration.spare.run(first, policy, 1.0, bounds)
        iteration.spare.price(iteration.tables)

    parts["rollout"] = least(roll, repeats)

    def whole() -> None:
        iteration.differentiate(SMOOTHING)
        iteration.backward()
        roll()

    return {**parts, "iteration": least(whole, repeats)}


def descend(iteration: ShootingIteration) -> dict[str, Any]:
    """Return costs and the processor time of a solve of some iterations."""
    begun = time.process_time()
    costs = [start(iteration)]
    for _ in range(ITERATIONS):
        iterate(iteration)
        costs.append(iteration.now.cost)
    return {"costs": costs, "seconds": time.process_time() - begun}


def measure(robot: Robot, quick: bool) -> dict[str, Any]:
    """Return everything measured; times in seconds."""
    repeats = 5 if quick else 40
    ours = ShootingIteration(problem(robot, True, DT))
    plain = ShootingIteration(problem(robot, False, RIVAL_DT))
    rival = MujocoIteration(plain.problem)
    found: dict[str, Any] = {
        "knots": KNOTS,
        "dt": DT,
        "knot": time_knot(robot, repeats),
        "ours": time_iteration(ours, repeats),
        "rival_dt": RIVAL_DT,
        "same": time_iteration(plain, repeats),
        "mujoco": time_iteration(rival, max(repeats // 8, 2)),
        "descent": {"ours": descend(plain), "mujoco": descend(rival)},
    }
    found["derivative_ratio"] = found["mujoco"]["derivative"] / found["same"]["derivative"]
    return found
