"""What pushes a walking robot from outside: a payload that nobody announced, and the wrench that is left.

The six rows of the floating base in M a + h = Sᵀ τ + Σ Jᵀ f + w say what the ground's forces leave over of
the motion; the forces are those that the legs' own rows ask for, from commanded torques. Accelerations are
changes of the velocity from step to step: averaged over a block of steps they are the change of momentum over
it, as in a momentum observer [1]_, and their noise does not add up. A Kalman filter splits a block's mean:

    w = weight of a mass m at r on the base  +  rest

linear in m and m r, which hardly change (the payload), with a rest that fades within a fraction of a second
(pushes, wind, friction in the legs). The weight alone is looked for: a load's inertia becomes part of the
model once the load is known, and held against measured accelerations their noise would pass for one. So how
high it lies shows only while the base leans.

References
----------
.. [1] A. De Luca, R. Mattone, "Sensorless robot collision detection and hybrid force/motion control",
   ICRA 2005.
.. [2] G. Bledt, P. Wensing, S. Ingersoll, S. Kim, "Contact model fusion for event-based locomotion in
   unstructured terrains", ICRA 2018.
"""

from __future__ import annotations

import math
from functools import cache
from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, real_number
from surefoot.base.kernels import kernel
from surefoot.base.memory import Remembering
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics import Robot
from surefoot.motion.estimation import wrench_kernels as kernels

# masses are shares of the robot's m, forces of m g, places of the height h of its centre of mass
BLOCK = 0.01
"""Time over which the wrench is averaged [s]: accelerations of single steps are mostly noise."""
MASS, PLACE = 0.4, 0.1
"""Standard deviations of a payload's mass, and of its first moment over m h, before anything is seen [-]."""
MEMORY = 200.0
"""Time in which a payload may become another [s]; its height, which a level robot cannot tell, is forgotten
within it."""
FORCE, MOMENT = 0.1, 0.05
"""Standard deviations of the rest, and of its moment over m g h [-]."""
FADING = 0.3
"""Time in which the rest fades [s]: pushes are shorter than payloads."""
NOISE_FORCE, NOISE_MOMENT = 0.1, 0.05
"""Standard deviations of a block's mean at least [-]; more where it changes more from block to block."""
WATCH = 0.5
"""Time over which those changes are watched [s]: about a stride."""
LEAST, MOST = -0.3, 1.5
"""Bounds on the payload's mass [-]; negative where the robot is lighter than its model."""
FURTHEST = 0.6
"""Bound on how far a payload lies from the base's origin along each axis [-]: on the trunk."""
LARGEST = 0.3
"""Bound on the rest, along each axis [-]."""
VIOLENT = 2.0
"""A block's mean is taken for no more than this [-]: touchdowns strike harder than loads weigh."""
LIGHT = 0.05
"""Mass below which a payload's place is given nearer than it is [-]: it cannot be known."""
NOISE = np.array([NOISE_FORCE**2] * 3 + [NOISE_MOMENT**2] * 3)
"""(6,) least variances of a block's mean [-]."""
DEVIATIONS = np.array([MASS] + [PLACE] * 3 + [FORCE] * 3 + [MOMENT] * 3)
"""(10,) standard deviations of the state before anything is seen [-]."""


class Load(NamedTuple):
    """What the base carries beyond its model; negative where the robot is lighter than it.

    Attributes
    ----------
    mass
        [kg].
    moment
        (3,) first moment, the mass times its place in base axes [kg m].
    place
        (3,) base axes [m]; nearer for masses below `LIGHT`.
    """

    mass: float
    moment: FloatArray
    place: FloatArray


class Instant(NamedTuple):
    """What a robot's model says at a state, as the equations of motion of the next step need it.

    Attributes
    ----------
    M, bias
        (nv, nv), (nv,) mass matrix and bias forces [kg, N, N m].
    v
        (nv,) velocity [m/s, rad/s].
    twists
        (6, nv) Pinocchio's data.J.
    points
        (n, 3) where the feet touch, world axes [m].
    pose
        (3, 4) rotation and place of the base.
    """

    M: FloatArray
    bias: FloatArray
    v: FloatArray
    twists: FloatArray
    points: FloatArray
    pose: FloatArray


@cache
def _decay(block: float) -> tuple[FloatArray, FloatArray, float]:
    """Return how much of the state (10,) is kept over a block [s], and the variance (10,) that it gains.

    And the share of the newest difference in the spread of the blocks.
    """
    times = np.array([math.inf] * 3 + [MEMORY] + [FADING] * 6)
    keep = np.exp(-block / times)
    # What fades keeps its variance of before anything was seen (a first-order Markov process); mass and level
    # first moment do not fade and gain variance steadily.
    drive = DEVIATIONS**2 * (1.0 - keep**2)
    drive[:3] = DEVIATIONS[:3] ** 2 * 2.0 * block / MEMORY
    return keep, drive, 1.0 - math.exp(-block / WATCH)


