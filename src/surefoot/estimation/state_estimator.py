"""State estimate from what a robot measures: contact detection and invariant filter, watched for failure.

At each step `predict` takes the sensors' readings and tells which feet seem to touch, `update` corrects with
them, `applied` takes the torques that follow. A foot whose leg is about to swing is taken out by the plan (a
force falls too slowly to tell), one that moves over the ground by its own speed, one that slid by its
innovation. What is left without any foot to stand on, or with feet that all disagree, is lost: `health`.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import NamedTuple

import numpy as np

from surefoot.arrays import BoolArray, FloatArray, real_number
from surefoot.estimation.contact_detection import ContactDetector, DetectionSettings
from surefoot.estimation.inekf_robot import InvariantEkf

DETECTION = DetectionSettings(lift_off=0.08, still=0.1)
"""Thresholds in the loop: a controller that waits for a foot which has landed softly falls meanwhile."""


class Health(StrEnum):
    """Whether an estimate can be used."""

    GOOD = "good"
    """It can."""
    NO_CONTACT = "no foot touched"
    """No foot has touched for too long: what the IMU gives alone has drifted."""
    DIVERGED = "diverged"
    """Feet touch but contradict it, its biases are none that sensors have, or it is not finite."""


class Reading(NamedTuple):
    """What the sensors say at one step.

    Attributes
    ----------
    gyro, accelerometer
        (3,) turn rate [rad/s] and specific force [m/s²] since the reading before, base axes.
    positions, speeds
        (joints,) of the encoders [rad], [rad/s].
    """

    gyro: FloatArray
    accelerometer: FloatArray
    positions: FloatArray
    speeds: FloatArray


@dataclass(frozen=True)
class WatchSettings:
    """When an estimate has failed.

    Attributes
    ----------
    doubt
        Time without a foot that is believed while feet touch, after which the velocity is doubted by
        `doubted` [s].
    doubted
        Standard deviation that is added to the velocity then [m/s].
    patience
        Time without a foot that is believed from which the estimate is lost [s].
    fastest
        Speed of the base from which it is [m/s].
    bias
        Size of a bias from which it is, as a multiple of its standard deviation at the start: what takes up
        that much is no bias, but a sensor that is broken.
    """

    doubt: float = 0.03
    doubted: float = 0.3
    patience: float = 0.3
    fastest: float = 10.0
    bias: float = 10.0

    def __post_init__(self) -> None:
        for name in ("doubt", "doubted", "patience", "fastest", "bias"):
            real_number(name, getattr(self, name), low=1e-6)


class StateEstimator:
    """Turns readings into q, v and contacts; see the module for how.

    Parameters
    ----------
    ekf
        The filter on its robot.
    detection
        Thresholds of the contact detection; None for `DETECTION`.
    watch
        When the estimate has failed; None for the defaults.

    Attributes
    ----------
    health
        `Health`; what is lost stays lost until `reset`.
    forces
        (n, 3) estimated forces on the feet, world axes [N].
    """

    def __init__(
        self,
        ekf: InvariantEkf,
        detection: DetectionSettings | None = None,
        watch: WatchSettings | None = None,
    ) -> None:
        self.ekf, self.watch = ekf, watch or WatchSettings()
        self.detector = ContactDetector(ekf.robot, ekf.dt, detection or DETECTION)
        noise = ekf.filter.noise
        self._largest = self.watch.bias * np.array([noise.gyro_bias, noise.accelerometer_bias])
        self.reset(ekf.robot.nominal)

    def reset(self, q: FloatArray, v: FloatArray | None = None) -> None:
        """Start from (nq,) q [m, rad] and (nv,) v [m/s, rad/s], as `InvariantEkf.reset` does."""
        self.ekf.reset(q, v)
        self.detector.reset()
        self.health = Health.GOOD
        self.forces = np.zeros((len(self.ekf.robot.feet), 3))
        self._alone = self._unheard = 0.0
        self._first = True

    def predict(self, reading: Reading) -> BoolArray:
        """Go on to the time of a reading; return which feet seem to touch: (n,). The first makes no step."""
        ekf = self.ekf
        if not self._first:
            ekf.predict(reading.gyro, reading.accelerometer)
        self._first, self._reading = False, reading
        ekf.joints(reading.positions, reading.speeds)
        q, v = ekf.state()
        if not (np.isfinite(q).all() and np.isfinite(v).all()):
            self.health = Health.DIVERGED
            return np.zeros(len(ekf.robot.feet), dtype=bool)
        found = self.detector.advance(q, v, ekf.normals)
        self.forces = found.forces
        return found.contact

    def update(self, contact: BoolArray, standing: BoolArray | None = None) -> tuple[FloatArray, FloatArray]:
        """Correct and return the estimate q (nq,) [m, rad] and v (nv,) [m/s, rad/s], Pinocchio's order.

        Parameters
        ----------
        contact
            (n,) which feet touch, as `predict` has told or something better.
        standing
            (n,) which of them are meant to stand, by the plan; None for all.
        """
        meant = contact if standing is None else contact & standing
        if self.health is not Health.DIVERGED:
            used = self.ekf.update(self._reading.positions, self._reading.speeds, meant)
            self._look(bool(used.any()), bool(contact.any()))
        return self.ekf.state()

    def applied(self, torques: FloatArray) -> None:
        """Tell the (joints,) torques from now to the next reading [N m]."""
        self.detector.applied(torques)

    def _look(self, believed: bool, touched: bool) -> None:
        """Judge the estimate after a correction."""
        watch, body, dt = self.watch, self.ekf.filter, self.ekf.dt
        self._alone = 0.0 if believed else self._alone + dt
        self._unheard = 0.0 if touched else self._unheard + dt
        if touched and self._alone >= watch.doubt and self._alone < watch.doubt + dt:
            body.doubt_velocity(watch.doubted)
        if self.health is not Health.GOOD:
            return
        speed = float(np.linalg.norm(body.velocity))
        biased = np.abs(body.bias).reshape(2, 3).max(axis=1)
        if not (speed <= watch.fastest and (biased <= self._largest).all()):
            self.health = Health.DIVERGED
        elif self._alone >= watch.patience:
            half = self._unheard >= 0.5 * self._alone
            self.health = Health.NO_CONTACT if half else Health.DIVERGED
