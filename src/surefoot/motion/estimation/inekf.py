"""The contact-aided right-invariant extended Kalman filter on points: an IMU, and feet that stand still.

Between corrections an IMU is integrated; a foot that touches is a landmark, seen from the body by the leg's
kinematics. The state lives in SE_{2+n}(3) [1]_, and the error exp(ξ) = X̂ X⁻¹ in world axes moves by a matrix
that does not depend on the state: errors of any size in attitude and velocity propagate exactly linearly
(with the biases, to first order); what cannot be observed, place and heading, stays so in the filter.

References
----------
.. [1] R. Hartley, M. Ghaffari, R. M. Eustice, J. W. Grizzle, "Contact-aided invariant extended Kalman
   filtering for robot state estimation", IJRR 39(4), 2020; first at RSS 2018.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import (
    BoolArray,
    FloatArray,
    finite_array,
    real_number,
    semidefinite,
    whole_number,
)
from surefoot.base.errors import ProblemError
from surefoot.base.live_arrays import Bound
from surefoot.base.spatial import skew
from surefoot.motion.estimation import inekf_kernels as kernels

GATE = 21.1
"""Squared Mahalanobis distance from which a foot is not believed: 1 in 10⁴ of three normal numbers."""
GATE_HEIGHT = 10.8
"""The same for one number, 1 in 10³."""


@dataclass(frozen=True)
class FilterNoise:
    """What the filter believes about its sensors and the ground, as standard deviations.

    Attributes
    ----------
    gyro, accelerometer
        White noise of turn rate [rad/s/√Hz] and specific force [m/s²/√Hz]: more than a data sheet says, since
        legs shake the IMU.
    gyro_drift, accelerometer_drift
        Random walk of the biases [rad/s²/√Hz], [m/s³/√Hz].
    foot
        Wandering of a foot that stands under a body at rest [m/s/√Hz]: creep, soft ground.
    landing
        The same while a foot has just landed [m/s/√Hz].
    joint, joint_speed
        Of a joint's angle [rad] and of its speed [rad/s].
    velocity, tilt, gyro_bias, accelerometer_bias
        Of the start: [m/s], [rad], [rad/s], [m/s²]. Place and heading there are exact, by definition.
    height
        Of the height that a map has for the ground under a foot that lands [m]. Legs that are off by half a
        degree against the IMU err by as much on every step, the same way: a map that is believed to a few mm
        then bends the gyro's bias.
    turning, slip, impact
        More wandering of every foot that stands, per turn rate of the body [m/s/√Hz per rad/s], per speed of
        the foot over the ground [m/s/√Hz per m/s], and per specific force beyond gravity's, held for 50 ms
        [m/s/√Hz per m/s²]: a round foot twists under a body that turns, and legs give way where it lands.
        Their squares add to that of `foot` or `landing`.
    """

    gyro: float = 2e-3
    accelerometer: float = 2e-2
    gyro_drift: float = 1e-4
    accelerometer_drift: float = 1e-3
    foot: float = 5e-4
    landing: float = 5e-2
    joint: float = 1e-3
    joint_speed: float = 0.05
    velocity: float = 0.05
    tilt: float = 0.02
    gyro_bias: float = 0.01
    accelerometer_bias: float = 0.1
    height: float = 0.05
    turning: float = 0.05
    slip: float = 0.05
    impact: float = 5e-3

    def __post_init__(self) -> None:
        for one in fields(self):
            real_number(one.name, getattr(self, one.name), low=0.0, high=1e3)


STIFF_FEET = {"foot": 5e-3, "height": 5e-3, "turning": 0.0, "slip": 0.0, "impact": 0.0}
"""Beliefs about feet, see `FilterNoise`, where legs are as stiff and straight as their model, in simulation:
a foot's contact creeps alike at rest and in motion (`python -m benchmarks.state_estimate`)."""


