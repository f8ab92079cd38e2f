"""Stand up from lying: postures that roll the body onto its feet, found by sampling exact rigid rollouts.

The robot lies with its legs folded. Five postures, mirrored between front and rear legs but not between left
and right, are drawn at random (cross-entropy method) and rolled out with joints that follow them; what is
sought is a body upright over folded legs. From there it rises: legs under the hips, then straight up, the
same for every robot. Every contact of every link is in the rollout, each step's contact problem is solved
exactly, so that a plan that gets up in its own rollout is a lawful one.
"""

from __future__ import annotations

import math
import time as clock
from dataclasses import dataclass, field

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.errors import ProblemError, SimulationError
from surefoot.base.spatial import GRAVITY, quaternion_about
from surefoot.mechanics import Robot, load_robot
from surefoot.motion.planning.plan import Plan, PlanSearch
from surefoot.motion.planning.stand_up.cross_entropy import cross_entropy
from surefoot.motion.planning.stand_up.forward import ForwardModel, RigidModel
from surefoot.motion.planning.stand_up.lying import beyond, lying_plan, upright
from surefoot.motion.planning.stand_up.posture_sequence import Postures
from surefoot.motion.planning.tasks.task import Iteration, PlanRequest, Tell

STEP, FINER = 1e-3, 0.5
"""Length of a step of the search [s], and of one of the plan's own rollout over it."""
ROLLS, ROLL_TIME = 5, 0.3
"""Number of postures that are sought, and the time to each [s]."""
GATHER, RISE, HOLD = (0.3, 0.4), 0.7, 0.5
"""Time to fold the legs under the body and to wait there, to rise, and to stand [s]."""
STIFFNESS, DAMPING = 0.4, 0.01
"""Of the joints, over the weight [m/rad, m s/rad]."""
SAMPLES = 32
"""Rollouts in a round."""
ENOUGH = 0.65
"""Cost of a rollout that got up without a hard fall."""
BLOW_TIME = 4e-3
"""The hardest blow that the base takes counts as the change of its velocity in this time [s]."""
WITHIN, NEAR = 0.12, 0.04
"""By how much targets stay within the joints' ranges [rad], since loaded legs give way, and from where on it
costs that they do."""
FOLDED = (1.3, -2.6)
"""Thigh and calf of a folded leg [rad]; the hips at zero."""


@dataclass(frozen=True)
class StandUp:
    """The task `stand-up`; its number is how far the robot lies turned over about its long axis [deg]."""

    name: str = "stand-up"
    amount: str = "roll angle of the lying start, 180 for the back [deg]"
    default: float | None = 180.0
    robots: bool = True
    takes: tuple[str, ...] = ()
    model: ForwardModel | None = field(default=None, compare=False)

    def plan(self, request: PlanRequest, tell: Tell) -> Plan:
        """Return the plan; see `Task.plan`."""
        robot = request.robot or load_robot("go2")
        legs = _legs(robot)
        dt = request.dt or STEP
        model = self.model or RigidModel(robot, request.mu, dt)
        search = _Rollouts(robot, model, legs)
        begin = clock.perf_counter()
        start = search.lie(math.radians(request.amount if request.amount is not None else 180.0))
        rounds = request.max_iterations or 8
        found = cross_entropy(
            lambda point: search.cost(point, start), *search.first_guess(), samples=SAMPLES, elites=6,
            rounds=rounds, enough=ENOUGH, seed=request.seed,
            tell=lambda number, cost: tell(Iteration(number, cost, 0.0, "sampling")),
        )  # fmt: skip
        how = PlanSearch(
            self.name, "sampling", found.cost, found.reached, found.evaluations, clock.perf_counter() - begin
        )
        fine = RigidModel(robot, request.mu, FINER * dt)
        plan = lying_plan(fine, search.postures(found.point), start, how)
        if not found.reached and found.evaluations < rounds * SAMPLES:
            plan.facts["interrupted"] = True
        return plan


def _legs(robot: Robot) -> IntArray:
    """Return the joints (n, 3) of a four-legged robot's legs: hip, thigh, calf.

    Raises
    ------
    ProblemError
        For a robot without four legs of three joints each.
    """
    rows = [np.flatnonzero(row[6:]) for row in robot.contact_points.foot_support]
    if len(rows) != 4 or any(len(row) != 3 for row in rows):
        raise ProblemError(f"stand-up is for robots on four legs of three joints, {robot.name} is none")
    return np.array(rows, dtype=np.int64)


