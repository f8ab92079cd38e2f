"""State estimate from what a robot measures: contact detection and invariant filter, watched for failure.

At each step `predict` takes the sensors' readings and returns which feet bear a force, `decide` says by their
heights, speeds and the plan as well which of them touch, `update` corrects with these, `expect` and `applied`
take the plan and the torques that follow. A foot whose leg is about to swing is taken out by the plan (a
force falls too slowly to tell), one that moves over the ground by its own speed, one that slid by its
innovation. What is left without any foot to stand on, or with feet that all disagree, is lost: `health`.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, real_number
from surefoot.base.memory import Remembering
from surefoot.base.spatial import GRAVITY
from surefoot.motion.estimation.contact_fusion import (
    ContactFusion,
    GroundLevel,
    TouchSettings,
    force_noise,
    observer_gain,
    quiet_bandwidth,
)
from surefoot.motion.estimation.detection_kernels import decide_contacts
from surefoot.motion.estimation.estimator_kernels import (
    BELIEVED,
    CREDIBLE,
    LANDED,
    TOUCHED,
    advance,
    settle,
    write_state,
)
from surefoot.motion.estimation.foot_force_observer import FootForceObserver
from surefoot.motion.estimation.inekf_robot import InvariantEkf
from surefoot.motion.estimation.sensor_delays import Latency

SENSED = 0.2
"""Share of m g over the number of feet from which a force alone says that a foot touches."""


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
        Size of a bias from which it is, relative to its standard deviation at the start: what takes up
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


class StateEstimator(Remembering):
    """Turns readings into q, v and contacts; see the module for how.

    Parameters
    ----------
    ekf
        The filter on its robot.
    watch
        When the estimate has failed; None for the defaults.
    latency
        How late the IMU and the encoders tell what they measure [s]: the state that `update` returns is
        that of now.

    Attributes
    ----------
    health
        `Health`; what is lost stays lost until `reset`.
    forces
        (n, 3) estimated forces on the feet, world axes [N].
    """

    MEMORY = (
        "ekf", "detector", "fusion", "latency", "ground", "_stood", "_sensed", "health", "forces", "_alone",
        "_unheard", "_first",
    )  # fmt: skip

    def __init__(
        self,
        ekf: InvariantEkf,
        watch: WatchSettings | None = None,
        latency: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        self.ekf, self.watch = ekf, watch or WatchSettings()
        self.latency = Latency(ekf, *latency)
        noise, dt = ekf.filter.noise, ekf.dt
        bandwidth = quiet_bandwidth(ekf.robot, dt, noise.joint_speed)
        sensed = observer_gain(bandwidth, dt) * force_noise(ekf.robot, noise.joint_speed)
        self.fusion = ContactFusion(
            ekf.robot, TouchSettings(), sensed, noise.joint_speed, ekf.ground is not None
        )
        usual = ekf.robot.mass * GRAVITY / len(ekf.robot.feet)
        self.detector = FootForceObserver(ekf.robot, dt, bandwidth, ekf.feet, SENSED * usual)
        largest = self.watch.bias * noise.gyro_bias, self.watch.bias * noise.accelerometer_bias
        self._limits = np.array([self.latency.ahead, self.watch.fastest, *largest])
        self._nq, self._nv = len(ekf.q), len(ekf.v)
        self.reset(ekf.robot.nominal)

    def reset(self, q: FloatArray, v: FloatArray | None = None) -> None:
        """Start from (nq,) q [m, rad] and (nv,) v [m/s, rad/s], as `InvariantEkf.reset` does."""
        self.ekf.reset(q, v)
        self.detector.reset()
        self.fusion.reset()
        self.latency.reset()
        robot, ground = self.ekf.robot, self.ekf.ground
        soles = robot.foot_positions(q) - robot.contact_points.foot_radii[:, None] * [0.0, 0.0, 1.0]
        self.ground, self._stood = GroundLevel(ground, soles), np.zeros(len(robot.feet), dtype=bool)
        self._sensed = np.zeros_like(self._stood)
        self.health = Health.GOOD
        self.forces = np.zeros((len(self.ekf.robot.feet), 3))
        self._alone = self._unheard = 0.0
        self._first = True

    def predict(self, reading: Reading) -> BoolArray:
        """Go on to the time of a reading; return which feet bear a force: (n,). The first makes no step."""
        ekf, late, body = self.ekf, self.latency, self.ekf.filter
        sound = advance(body.memory, body.flags, ekf.memory, late.memory, late.counts, *reading, self._first)
        self._first = False
        if sound:
            self._sensed = self.detector.observe(ekf.q, ekf.v, ekf.normals)
            self.forces = self.detector.forces
        else:
            self.health = Health.DIVERGED
            self._sensed[:] = False
        return self._sensed.copy()

    def decide(self, sensed: BoolArray | None = None) -> BoolArray:
        """Return which feet touch, by force, height, speed and plan: (n,).

        Parameters
        ----------
        sensed
            (n,) which feet bear a force, where something other than `predict` has measured that; None for
            what it has found.
        """
        if self.health is Health.DIVERGED:
            return np.zeros_like(self._sensed)
        detector, heights = self.detector, self.ground.heights(self.detector.points)
        measured, fusion = self._sensed if sensed is None else sensed, self.fusion
        decide_contacts(
            detector.forces, detector.velocities, detector.points, self.ekf.normals, heights,
            self._sensed, measured, fusion.scales, fusion.memory, fusion.contact,
        )  # fmt: skip
        return fusion.contact.copy()

    def update(self, contact: BoolArray, standing: BoolArray | None = None) -> tuple[FloatArray, FloatArray]:
        """Correct and return the estimate q (nq,) [m, rad] and v (nv,) [m/s, rad/s], Pinocchio's order.

        Parameters
        ----------
        contact
            (n,) which feet touch, as `decide` has found or something better.
        standing
            (n,) which of them are meant to stand, by the plan; None for all.
        """
        ekf, late = self.ekf, self.latency
        meant = ekf.level(contact if standing is None else contact & standing)
        body, lost, q, v = ekf.filter, self.health is Health.DIVERGED, np.empty(self._nq), np.empty(self._nv)
        if ekf.ground is None:
            self._learn(contact & meant)
        found = settle(
            body.memory, body.flags, ekf.memory, ekf.feet.memory, ekf.stances, late.memory, late.counts,
            self._limits, contact, meant, lost, q, v,
        )  # fmt: skip
        if found & LANDED and ekf.ground is not None:
            ekf.land()
            sound = write_state(body.memory, ekf.memory, late.memory, late.counts, self._limits, body.n, q, v)
            found = found & ~CREDIBLE | (CREDIBLE if sound else 0)
        if not lost:
            self._look(found)
        return q, v

    def _learn(self, meant: BoolArray) -> None:
        """Learn where the ground is from feet (n,) that stand and did not before."""
        for k in np.flatnonzero(meant & ~self._stood).tolist():
            self.ground.stood(k, self.detector.points[k])
            self.ekf.normals[k] = self.ground.normal()
        self._stood = meant

    def expect(self, pushing: BoolArray, planned: BoolArray) -> None:
        """Take the plan for the next step: (n,) which feet push, and which should stand if they can."""
        self.fusion.expect(pushing, planned)

    def applied(self, torques: FloatArray) -> None:
        """Take the (joints,) torques from now to the next reading [N m]."""
        self.detector.applied(self.latency.torques(torques))

    def _look(self, found: int) -> None:
        """Judge the estimate after a correction by what `settle` has found."""
        watch, dt, touched = self.watch, self.ekf.dt, found & TOUCHED
        self._alone = 0.0 if found & BELIEVED else self._alone + dt
        self._unheard = 0.0 if touched else self._unheard + dt
        if touched and self._alone >= watch.doubt and self._alone < watch.doubt + dt:
            self.ekf.filter.doubt_velocity(watch.doubted)
        if self.health is not Health.GOOD:
            return
        if not found & CREDIBLE:
            self.health = Health.DIVERGED
        elif self._alone >= watch.patience:
            half = self._unheard >= 0.5 * self._alone
            self.health = Health.NO_CONTACT if half else Health.DIVERGED
