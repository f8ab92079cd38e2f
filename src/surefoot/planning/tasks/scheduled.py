"""Tasks on the first road: a mode schedule is given, the whole body's motion over it is found."""

from __future__ import annotations

import time as clock
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from surefoot.contact import Status
from surefoot.planning.plan import Plan, Search, plan_from
from surefoot.planning.tasks.task import Iteration, Request, Tell
from surefoot.planning.trajectory import Trajectory

if TYPE_CHECKING:
    from surefoot.planning.schedule import ScheduleProblem
    from surefoot.planning.schedule.search import ScheduledMotion
    from surefoot.robot import Robot

METHOD = "schedule"
FEEDBACK = 0.95
"""Share of the torque limits that the exact motion may use: the optimiser used less."""
DRIFT = 5e-3
"""How far the exact motion may be from the optimiser's [m, rad]."""
OVER = 1e-3
"""By how much a joint may exceed a limit [N m, rad/s, rad]: rounding, and a little feedback."""
Goal = Callable[[Trajectory], tuple[bool, str]]
"""Whether a motion does what it should, and what it does, in words."""


@dataclass(frozen=True)
class Attempt:
    """What the optimiser found and where its torques lead.

    Attributes
    ----------
    motion
        Of the optimiser.
    trajectory
        By exact steps that follow it with small corrections, which are part of its torques.
    drift
        Largest distance of the two [m, rad].
    """

    motion: ScheduledMotion
    trajectory: Trajectory
    drift: float


def carry_out(problem: ScheduleProblem, request: Request, tell: Tell) -> Attempt:
    """Return the motion of a problem, and its torques through the exact step."""
    from surefoot.planning.direct.follow import follow
    from surefoot.planning.direct.judge import departure
    from surefoot.planning.schedule import optimise

    def heard(number: int, cost: float, violation: float) -> None:
        tell(Iteration(number, cost, violation, "whole body over the schedule"))

    motion = optimise(problem, max_iterations=request.max_iterations or 600, tell=heard)
    trajectory = follow(replace(problem, mu=request.mu, torque_share=FEEDBACK), motion)
    return Attempt(motion, trajectory, departure(problem, motion, trajectory))


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


def scheduled_plan(task: str, problem: ScheduleProblem, request: Request, tell: Tell, goal: Goal) -> Plan:
    """Return the plan of a problem: SOLVED where its exact rollout is lawful and does what the goal says."""
    start = clock.perf_counter()
    tried = carry_out(problem, request, tell)
    motion = tried.motion
    if np.isfinite(tried.trajectory.q).all():
        done, said = goal(tried.trajectory)
        beyond = beyond_limits(problem.robot, tried.trajectory)
        done, said = done and not beyond, f"{said}; {beyond}" if beyond else said
    else:
        done, said = False, "the motion is lost"
    if not motion.found:
        said += f"; the optimiser ended with {motion.said}, {motion.violation:.1e} off its constraints"
    elif tried.drift > DRIFT:
        said += f"; the exact motion departs by {tried.drift:.1e} from the optimiser's"
    stopped = Status.MAX_ITERATIONS if motion.said == "Maximum_Iterations_Exceeded" else Status.STALLED
    search = Search(
        task, METHOD, motion.cost, bool(done and motion.found), motion.iterations,
        clock.perf_counter() - start, said, stopped,
    )  # fmt: skip
    facts: dict[str, object] = {"mode_events": list(getattr(problem.schedule, "event_times", []))}
    if motion.said == "interrupted":
        facts["interrupted"] = True
    return plan_from(tried.trajectory, problem.robot, search, problem.terrain, **facts)
