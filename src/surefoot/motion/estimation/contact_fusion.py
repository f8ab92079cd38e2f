"""How likely each foot touches: force, height, speed and plan together, each as sure as it can be.

The leg's force alone is late where it must be filtered, and blind to a foot that has bounced and barely
touches; a foot's height over the ground and its speed alone know nothing of ground that is not where it is
believed. Each says by how much its reading is likelier of a foot that touches than of one that does not; the
logarithms of these ratios add up to the odds of contact [1]_, [2]_:

- force along the normal: of a foot in the air it is normal about 0, of one that stands anything up to `heavy`
  shares of the weight;
- height over the believed ground: of a foot that stands normal about 0, of one in the air anything up to
  `clearance`;
- speed along the normal: normal about 0 with the deviation `still`, or with `swinging`;
- the plan: a foot that pushes, one that should have landed, one that swings.

References
----------
.. [1] M. Camurri, M. Fallon, S. Bazeille, A. Radulescu, V. Barasuol, D. G. Caldwell, C. Semini,
   "Probabilistic contact estimation and impact detection for state estimation of quadruped robots", RA-L
   2(2), 2017.
.. [2] G. Bledt, P. Wensing, S. Ingersoll, S. Kim, "Contact model fusion for event-based locomotion in
   unstructured terrains", ICRA 2018.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, real_number
from surefoot.base.live_arrays import Bound
from surefoot.base.memory import Remembering
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics import Robot, Terrain

BANDWIDTHS = (150.0, 1000.0)
"""Least and largest bandwidth of the momentum observer that `quiet_bandwidth` takes [1/s]."""
QUIET = 0.08
"""Noise of a foot's force that it allows, as a share of m g over the number of feet."""


@dataclass(frozen=True)
class TouchSettings:
    """What is believed of feet that touch and feet that do not.

    Attributes
    ----------
    force
        Standard deviation of the force that a foot in the air seems to bear, beside the noise of the
        encoders, as a share of m g over the number of feet: friction in the joints, torques and masses that
        are off.
    heavy
        Largest usual force, as such a share.
    height, unmapped
        Standard deviations of a standing foot's height over the believed ground, with a map and without [m].
    clearance
        How high feet swing, as a share of the height of the base.
    still, swinging
        Standard deviations of speeds along the normal [m/s], of feet that stand and that swing.
    pushing, swing
        Logarithms of the odds of contact by the plan alone [-]: of a foot that pushes, of one that swings;
        a foot that should have landed has even odds.
    hold
        How far the odds' logarithm must turn against what was believed before it changes [-].
    """

    force: float = 0.05
    heavy: float = 2.0
    height: float = 0.005
    unmapped: float = 0.03
    clearance: float = 0.25
    still: float = 0.05
    swinging: float = 1.0
    pushing: float = 2.0
    swing: float = -2.0
    hold: float = 0.5

    def __post_init__(self) -> None:
        for one in fields(self):
            signed = one.name in ("pushing", "swing")
            real_number(one.name, getattr(self, one.name), low=-20.0 if signed else 1e-6, high=1e3)


class GroundLevel(Remembering):
    """Where the ground is: a map, or else the plane through where the feet stood last.

    Parameters
    ----------
    ground
        The map; None for none.
    feet
        (n, 3) places on the ground to begin with, world axes [m].
    """

    MEMORY = ("_feet", "_middle", "_level", "_slope")

    def __init__(self, ground: Terrain | None, feet: FloatArray) -> None:
        self._ground, self._feet = ground, feet.copy()
        self._fit()

    def stood(self, k: int, place: FloatArray) -> None:
        """Learn that foot k has landed at a place (3,) [m]."""
        self._feet[k] = place
        self._fit()

    def normal(self) -> FloatArray:
        """Return the plane's normal (3,), a unit vector."""
        up = np.append(-self._slope, 1.0)
        return np.asarray(up / np.linalg.norm(up))

    def heights(self, places: FloatArray) -> FloatArray:
        """Return the ground's heights (n,) below places (n, 3) [m]."""
        if self._ground is not None:
            return np.asarray(self._ground.height(places[:, :2]))
        return np.asarray(self._level + (places[:, :2] - self._middle) @ self._slope)

    def _fit(self) -> None:
        """Fit the plane; feet in a row or fewer than three leave it level across them."""
        self._middle = self._feet[:, :2].mean(axis=0)
        self._level = float(self._feet[:, 2].mean())
        spread = self._feet[:, :2] - self._middle
        self._slope = np.linalg.lstsq(spread, self._feet[:, 2] - self._level, rcond=1e-3)[0]