class _Rollouts:
    """Rollouts of one robot in one model."""

    def __init__(self, robot: Robot, model: ForwardModel, legs: IntArray) -> None:
        self.robot, self.model, self._legs = robot, model, legs
        weight = robot.mass * GRAVITY
        self._gains = STIFFNESS * weight, DAMPING * weight
        feet = robot.foot_positions(robot.nominal)
        self._side = np.sign(feet[:, 1])
        low, high = robot.model.lowerPositionLimit[7:], robot.model.upperPositionLimit[7:]
        self._ends = np.array(low) + NEAR, np.array(high) - NEAR
        self._low, self._high = np.array(low) + WITHIN, np.array(high) - WITHIN

    def first_guess(self) -> tuple[FloatArray, FloatArray]:
        """Return mean and deviation of the first samples."""
        mean = np.tile([0.0, FOLDED[0], FOLDED[1] + 0.25], 2 * ROLLS)
        return mean, np.tile([0.8, 1.5, 0.6], 2 * ROLLS)

    def pose(self, hip: FloatArray, thigh: FloatArray, calf: FloatArray) -> FloatArray:
        """Return joint angles (joints,) from those of the left and of the right legs, hips outward."""
        out = self.robot.nominal[7:].copy()
        for leg, side in zip(self._legs, self._side, strict=True):
            k = 0 if side > 0.0 else 1
            out[leg] = side * hip[k], thigh[k], calf[k]
        return np.clip(out, self._low, self._high)

    @property
    def folded(self) -> FloatArray:
        """Joint angles (joints,) with the legs folded."""
        return self.pose(np.zeros(2), np.full(2, FOLDED[0]), np.full(2, FOLDED[1]))

    def postures(self, point: FloatArray) -> Postures:
        """Return the postures of a sample."""
        rolls = [self.pose(*knot.T) for knot in point.reshape(ROLLS, 2, 3)]
        stand = self.robot.nominal[7:]
        times = ROLL_TIME * np.arange(1, ROLLS + 1)
        more = times[-1] + np.cumsum([*GATHER, RISE, HOLD])
        targets = np.array([*rolls, self.folded, self.folded, stand, stand])
        return Postures.of(self.robot, np.concatenate([times, more]), targets, *self._gains)

    def lie(self, roll: float) -> FloatArray:
        """Return where the robot comes to lie (nq,) when it is laid down turned by `roll` [rad]."""
        model, folded = self.model, self.folded
        q = self.robot.nominal.copy()
        q[7:] = folded
        q[3:7] = quaternion_about([1.0, 0.0, 0.0], roll)
        model.reset(q)
        law = Postures.of(self.robot, np.ones(1), folded[None], *self._gains)
        for _ in range(round(1.5 / model.dt)):
            q, v = model.q_v()
            model.step(law.torques(folded, q[7:], v[6:]))
        return model.q_v()[0].copy()

    def cost(self, point: FloatArray, start: FloatArray) -> float:
        """Return the cost of a sample: not upright or late, not over folded legs, not risen, not at rest."""
        model, law = self.model, self.postures(point)
        model.reset(start)
        late, blow, over, gathered = 0.0, 0.0, 0.0, float(law.times[-3])
        window = max(1, round(BLOW_TIME / model.dt))
        speeds = [np.zeros(3)] * window
        try:
            for k in range(round(law.duration / model.dt)):
                time = k * model.dt
                q, v = model.q_v()
                if time >= gathered > time - model.dt:
                    missing = 4.0 * (1.0 - upright(q)) + 0.3 * float(np.abs(q[7:] - self.folded).max())
                    if missing > 1.0:  # does not get up: not worth the rest
                        return 10.0 + missing + late
                late += model.dt * (1.0 - upright(q))
                over = max(over, beyond(q[7:], *self._ends))
                blow = max(blow, float(np.abs(v[:3] - speeds[k % window]).max()))
                speeds[k % window] = v[:3].copy()
                model.step(law.torques(law.at(time, start[7:]), q[7:], v[6:]))
        except SimulationError:
            return math.inf
        q, v = model.q_v()
        low = abs(float(q[2] - self.robot.nominal[2])) / float(self.robot.nominal[2])
        rest = float(np.abs(v[:6]).max()) + float(np.abs(q[7:] - self.robot.nominal[7:]).max())
        return 4.0 * (1.0 - upright(q)) + 2.0 * low + 0.3 * rest + 0.05 * late + blow + 10.0 * over


STAND_UP = StandUp()