class InvariantFilter(Bound):
    """Velocity, attitude, place, feet and biases of a body with an IMU and n feet.

    Parameters
    ----------
    feet
        Number of feet n.
    noise
        See `FilterNoise`; None for its defaults.
    gate
        Squared Mahalanobis distance from which a foot is not believed [-].

    Attributes
    ----------
    X
        (3, 5 + n) [R | v | p | d_1 ... d_n], world axes.
    bias
        (6,) of the gyro [rad/s] and the accelerometer [m/s²].
    covariance
        (15 + 3n, 15 + 3n) of [ξ; bias errors], ξ ordered [φ; v; p; d_1 ... d_n], the biases last: true
        X = exp(-ξ) X̂. Rows of feet that do not touch are zero.
    standing
        (n,) which feet are in the state.
    distances
        (n,) squared Mahalanobis distances of the last observation.
    innovations
        (n, 3) its innovations, whitened: normal numbers of variance one where all is as it is believed.
    memory
        What holds these numbers, see `filter_arrays`; `flags` (2, n) has these feet and those used last.

    Examples
    --------
    >>> filter = InvariantFilter(1)
    >>> foot, spread = np.array([[0.0, 0.0, -0.3]]), 1e-6 * np.eye(3)[None]
    >>> for _ in range(2000):  # at rest, with a biased accelerometer
    ...     filter.predict(np.zeros(3), np.array([0.0, 0.0, 9.91]), 0.002)
    ...     believed = filter.observe(foot, spread, np.array([True]))
    >>> filter.bias.round(2)[5], bool(abs(filter.velocity).max() < 1e-3)
    (np.float64(0.1), True)
    """

    MEMORY = ("memory", "flags")

    def __init__(self, feet: int, noise: FilterNoise | None = None, gate: float = GATE) -> None:
        self.n = whole_number("feet", feet, low=1)
        self.noise = noise or FilterNoise()
        n = self.n
        N = 15 + 3 * n
        self.flags: BoolArray = np.zeros((2, n), dtype=bool)
        self._sizes = [3 * (5 + n), 6, N * N, 4 + n, 5, 1, n, 3 * n]  # as `filter_arrays` has them
        self.memory: FloatArray = np.zeros(sum(self._sizes))
        self._none: BoolArray = np.zeros(n, dtype=bool)
        self._bind()
        self._gate[0] = real_number("gate", gate, low=0.0)
        self.reset()

    def _bind(self) -> None:
        """Find the parts of the memory."""
        n = self.n
        self.standing: BoolArray = self.flags[0]
        self.used: BoolArray = self.flags[1]
        parts = np.split(self.memory, np.cumsum(self._sizes)[:-1])
        self.X: FloatArray = parts[0].reshape(3, 5 + n)
        self.bias: FloatArray = parts[1]
        self.covariance: FloatArray = parts[2].reshape(15 + 3 * n, 15 + 3 * n)
        self._densities, self._walks, self._gate, self.distances = parts[3:7]
        self.innovations: FloatArray = parts[7].reshape(n, 3)

    def reset(
        self,
        rotation: ArrayLike | None = None,
        velocity: ArrayLike = (0.0, 0.0, 0.0),
        position: ArrayLike = (0.0, 0.0, 0.0),
        bias: ArrayLike | None = None,
        covariance: ArrayLike | None = None,
    ) -> None:
        """Start again without feet.

        Parameters
        ----------
        rotation, velocity, position
            (3, 3), (3,) [m/s], (3,) [m] of the IMU in world axes; None for upright.
        bias
            (6,) of gyro [rad/s] and accelerometer [m/s²]; None for zero.
        covariance
            (15, 15) of attitude, velocity, place and biases as errors ξ [rad, m/s, m, rad/s, m/s²]; None for
            the noise's start.

        Raises
        ------
        ProblemError
            For wrong shapes, what is no rotation, and a covariance that is not symmetric and positive
            semidefinite. The filter stays as it was.
        """
        R = np.eye(3) if rotation is None else finite_array("rotation", rotation, (3, 3))
        if np.abs(R @ R.T - np.eye(3)).max() > 1e-6 or np.linalg.det(R) < 0.0:
            raise ProblemError("rotation must be a rotation matrix")
        v, p = finite_array("velocity", velocity, (3,)), finite_array("position", position, (3,))
        small = self._start(v, p) if covariance is None else semidefinite("covariance", covariance, 15)
        self.bias[:] = np.zeros(6) if bias is None else finite_array("bias", bias, (6,))
        self.X[:] = np.column_stack([R, v, p, np.zeros((3, self.n))])
        # Feet lie between the place and the biases. Without feet their rows are zero, as they are for those
        # in the air: a foot that lands gets its covariance from the place's.
        known = np.r_[0:9, 9 + 3 * self.n : 15 + 3 * self.n]
        self.covariance[:] = 0.0
        self.covariance[np.ix_(known, known)] = small
        self.standing[:] = False
        w = self.noise
        self._densities[:] = w.foot**2
        self._walks[:] = np.square([w.foot, w.landing, w.turning, w.slip, w.impact])
        self._densities[:4] = np.square([w.gyro, w.accelerometer, w.gyro_drift, w.accelerometer_drift])

    def _start(self, v: FloatArray, p: FloatArray) -> FloatArray:
        """Return the covariance of a start whose tilt, velocity and biases are uncertain."""
        w = self.noise
        P = np.zeros((15, 15))
        turn = np.diag([w.tilt**2, w.tilt**2, 0.0])
        lever = np.vstack([np.eye(3), skew(v), skew(p)])  # ξ of a turn about the body's own place
        P[:9, :9] = lever @ turn @ lever.T
        P[3:6, 3:6] += w.velocity**2 * np.eye(3)
        P[9:12, 9:12] = w.gyro_bias**2 * np.eye(3)
        P[12:, 12:] = w.accelerometer_bias**2 * np.eye(3)
        return P

    @property
    def rotation(self) -> FloatArray:
        """(3, 3) rotation from body to world axes [-]."""
        return self.X[:, :3]

    @property
    def velocity(self) -> FloatArray:
        """(3,) of the IMU, world axes [m/s]."""
        return self.X[:, 3]

    @property
    def position(self) -> FloatArray:
        """(3,) of the IMU, world axes [m]."""
        return self.X[:, 4]

    def predict(self, gyro: FloatArray, accelerometer: FloatArray, dt: float) -> None:
        """Go on by dt [s] with (3,) turn rate [rad/s] and specific force [m/s²], body axes, means over dt."""
        kernels.propagate(
            self.X, self.bias, self.covariance, self.standing, gyro, accelerometer, self._densities, dt
        )

    def observe(
        self, places: FloatArray, spreads: FloatArray, touching: BoolArray, landed: BoolArray | None = None
    ) -> BoolArray:
        """Correct with the feet that touch and did so before; return which of them were believed: (n,).

        Feet that touch for the first time, or that are not believed (they slid), are put where they are seen;
        those that touch no longer are forgotten.

        Parameters
        ----------
        places
            (n, 3) of the feet, body axes from the IMU [m].
        spreads
            (n, 3, 3) their covariances [m²].
        touching
            (n,) which feet stand on the ground.
        landed
            (n,) which of them may still move a little, see `FilterNoise.landing`; None for none.
        """
        fresh = self._none if landed is None else landed
        kernels.observe_feet(
            self.X, self.bias, self.covariance, self.standing, places, spreads, touching, fresh,
            self._walks, self._densities, self._gate[0], self.distances,
            self.innovations, self.used,
        )  # fmt: skip
        return self.used.copy()

    def observe_height(self, k: int, normal: FloatArray, excess: float, deviation: float) -> bool:
        """Correct with a known distance of foot k from a plane; return whether that was believed.

        Parameters
        ----------
        k
            A foot that stands.
        normal
            (3,) unit normal of the plane, world axes.
        excess
            How much further than known the foot seems to be [m].
        deviation
            Standard deviation of what is known [m].
        """
        return kernels.correct_height(
            self.X, self.bias, self.covariance, k, normal, excess, deviation**2, GATE_HEIGHT
        )

    def height_deviation(self, k: int, normal: FloatArray, deviation: float) -> float:
        """Return the standard deviation [m] of the excess of foot k over a plane with the (3,) normal."""
        row, j = np.zeros(len(self.covariance)), 9 + 3 * k
        row[:3], row[j : j + 3] = np.cross(self.X[:, 5 + k], normal), normal
        return float(np.sqrt(row @ self.covariance @ row + deviation**2))

    def doubt_velocity(self, deviation: float) -> None:
        """Add to the uncertainty of the velocity [m/s]: what was believed has turned out to be wrong."""
        self.covariance[3:6, 3:6] += deviation**2 * np.eye(3)