def force_noise(robot: Robot, speed: float) -> FloatArray:
    """Return what white noise in the joints' speeds does to the feet's forces: (n,) [N s].

    Times the gain of `observer_gain` it is the standard deviation of the force along the vertical that a
    momentum observer finds in the nominal pose, `speed` being that of a joint's speed [rad/s].
    """
    import pinocchio

    model: Any = robot.model
    data, q = model.createData(), robot.nominal
    pinocchio.crba(model, data, q)
    pinocchio.computeJointJacobians(model, data, q)
    pinocchio.updateFramePlacements(model, data)
    M = np.triu(data.M) + np.triu(data.M, 1).T
    base, support = robot.base_dof, robot.contact_points.foot_support
    out = np.empty(len(robot.feet))
    for k, foot in enumerate(robot.feet):
        J = pinocchio.getFrameJacobian(model, data, foot.frame, pinocchio.LOCAL_WORLD_ALIGNED)[:3]
        columns = np.flatnonzero(support[k, base:]) + base
        to_force = np.linalg.pinv(J[:, columns].T, rcond=0.05) @ M[np.ix_(columns, columns)]
        out[k] = speed * np.linalg.norm(to_force[2])
    return out


def observer_gain(bandwidth: float, dt: float) -> float:
    """Return how far a momentum observer amplifies white noise in the momentum [1/s].

    It gives a low-pass of differences: a standard deviation of (1 - c) / dt √(2 / (1 + c)), c = exp(-K dt).
    """
    keep = math.exp(-bandwidth * dt)
    return (1.0 - keep) / dt * math.sqrt(2.0 / (1.0 + keep))


def quiet_bandwidth(robot: Robot, dt: float, speed: float) -> float:
    """Return the bandwidth [1/s] at which noise of the joints' speeds [rad/s] leaves the forces readable.

    The largest within `BANDWIDTHS` whose noise is no more than `QUIET` of a foot's weight.
    """
    worst = float(force_noise(robot, speed).max())
    allowed = QUIET * robot.mass * GRAVITY / len(robot.feet)
    low, high = BANDWIDTHS
    for _ in range(30):  # the gain rises with the bandwidth
        middle = 0.5 * (low + high)
        low, high = (middle, high) if worst * observer_gain(middle, dt) <= allowed else (low, middle)
    return high if worst * observer_gain(high, dt) <= allowed else low


class ContactFusion(Bound):
    """Decides step by step which feet touch; see the module for how.

    Parameters
    ----------
    robot
        With feet.
    settings
        See `TouchSettings`.
    noise
        (n,) standard deviations of the feet's forces by noise [N].
    speed
        Standard deviation of a joint's measured speed [rad/s].
    mapped
        Whether a map gives the ground's height.

    Attributes
    ----------
    contact
        (n,) which feet touch.
    odds
        (n,) logarithms of the odds of contact.
    """

    MEMORY = ("memory", "contact")

    def __init__(
        self, robot: Robot, settings: TouchSettings, noise: FloatArray, speed: float, mapped: bool
    ) -> None:
        n, s = len(robot.feet), settings
        share = robot.mass * GRAVITY / n
        reach = max(float(robot.nominal[2]), 0.1)
        self.settings = s
        self.memory: FloatArray = np.zeros((3, n))  # odds, prior odds, deviations of forces
        self._bind()
        self.memory[2] = np.hypot(s.force * share, noise)
        self.scales = np.array([
            s.heavy * share, s.height if mapped else s.unmapped, s.clearance * reach,
            math.hypot(s.still, speed * reach), s.swinging, s.hold, share,
        ])  # fmt: skip
        self.contact: BoolArray = np.zeros(n, dtype=bool)

    def _bind(self) -> None:
        """Find the parts of the memory."""
        self.odds, self._prior = self.memory[:2]

    def reset(self) -> None:
        """Forget what was believed."""
        self.contact[:] = False
        self.odds[:] = self._prior[:] = 0.0

    def expect(self, pushing: BoolArray, planned: BoolArray) -> None:
        """Take the plan for the next step: (n,) which feet push, and which should stand."""
        s = self.settings
        self._prior[:] = s.swing
        self._prior[planned], self._prior[pushing] = 0.0, s.pushing
