"""The task that all methods are given, its variations, and the one judgement of what they return."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.mechanics.terrain import SlopeTerrain
from surefoot.motion.planning.direct import DirectProblem, StateWindow, Weights, planar_hopper
from surefoot.motion.planning.trajectory import TOLERANCE, Trajectory
from surefoot.motion.planning.transcription.contact_rows import OPEN, STICK
from surefoot.motion.planning.transcription.motion_errors import window_miss
from surefoot.motion.planning.transcription.planar import RADIUS

NEAR = 0.02
"""The goal is reached where no bound is missed by more [m, rad; ten times as many m/s and rad/s]."""
TOP = 0.55
"""Share of the time at which a jump is to be at its height: a robot pushes off more slowly than it lands."""
WEIGHTS = Weights(change=0.0)
"""What all methods can write: torques, velocities and posture."""

IN_LESS_TIME = "in 24 knots"
"""A change that no schedule of 36 knots fits."""
SHORT = ((8, 17), (8, 18), (9, 17), (9, 18), (10, 17))
"""Schedules by hand for it: knots of take-off and touchdown."""


@dataclass(frozen=True, eq=False)
class JumpTask:
    """A jump, what it is planned with, and how it changes.

    Attributes
    ----------
    name
        For people.
    problem
        Start, goal, costs and limits.
    take_off, touchdown
        Knots of the given schedule: all feet stick before the one and from the other on, open between.
    noise
        Of random starts: standard deviation of states [m, rad], velocities ten times that.
    variations
        Name to a changed problem; the schedule is not changed with it.
    """

    name: str
    problem: DirectProblem
    take_off: int
    touchdown: int
    noise: float
    variations: Mapping[str, Callable[[DirectProblem], DirectProblem]]

    def modes(self, p: DirectProblem) -> IntArray:
        """Return the schedule (knots, p), cut to the knots of a problem or held for the rest."""
        out = np.full((p.knots, len(p.robot.contact_points)), STICK)
        out[self.take_off : self.touchdown] = OPEN
        return out


def reached(problem: DirectProblem, motion: Trajectory) -> bool:
    """Return whether a motion is lawful to 1e-8, within the torque limits, and does the task."""
    limits = problem.torque_limits
    assert limits is not None
    weak = bool((np.abs(motion.torques) <= limits + 1e-6).all())
    return (
        motion.lawful and motion.law_residual <= TOLERANCE and weak and window_miss(problem, motion) <= NEAR
    )


def hopper_jump() -> JumpTask:
    """Return the planar hopper's jump: 0.3 m on and 0.15 m up, from rest to rest in 1.08 s."""

    def jump(
        distance: float = 0.3, rise: float = 0.15, mu: float = 0.6, slope: float = 0.0, knots: int = 36
    ) -> DirectProblem:
        ground = SlopeTerrain(slope)
        robot = planar_hopper()
        q = robot.nominal.copy()
        q[1] += RADIUS * (1.0 / float(np.cos(np.radians(slope))) - 1.0)  # its sphere touches the slope
        there, low, rest = q.copy(), np.full(5, -np.inf), np.zeros(5)
        there[:2] += distance, float(ground.height([distance, 0.0]) - ground.height([0.0, 0.0]))
        low[1] = q[1] + rise
        windows = {round(TOP * knots): StateWindow(q_low=low)}
        end = StateWindow.at(there, rest, 0.5 * NEAR, 5.0 * NEAR)
        return DirectProblem(robot, q, rest, knots, 0.03, there, end, windows, WEIGHTS, mu, ground)

    return JumpTask(
        "planar hopper: 0.3 m on, 0.15 m up", jump(), 14, 24, 0.1,
        {
            "0.5 m on": lambda p: jump(0.5),
            "0.2 m back": lambda p: jump(-0.2),
            "0.25 m up": lambda p: jump(rise=0.25),
            "mu 0.2": lambda p: jump(mu=0.2),
            "uphill, 10 degrees": lambda p: jump(slope=10.0),
            "starts 0.1 m over the ground": lambda p: moved(p, {1: 0.1}),
            "starts crouched": lambda p: moved(p, {1: -0.101863, 3: 0.3, 4: -0.6}),
            IN_LESS_TIME: lambda p: jump(knots=24),
            "starts at 1 m/s": lambda p: replace(p, v=np.array([1.0, 0.0, 0.0, 0.0, 0.0])),
        },
    )  # fmt: skip


def moved(problem: DirectProblem, by: Mapping[int, float]) -> DirectProblem:
    """Return a problem whose start has some entries of q changed."""
    q: FloatArray = problem.q.copy()
    for entry, change in by.items():
        q[entry] += change
    return replace(problem, q=q)
