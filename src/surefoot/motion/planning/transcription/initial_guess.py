"""Where a search starts: a motion between two postures, or a plan there is already."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError
from surefoot.motion.planning.trajectory import Trajectory

if TYPE_CHECKING:
    from surefoot.motion.planning.transcription.direct_problem import DirectProblem


@dataclass(frozen=True, eq=False)
class Guess:
    """A motion that need not be one: what an optimiser starts from, and what it ends in.

    Attributes
    ----------
    q, v
        (N + 1, nq), (N + 1, nv); the velocities are those of the ways, see `Trajectory.ways`.
    torques
        (N, joints) [N m].
    impulses
        (N, p, 3), contact axes [N s]; those of touches beside feet on the ground come last.
    """

    q: FloatArray
    v: FloatArray
    torques: FloatArray
    impulses: FloatArray

    @classmethod
    def between(cls, problem: DirectProblem) -> Guess:
        """Return the straight way from a problem's start to the reference of the last knot.

        The robot's weight rests on all contact points alike.
        """
        model, n = problem.robot.model, problem.knots
        way = problem.references[-1] - problem.q
        states = problem.q + np.linspace(0.0, 1.0, n + 1)[:, None] * way
        v = np.tile(way / (n * problem.dt), (n + 1, 1))
        v[0] = problem.v
        points = len(problem.robot.contact_points)
        impulses = np.zeros((n, len(problem.frictions), 3))
        weight = problem.robot.mass * float(np.linalg.norm(model.gravity.linear))
        impulses[:, :points, 2] = weight * problem.dt / points
        return cls(states, v, np.zeros((n, problem.robot.joints)), impulses)

    @classmethod
    def of(cls, motion: Trajectory | Guess, problem: DirectProblem) -> Guess:
        """Return a motion as a guess, on the knots of a problem: held, stretched or thinned to their number.

        Velocities and impulses are scaled to the problem's time step where the motion has its own.
        """
        have, knots = len(motion.torques), problem.knots
        pace, speeds, rate = have / knots, motion.v, 1.0
        if isinstance(motion, Trajectory):
            speeds, rate = motion.ways, pace * motion.dt / problem.dt
        at = np.minimum(pace * np.arange(knots + 1), have)
        first = np.minimum(at.astype(np.int64), have - 1)
        share = (at - first)[:, None]
        q = (1.0 - share) * motion.q[first] + share * motion.q[first + 1]
        v = (1.0 - share) * speeds[first] + share * speeds[first + 1]
        nearest = np.minimum(((at[:-1] + at[1:]) / 2.0).astype(np.int64), have - 1)
        return cls(q, rate * v, motion.torques[nearest].copy(), pace / rate * motion.impulses[nearest])

    def checked(self, problem: DirectProblem) -> Guess:
        """Return the guess if it fits a problem.

        Raises
        ------
        ProblemError
            For arrays of another size.
        """
        model, n = problem.robot.model, problem.knots
        wanted = {
            "q": (n + 1, model.nq),
            "v": (n + 1, model.nv),
            "torques": (n, problem.robot.joints),
            "impulses": (n, len(problem.frictions), 3),
        }
        for name, shape in wanted.items():
            if getattr(self, name).shape != shape:
                raise ProblemError(
                    f"{name} of the guess must have shape {shape}, got {getattr(self, name).shape}"
                )
        return self
