"""Four small problems through contact: a falling ball, a sliding point, a hopper and a push."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics import Robot
from surefoot.motion.planning.transcription import planar
from surefoot.motion.planning.transcription.contact_pairs import PlanarContactPair
from surefoot.motion.planning.transcription.direct_problem import DirectProblem, Weights
from surefoot.motion.planning.transcription.initial_guess import Guess
from surefoot.motion.planning.transcription.state_window import StateWindow

FREE = Weights(torque=0.0, velocity=0.0, posture=0.0, change=0.0)
"""Of a motion that nothing drives: the laws alone decide."""


@dataclass(frozen=True, eq=False)
class SmallProblem:
    """A problem that shows what softening does, and where random starts for it lie.

    Attributes
    ----------
    problem
        To be solved.
    towards
        (nq,) where a random start ends on average.
    spread
        (nq,) its standard deviation about the straight line there [m, rad].
    done
        What the end has to be; of a driven motion that is asked of the optimiser as well.
    """

    problem: DirectProblem
    towards: FloatArray
    spread: FloatArray
    done: StateWindow

    def guess(self, seed: int) -> Guess:
        """Return a random start: a noisy line, velocities of 1 m/s, impulses of the size of the weight's.

        Impulses are uniform between 0 and twice what gravity gives in a knot, also where the line is in the
        air; torques up to 0.3 of their limits.
        """
        p, random = self.problem, np.random.default_rng(seed)
        N, n, count = p.knots, len(self.towards), len(p.frictions)
        assert p.torque_limits is not None
        motors = np.flatnonzero(p.torque_limits)
        share = np.linspace(0.0, 1.0, N + 1)[:, None]
        q = p.q + share * (self.towards - p.q) + self.spread * random.normal(size=(N + 1, n))
        v = random.normal(size=(N + 1, n))
        q[0], v[0] = p.q, p.v
        torques, impulses = np.zeros((N, n)), np.zeros((N, count, 3))
        torques[:, motors] = 0.3 * p.torque_limits[motors] * random.uniform(-1.0, 1.0, size=(N, len(motors)))
        impulses[..., 2] = 2.0 * p.dt * GRAVITY * p.robot.mass * random.uniform(size=(N, count))
        sideways = random.uniform(-1.0, 1.0, size=(N, count))
        impulses[..., 0] = 0.5 * p.frictions * impulses[..., 2] * sideways
        return Guess(q, v, torques, impulses)


def falling_ball(height: float = 1.0, mu: float = 0.0, knots: int = 50, dt: float = 0.02) -> SmallProblem:
    """Return a ball of 1 kg that falls and stays where it lands: no input, the laws alone decide.

    Nothing moves it sideways: without friction there is nothing to choose, the problem is square.
    """
    robot = planar.point("ball", 0.1)
    start, end = robot.nominal + np.array([0.0, height]), robot.nominal
    problem = DirectProblem(robot, start, np.zeros(2), knots, dt, end, weights=FREE, mu=mu)
    done = StateWindow.at([np.nan, end[1]], np.zeros(2), 1e-6, 1e-6)
    return SmallProblem(problem, end, np.full(2, 0.3), done)


def sliding_point(speed: float = 2.0, mu: float = 0.5, knots: int = 40, dt: float = 0.02) -> SmallProblem:
    """Return a point of 1 kg that slides over the ground until friction has stopped it."""
    robot = planar.point("point")
    problem = DirectProblem(robot, np.zeros(2), np.array([speed, 0.0]), knots, dt, weights=FREE, mu=mu)
    done = StateWindow.at(None, np.zeros(2), speed=1e-6)
    return SmallProblem(problem, np.array([0.5, 0.0]), np.full(2, 0.1), done)


def hopper(distance: float = 0.3, mu: float = 0.6, knots: int = 30, dt: float = 0.03) -> SmallProblem:
    """Return a planar hopper, an upright body on one leg, that is to stand `distance` [m] further on."""
    robot = planar.sliding_hopper()
    end = robot.nominal + np.array([distance, 0.0, 0.0, 0.0])
    return _driven_motion(robot, end, end, [0.1, 0.1, 0.3, 0.05], 1e-3, (mu, knots, dt))


def pushed_block(distance: float = 0.3, mu: float = 0.4, knots: int = 25, dt: float = 0.04) -> SmallProblem:
    """Return a block of 2 kg that a foot, 10 cm away, is to push `distance` [m] on, where it rests."""
    robot = planar.block_and_foot()

    def face(q: Any) -> tuple[Any, Any]:
        return q[0] - 0.5 * planar.BLOCK_WIDTH - planar.RADIUS - q[2], q[3] - q[1]

    towards = robot.nominal + np.array([distance, 0.0, distance + 0.1, 0.0])
    end, spread = np.array([distance, np.nan, np.nan, np.nan]), [0.1, 0.02, 0.1, 0.02]
    made = _driven_motion(robot, end, towards, spread, 1e-2, (mu, knots, dt))
    return replace(
        made, problem=replace(made.problem, touches=(PlanarContactPair("foot on block", face, 0.3),))
    )


def _driven_motion(
    robot: Robot,
    end: FloatArray,
    towards: FloatArray,
    spread: list[float],
    effort: float,
    numbers: tuple[float, int, float],
) -> SmallProblem:
    """Return a motion from rest to rest at (nq,) `end`, NaN where free, that costs `effort` u² dt."""
    n, (mu, knots, dt) = len(end), numbers
    goal = StateWindow.at(end, np.zeros(n))
    problem = DirectProblem(
        robot, robot.nominal, np.zeros(n), knots, dt, towards, goal, weights=replace(FREE, torque=effort),
        mu=mu,
    )  # fmt: skip
    return SmallProblem(problem, towards, np.array(spread), StateWindow.at(end, np.zeros(n), 1e-6, 1e-6))


PROBLEMS: dict[str, Callable[[], SmallProblem]] = {
    "ball": falling_ball,
    "slide": sliding_point,
    "hopper": hopper,
    "push": pushed_block,
}
"""The problems by name."""
