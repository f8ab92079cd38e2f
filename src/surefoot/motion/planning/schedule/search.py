"""Ipopt on a scheduled motion."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError
from surefoot.motion.planning.schedule.mirror import found_in_half
from surefoot.motion.planning.schedule.schedule_problem import ScheduleProblem
from surefoot.motion.planning.schedule.schedule_transcription import transcribe, variable_bounds
from surefoot.motion.planning.transcription.initial_guess import Guess
from surefoot.motion.planning.transcription.nlp import Iterate, Nlp, OnIteration, pack, unpack
from surefoot.records import Log

OPTIONS: dict[str, Any] = {"tol": 1e-7, "mu_strategy": "adaptive", "mumps_pivot_order": 0}
"""Of Ipopt: exact steps with a little feedback mend what its tolerance leaves. Blocks in a row are ordered by
approximate minimum degree: with the order that MUMPS chooses itself a jump takes 0.3 s longer."""
PUSHES = ("bound_push", "bound_frac", "slack_bound_push", "slack_bound_frac", "mult_bound_push")
WARM: dict[str, Any] = {
    "warm_start_init_point": "yes", "mu_init": 1e-3, **{f"warm_start_{name}": 1e-3 for name in PUSHES},
}  # fmt: skip
"""Of Ipopt's, for a start with multipliers: 9 to 13 iterations for jumps within 0.2 m of an earlier one, with
a hundredth of it up to twice as many."""
CLOSE = dict.fromkeys(WARM, 1e-6) | {"warm_start_init_point": "yes"}
"""For a start from the motion that is its own mirror image: of a robot whose sides are nearly alike."""
LEFT = 1.0
"""CPU time that is left for the robot itself, however long that motion took [s]."""
HELD = ("optimum_variables", "optimum_bounds", "optimum_rows")
"""Facts of a plan that another search may start from: variables, and multipliers of bounds and rows."""
ACCEPTED = 1e-6
"""Largest violation of a row or bound, in its own scale, of a motion that counts as found."""


@dataclass(frozen=True, eq=False)
class ScheduledMotion(Guess):
    """What the optimiser found: a motion, and how it was come by.

    Attributes
    ----------
    iterate
        Ipopt's last one.
    """

    iterate: Iterate

    @property
    def found(self) -> bool:
        """Whether the violation is within `ACCEPTED`: the motion keeps to dynamics, modes and limits."""
        return bool(self.iterate.violation <= ACCEPTED)


def guess_from(problem: ScheduleProblem) -> Guess:
    """Return what to start from: the reference with the weight on the feet that stand."""
    import pinocchio

    robot, n, stance = problem.robot, problem.knots, problem.stance
    ways = [pinocchio.difference(robot.model, a, b) for a, b in pairwise(problem.reference)]
    speeds = np.vstack([problem.v, np.array(ways) / problem.dt])
    impulses = np.zeros((n, *stance.shape[1:], 3))
    share = stance / np.maximum(stance.sum(axis=1, keepdims=True), 1)
    impulses[:, :, 2] = share * (problem.weight * problem.dt)
    return Guess(problem.reference, speeds, np.zeros((n, robot.joints)), impulses)


def pack_guess(problem: ScheduleProblem, guess: Guess) -> FloatArray:
    """Return the variables (V,) of the NLP that mean a motion, each in its unit."""
    use = np.clip(guess.torques / problem.torque_limits, -1.0, 1.0)
    forces = guess.impulses.reshape(problem.knots, -1) / (problem.weight * problem.dt)
    return pack(np.hstack([guess.q, guess.v]), np.hstack([use, forces]))


def optimise(
    problem: ScheduleProblem,
    max_iterations: int = 500,
    tell: OnIteration | None = None,
    near: Log | None = None,
    **options: Any,
) -> ScheduledMotion:
    """Return the best motion that Ipopt finds over a problem's schedule.

    Parameters
    ----------
    problem
        See `ScheduleProblem`.
    max_iterations
        Of Ipopt.
    tell
        Called with the number of every iteration, cost and violation.
    near
        A plan to start from in place of the reference (`guess_from`), with its facts `HELD`.
    options
        Ipopt's, without their prefix.

    Raises
    ------
    ProblemError
        For a plan that does not tell `HELD`, or has other numbers of variables and rows.
    MissingExtra
        If CasADi is not installed.
    """
    before, (block, rows) = time.process_time(), transcribe(problem)
    begin, multipliers = pack_guess(problem, guess_from(problem)), None
    kept = np.flatnonzero((np.isfinite(rows[0]) | np.isfinite(rows[1])).ravel())  # the others bound nothing
    options, bounds, half = {**OPTIONS, "max_iter": max_iterations, **options}, variable_bounds(problem), None
    if near is not None:
        begin, of_bounds, of_rows = _check_names(near, (len(begin), len(begin), len(kept)))
        multipliers, options = (of_bounds, of_rows), WARM | options
    else:
        half = found_in_half(problem, block, rows, bounds, begin, tell, **options)
    if half is not None:
        if half.violation <= ACCEPTED:
            multipliers, options = (half.multipliers[0], half.multipliers[1][kept]), CLOSE | options
        if multipliers is not None or half.ending.startswith(("Maximum_", "interrupted")):
            begin = half.variables
        options["max_iter"] = 0 if half.ending == "interrupted" else max(max_iterations - half.iterations, 0)
        if "max_cpu_time" in options:
            options["max_cpu_time"] = max(options["max_cpu_time"] + before - time.process_time(), LEFT)
    found = Nlp(block, problem.knots, kept).solve(
        begin, problem.reference[1:], bounds, rows, multipliers=multipliers, tell=tell, **options
    )
    if half is not None:
        ending = half.ending if half.ending == "interrupted" else found.ending
        found = replace(found, iterations=half.iterations + found.iterations, ending=ending)
    robot, model = problem.robot, problem.robot.model
    states, inputs = unpack(found.variables, int(model.nq + model.nv), problem.knots)
    q, v = np.split(states, [int(model.nq)], axis=1)
    torques = inputs[:, : robot.joints] * problem.torque_limits
    forces = inputs[:, robot.joints :].reshape(-1, len(robot.contact_points), 3) * problem.weight
    return ScheduledMotion(q.copy(), v.copy(), torques, forces * problem.dt, found)


def _check_names(near: Log, sizes: tuple[int, ...]) -> list[FloatArray]:
    """Return what `HELD` names, if it fits a program of so many variables, bounds and rows."""
    found = [near.fact(name) for name in HELD]
    if tuple(map(len, found)) != sizes:
        said = "near must be of the same robot, kind of task and knots: a plan of {} variables and {} rows"
        raise ProblemError(f"{said.format(sizes[0], sizes[2])}, got {len(found[0])} and {len(found[2])}")
    return found
