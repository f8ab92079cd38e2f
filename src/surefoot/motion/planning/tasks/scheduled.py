"""Whole-body tasks over a mode schedule that is given."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from surefoot.contact import Status
from surefoot.mechanics import Robot, limited_robot, load_robot, loaded_robot, unknown_limits
from surefoot.motion.planning.plan import Plan, PlanSearch, plan_from
from surefoot.motion.planning.tasks.task import Iteration, PlanRequest, Tell
from surefoot.motion.planning.trajectory import Trajectory

if TYPE_CHECKING:
    from surefoot.motion.planning.schedule import ScheduleProblem

METHOD = "schedule"
FEEDBACK = 0.95
"""Share of the torque limits that the exact motion may use: the optimiser used less."""
DRIFT = 5e-3
"""How far the exact motion may be from the optimiser's [m, rad]."""
OVER = 1e-3
"""By how much a joint may exceed a limit [N m, rad/s, rad]: rounding, and a little feedback."""
PATIENCE = 20.0
"""CPU time after which a search gives up [s]."""
BRIEF = 0.2
"""Share of that for a search from a near plan: one that is further off begins anew."""
MOST = 600
"""Iterations of a search."""
Goal = Callable[[Trajectory], tuple[bool, str]]
"""Whether a motion does what it should, and what it does, in words."""


def mover(request: PlanRequest) -> Robot:
    """Return who moves: the robot with its payload, and likely limits where its model has none."""
    return limited_robot(loaded_robot(request.robot or load_robot("go2"), request.payload))


def beyond_limits(robot: Robot, motion: Trajectory) -> str:
    """Return which limits of a robot's joints a motion exceeds, in words; empty for none."""
    model = robot.model
    first = int(model.nq) - robot.joints
    below, above = np.array(model.lowerPositionLimit)[first:], np.array(model.upperPositionLimit)[first:]
    known = below < above
    angles = motion.q[:, first:][:, known]
    use = {
        "torque": float((np.abs(motion.torques) - robot.effort_limits).max()),
        "speed": float((np.abs(motion.v[:, robot.base_dof :]) - robot.speed_limits).max()),
        "position": float(np.maximum(below[known] - angles, angles - above[known]).max(initial=-np.inf)),
    }
    over = [f"{name} by {value:.2g}" for name, value in use.items() if value > OVER]
    return "joints beyond their limits: " + ", ".join(over) if over else ""


def judge_goal(motion: Trajectory, robot: Robot, goal: Goal) -> tuple[bool, str]:
    """Return whether an exact motion reaches a goal within the robot's limits, and what it does, in words."""
    if not np.isfinite(motion.q).all():
        return False, "the motion is lost"
    done, said = goal(motion)
    beyond = beyond_limits(robot, motion)
    return done and not beyond, f"{said}; {beyond}" if beyond else said


def scheduled_plan(
    task: str, problem: ScheduleProblem, request: PlanRequest, tell: Tell, goal: Goal,
    patience: float = PATIENCE,
) -> Plan:  # fmt: skip
    """Return the plan of a problem: SOLVED where its exact rollout is lawful and does what the goal says.

    Parameters
    ----------
    task, request, tell
        Its name, what was asked, and who hears of iterations.
    problem
        The schedule's.
    goal
        Of the exact motion: that of the optimiser's torques, with small corrections, through exact steps.
    patience
        CPU time after which the search gives up [s].
    """
    from surefoot.motion.planning.schedule.search import HELD, optimise
    from surefoot.motion.planning.transcription.exact_rollout import follow
    from surefoot.motion.planning.transcription.motion_errors import departure

    begun = time.perf_counter()

    def heard(number: int, cost: float, violation: float) -> None:
        tell(Iteration(number, cost, violation, "whole body over the schedule"))

    most, iterations = request.max_iterations or MOST, 0
    for near in (None,) if request.near is None else (request.near, None):
        limit = patience if near is None else BRIEF * patience
        motion = optimise(problem, most, heard, near, max_cpu_time=limit)
        iterations += motion.iterate.iterations
        most = 0 if motion.iterate.ending == "interrupted" else most
        if motion.found or most == 0:
            break
    lost = not motion.iterate.finite
    trajectory = (
        Trajectory.blank(problem.robot, problem.knots, problem.dt, request.mu)
        if lost
        else follow(replace(problem, mu=request.mu, torque_share=FEEDBACK), motion)
    )
    done, said = judge_goal(trajectory, problem.robot, goal)
    unknown = " and ".join(unknown_limits(request.robot or problem.robot))
    said += f"; {unknown} limits are unknown: likely ones are kept" if unknown else ""
    ended, off = motion.iterate.ending, departure(problem.robot, motion, trajectory)
    if not motion.found:
        said += f"; the optimiser ended with {ended}, {motion.iterate.violation:.1e} off its constraints"
    elif off > DRIFT:
        said += f"; the exact motion departs by {off:.1e} from the optimiser's"
    stopped = Status.MAX_ITERATIONS if ended.startswith("Maximum_") else Status.STALLED
    search = PlanSearch(
        task, METHOD, motion.iterate.cost, bool(done and motion.found), iterations,
        time.perf_counter() - begun, said, stopped,
    )  # fmt: skip
    held = (motion.iterate.variables, *motion.iterate.multipliers)
    facts: dict[str, Any] = dict(zip(HELD, held, strict=True)) if motion.found else {}
    if request.payload:
        facts |= {"payload": request.payload, "payload_position": np.zeros(3)}
    if ended == "interrupted" or most == 0:
        facts["interrupted"] = True
    return plan_from(trajectory, problem.robot, search, problem.terrain, **facts)