class WrenchObserver(Remembering):
    """Estimates payload and external wrench step by step: `observe` after every step that was taken.

    Parameters
    ----------
    robot
        With a floating base and feet; what it weighs beyond its model is the payload.
    dt
        Time between steps [s].

    Attributes
    ----------
    state
        (10,) mass and first moment of the payload, force and moment of the rest, in their units.
    values
        The same in kg, kg m, N and N m: an array of its own after every block.
    height
        Of the centre of mass over the feet [m].
    """

    MEMORY = ("state", "_covariance", "_sum", "_count", "_spread", "_last", "values")

    def __init__(self, robot: Robot, dt: float) -> None:
        self.robot, self.dt = robot, real_number("dt", dt, low=1e-6)
        height = float(robot.com(robot.nominal)[2] - robot.foot_positions(robot.nominal)[:, 2].mean())
        self.height = max(height, 0.05)
        mass, force = [robot.mass] + [robot.mass * self.height] * 3, robot.mass * GRAVITY
        self._unit = np.array(mass + [force] * 3 + [force * self.height] * 3)
        self._steps = max(1, round(BLOCK / self.dt))
        self.reset()

    def reset(self) -> None:
        """Forget the past: no payload, no wrench."""
        self.state, self._covariance = np.zeros(10), np.diag(DEVIATIONS**2)
        self._sum, self._count = np.zeros(6), 0
        self._spread, self._last = np.zeros(6), np.full(6, np.nan)
        self.values = self.state * self._unit

    def observe(
        self, before: Instant, after: FloatArray, torques: FloatArray, touching: BoolArray,
        carried: FloatArray | None = None,
    ) -> bool:  # fmt: skip
        """Take in a step; return whether that has ended a block, and changed the estimate.

        Parameters
        ----------
        before
            The model at the start of the step.
        after
            (nv,) velocity at its end [m/s, rad/s].
        torques
            (joints,) during it [N m].
        touching
            (n,) which feet may have pushed.
        carried
            (4,) mass [kg] and first moment [kg m] of a load that the model of `before` has already; the
            estimate is of all that the robot carries.
        """
        points = self.robot.contact_points
        load = np.zeros(4) if carried is None else carried
        kernels.sum_wrench(
            before.M, before.bias, before.v, after, self.dt, torques, before.twists, points.foot_support,
            before.points, points.flat, touching, before.pose, load, self._sum,
        )  # fmt: skip
        self._count += 1
        if self._count < self._steps:
            return False
        self._correct(before.pose)
        self._sum, self._count = np.zeros(6), 0
        return True

    def _correct(self, pose: FloatArray) -> None:
        """Filter a full block; one that is not finite is left out."""
        mean = self._sum / (self._count * self._unit[4:])
        if not np.isfinite(mean).all():
            return
        self.state, self._covariance = take_block(
            self.state, self._covariance, mean, self._last, self._spread, pose, *_decay(self._steps * self.dt)
        )
        self.values = self.state * self._unit

    @property
    def carried(self) -> FloatArray:
        """The payload's (4,) mass [kg] and first moment [kg m]."""
        return np.asarray(self.values[:4])

    @property
    def load(self) -> Load:
        """The payload."""
        mass, moment = float(self.carried[0]), self.carried[1:]
        known = math.copysign(max(abs(mass), LIGHT * self.robot.mass), mass)
        return Load(mass, moment, moment / known)

    @property
    def wrench_unit(self) -> FloatArray:
        """What forces and moments are shares of (6,): m g and m g h [N, N m]."""
        return np.asarray(self._unit[4:])

    @property
    def wrench(self) -> FloatArray:
        """The rest (6,): force and moment about the base's origin, world axes [N, N m]."""
        return np.asarray(self.values[4:])


@kernel
def take_block(
    state: FloatArray, covariance: FloatArray, mean: FloatArray, last: FloatArray, spread: FloatArray,
    pose: FloatArray, keep: FloatArray, drive: FloatArray, watch: float,
) -> tuple[FloatArray, FloatArray]:  # fmt: skip
    """Return state and covariance after a block, all in units in which gravity is one.

    Parameters
    ----------
    state, covariance, pose, keep, drive
        As for `filter_wrench`.
    mean
        (6,) of the block.
    last, spread
        (6,) mean of the block before, not finite for none, and variance of such means: brought up to this.
    watch
        Share of the newest difference in that variance.
    """
    noise = np.empty(6)
    for a in range(6):
        # Half the mean square of the differences of neighbours is the variance of what changes from block to
        # block, whatever slow part there is: a gait's own wrench then counts as noise.
        new = min(max(mean[a], -VIOLENT), VIOLENT)
        change = new - last[a] if math.isfinite(last[a]) else 0.0
        spread[a] += watch * (0.5 * (change * change) - spread[a])
        last[a], noise[a] = new, max(NOISE[a], spread[a])
    x, P = kernels.filter_wrench(state, covariance, last, pose, noise, keep, drive)
    x[0] = min(max(x[0], LEAST), MOST)
    for a in range(1, 10):
        most = FURTHEST * max(abs(x[0]), LIGHT) if a < 4 else LARGEST
        x[a] = min(max(x[a], -most), most)
    return x, P
