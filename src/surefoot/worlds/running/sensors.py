"""What an ordinary IMU, encoders and a touch detector make of a robot's true motion."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, real_number
from surefoot.base.errors import ProblemError
from surefoot.base.memory import Remembering
from surefoot.base.spatial import GRAVITY, quaternion_from_rotation, rotation_exp, rotation_from_quaternion
from surefoot.mechanics import Robot
from surefoot.motion import STIFF_FEET, FilterNoise, Reading
from surefoot.worlds.running.sensor_kernels import sense


@dataclass(frozen=True)
class ImuModel:
    """An IMU; the defaults are a MEMS part of the BMI088's class after calibration.

    Attributes
    ----------
    gyro_noise, accelerometer_noise
        White noise [rad/s/√Hz], [m/s²/√Hz].
    gyro_bias, accelerometer_bias
        Standard deviation of the biases when it is switched on [rad/s], [m/s²].
    gyro_drift, accelerometer_drift
        Random walk of the biases [rad/s²/√Hz], [m/s³/√Hz].
    gyro_step, accelerometer_step
        Quantisation [rad/s], [m/s²]: 16 bits of the ranges.
    gyro_range, accelerometer_range
        Largest values [rad/s], [m/s²]: 2000 °/s, 16 g.
    latency
        From motion to number [s].
    position
        (x, y, z) from the base's origin, base axes [m]; its axes are the base's.
    """

    gyro_noise: float = 2.5e-4
    accelerometer_noise: float = 2e-3
    gyro_bias: float = 5e-3
    accelerometer_bias: float = 0.05
    gyro_drift: float = 2e-5
    accelerometer_drift: float = 2e-4
    gyro_step: float = 1.07e-3
    accelerometer_step: float = 4.8e-3
    gyro_range: float = 34.9
    accelerometer_range: float = 157.0
    latency: float = 0.001
    position: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class EncoderModel:
    """Encoders of the joints; the defaults are 14 bits at the joint, read over a bus at 1 kHz.

    Attributes
    ----------
    noise
        White noise of an angle in every sample [rad].
    bias
        Standard deviation of the offset of each joint's zero [rad].
    step
        Quantisation [rad].
    speed_noise, speed_step
        White noise and quantisation of a speed, as motor drives give it [rad/s].
    latency
        From motion to number [s].
    """

    noise: float = 2e-4
    bias: float = 1e-3
    step: float = 3.8e-4
    speed_noise: float = 0.05
    speed_step: float = 0.01
    latency: float = 0.001


@dataclass(frozen=True)
class TouchModel:
    """What goes wrong with the forces that tell contacts, beyond what the observer of momentum gets wrong.

    Attributes
    ----------
    torque_noise
        White noise of a torque as the detector hears it, as a share of m g times the height of the base over
        the number of joints: what a joint's torque is like while the robot stands.
    torque_scale
        Standard deviation of each motor's factor between torque and current, off 1.
    missed
        Share of the contacts whose force is never sensed.
    false
        How often a foot feels a force that is none, for `false_time` [1/s].
    false_time
        Length of such a false force [s].
    """

    torque_noise: float = 0.05
    torque_scale: float = 0.03
    missed: float = 0.0
    false: float = 0.0
    false_time: float = 0.02


@dataclass(frozen=True)
class SensorModel:
    """The sensors of a robot and what it knows at the start; the defaults are those of an ordinary one.

    Attributes
    ----------
    imu, encoders, touch
        See there.
    tilt
        Standard deviation of the attitude's error at the start about each level axis [rad].
    heights
        Whether a map tells the height of the ground where a foot lands.
    """

    imu: ImuModel = field(default_factory=ImuModel)
    encoders: EncoderModel = field(default_factory=EncoderModel)
    touch: TouchModel = field(default_factory=TouchModel)
    tilt: float = 0.01
    heights: bool = True

    def scaled(self, level: float) -> SensorModel:
        """Return sensors whose noise, biases and drifts are as large as before times the ratio `level`.

        Raises
        ------
        ProblemError
            For a level that is negative or not finite.
        """
        level = real_number("level", level, low=0.0, high=1e3)
        grown = ("noise", "bias", "drift", "torque_scale")

        def larger(part: Any) -> Any:
            names = [f.name for f in fields(part) if f.name.endswith(grown)]
            return replace(part, **{name: level * getattr(part, name) for name in names})

        parts = larger(self.imu), larger(self.encoders), larger(self.touch)
        return replace(self, imu=parts[0], encoders=parts[1], touch=parts[2], tilt=level * self.tilt)

    def filter_noise(self) -> FilterNoise:
        """Return what a filter should believe about these sensors, never less than its defaults, and feet."""
        usual, imu = replace(FilterNoise(), **STIFF_FEET), self.imu
        own = FilterNoise(
            **STIFF_FEET,
            gyro=5.0 * imu.gyro_noise,
            accelerometer=5.0 * imu.accelerometer_noise,
            gyro_drift=imu.gyro_drift,
            accelerometer_drift=imu.accelerometer_drift,
            joint=self.encoders.noise + self.encoders.step,
            joint_speed=self.encoders.speed_noise + self.encoders.speed_step,
            tilt=2.0 * self.tilt,
            gyro_bias=2.0 * imu.gyro_bias,
            accelerometer_bias=2.0 * imu.accelerometer_bias,
        )
        return replace(
            usual, **{f.name: max(getattr(usual, f.name), getattr(own, f.name)) for f in fields(usual)}
        )

    def check(self) -> None:
        """Raise `ProblemError` for a number that no sensor has."""
        for part in (self.imu, self.encoders, self.touch):
            for one in fields(part):
                value = getattr(part, one.name)
                if one.name == "position":
                    for axis in value:
                        real_number("position of the IMU", axis, low=-10.0, high=10.0)
                elif one.name == "latency":
                    real_number("latency", value, low=0.0, high=0.1)
                else:
                    real_number(one.name.replace("_", " "), value, low=0.0)
        real_number("missed", self.touch.missed, high=1.0)
        if self.imu.gyro_range <= 0.0 or self.imu.accelerometer_range <= 0.0:
            raise ProblemError("the ranges of an IMU must be positive")


class Sensors(Remembering):
    """The sensors of one run; made new for each.

    Parameters
    ----------
    model
        What they are like.
    robot
        Whose they are.
    dt
        Time between readings [s].
    seed
        Of all their random numbers; None for 0.

    Raises
    ------
    ProblemError
        For a model with numbers that no sensor has.
    """

    MEMORY = (
        "_random", "_memory", "_imu", "_legs", "_motion", "_first", "_touched", "_hidden", "_false_until",
        "_time", "_factors",
    )  # fmt: skip

    def __init__(self, model: SensorModel, robot: Robot, dt: float, seed: int | None = None) -> None:
        model.check()
        self.model, self.robot, self.dt = model, robot, dt
        self._random = r = np.random.default_rng([0 if seed is None else seed, 2])
        imu, encoders, touch = model.imu, model.encoders, model.touch
        biases = imu.gyro_bias * r.normal(size=3), imu.accelerometer_bias * r.normal(size=3)
        root, joints = np.sqrt(dt), robot.joints
        drifts = root * imu.gyro_drift, root * imu.accelerometer_drift
        offsets = encoders.bias * r.normal(size=joints)
        self._memory = np.concatenate([
            *biases, imu.position, drifts, (imu.gyro_noise / root, imu.accelerometer_noise / root),
            (imu.gyro_step, imu.accelerometer_step), (imu.gyro_range, imu.accelerometer_range),
            (encoders.noise, encoders.step, encoders.speed_noise, encoders.speed_step, dt),
            offsets, np.zeros(joints),
        ])  # fmt: skip
        self._normal = r.standard_normal
        self._factors = 1.0 + touch.torque_scale * r.normal(size=joints)
        usual = robot.mass * GRAVITY * max(float(robot.nominal[2]), 0.0) / max(joints, 1)
        self._torque_noise = touch.torque_noise * usual
        late = round(imu.latency / dt), round(encoders.latency / dt)
        self._imu: deque[FloatArray] = deque(maxlen=1 + late[0])
        self._legs: deque[FloatArray] = deque(maxlen=1 + late[1])
        self._motion, self._first, self._joints = np.zeros(13), True, joints
        n = len(robot.feet)
        self._touched, self._hidden = np.zeros(n, dtype=bool), np.zeros(n, dtype=bool)
        self._false_until = np.zeros(n)
        self._time = 0.0

    @property
    def biases(self) -> FloatArray:
        """(2, 3) biases of gyro [rad/s] and accelerometer [m/s²] now."""
        return self._memory[:6].reshape(2, 3)

    def attitude_at_start(self, q: FloatArray) -> FloatArray:
        """Return (nq,) q [m, rad] with its attitude as wrong as the robot has it at the start."""
        turn, out = np.append(self.model.tilt * self._normal(2), 0.0), q.copy()
        out[3:7] = quaternion_from_rotation(rotation_exp(turn) @ rotation_from_quaternion(q[3:7]))
        return out

    def read(self, q: FloatArray, v: FloatArray) -> Reading:
        """Return what the sensors say at the next step, from the true (nq,) q and (nv,) v."""
        joints, row = self._joints, np.empty(6 + 2 * self._joints)
        sense(self._memory, self._motion, q, v, self._normal(12 + 2 * joints), self._first, row)
        self._first = False
        self._imu.append(row)
        self._legs.append(row)
        imu, legs = self._imu[0], self._legs[0]
        return Reading(imu[:3], imu[3:6], legs[6 : 6 + joints], legs[6 + joints :])

    def torques(self, true: FloatArray) -> FloatArray:
        """Return (joints,) torques as the motors' currents tell them [N m]."""
        return np.asarray(self._factors * true + self._torque_noise * self._normal(self._joints))

    def touches(self, contact: BoolArray) -> BoolArray:
        """Return (n,) which feet feel a force, some missed and some false, one step after the last call."""
        touch, n = self.model.touch, len(contact)
        self._time += self.dt
        if touch.missed > 0.0:
            fresh = contact & ~self._touched
            self._hidden = np.where(fresh, self._random.random(n) < touch.missed, self._hidden)
        if touch.false > 0.0:
            starts = self._random.random(n) < touch.false * self.dt
            self._false_until = np.where(starts, self._time + touch.false_time, self._false_until)
        self._touched = contact.copy()
        return np.asarray((contact & ~self._hidden) | (self._false_until > self._time))
