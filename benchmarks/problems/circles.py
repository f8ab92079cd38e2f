"""Made-up logs of a robot on four feet that walks a circle, with an IMU and encoders; the truth is known.

Kinematics alone: the body follows a circle at a trot, feet stand on a level floor and roll on their balls,
legs follow by their geometry. Every sensor and every foot is as noisy as a `FilterNoise` says, so that a
filter that believes the same numbers must be consistent. Faults are put in by `spoilt_circle`.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.transform import Rotation

import surefoot as sf
from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.spatial import GRAVITY
from surefoot.motion.estimation.inekf import FilterNoise

RATE, PERIOD, SWING, LIFT = 400.0, 0.5, 0.22, 0.06
"""Of the sensors [Hz]; of the trot and of a swing [s]; apex of a swing [m]."""
REST = 1.5
"""Rest before and after the walk [s]."""
SINKING = 0.05
"""Time in which a soft sole gives way by 63 % [s]."""
QUIET = FilterNoise(
    gyro=5e-4, accelerometer=5e-3, gyro_drift=2e-5, accelerometer_drift=2e-4, foot=2e-4, landing=2e-3,
    joint=3e-4, joint_speed=0.05, velocity=0.0, tilt=0.005, gyro_bias=0.003, accelerometer_bias=0.03,
    height=5e-3, turning=5e-3, slip=0.0, impact=0.0,
)  # fmt: skip
"""What the sensors and the feet of a circle are like."""


@dataclass
class CircleLog:
    """Readings row by row, and the truth behind them.

    Attributes
    ----------
    gyro, accelerometer
        (T, 3) [rad/s], [m/s²].
    joints, speeds
        (T, 12) [rad], [rad/s].
    contact
        (T, 4) which feet stand.
    q
        (T, 19) the truth, Pinocchio's order.
    bias
        (T, 6) of gyro and accelerometer.
    feet
        (T, 4, 3) the feet's centres [m].
    height
        By which the floor lies lower than a map has it [m].
    """

    gyro: FloatArray
    accelerometer: FloatArray
    joints: FloatArray
    speeds: FloatArray
    contact: BoolArray
    q: FloatArray
    bias: FloatArray
    feet: FloatArray
    height: float = 0.0
    dt: float = field(default=1.0 / RATE)


class Leg:
    """Geometry of a robot's four legs of hip, thigh and calf."""

    def __init__(self, robot: sf.Robot) -> None:
        model = robot.model
        places = [model.jointPlacements[i].translation for i in range(2, 14)]
        self.hips = np.array(places[0::3])
        self.side = np.array([p[1] for p in places[1::3]])
        q = robot.nominal.copy()
        q[:3], q[3:7], q[7:] = 0.0, [0.0, 0.0, 0.0, 1.0], 0.0
        down = robot.foot_positions(q) - self.hips
        self.thigh = -float(places[2][2])
        self.calf = -float(down[0, 2]) - self.thigh

    def angles(self, feet: FloatArray) -> FloatArray:
        """Return the (T, 4, 3) angles of feet (T, 4, 3) in base axes."""
        x, y, z = np.moveaxis(feet - self.hips, -1, 0)
        depth = -np.sqrt(np.maximum(y**2 + z**2 - self.side**2, 1e-6))
        hip = np.arctan2(z, y) - np.arctan2(depth, self.side)
        hip = (hip + np.pi) % (2.0 * np.pi) - np.pi
        a, b = self.thigh, self.calf
        knee = -np.arccos(np.clip((x**2 + depth**2 - a**2 - b**2) / (2.0 * a * b), -1.0, 1.0))
        thigh = np.arctan2(-x, -depth) - np.arctan2(b * np.sin(knee), a + b * np.cos(knee))
        return np.stack([hip, thigh, knee], axis=-1)


def random_circle(
    robot: sf.Robot, seed: int, noise: FilterNoise = QUIET, *, radius: float = 1.0, speed: float = 0.5,
    slides: float = 0.0, sinks: float = 0.0,
) -> CircleLog:  # fmt: skip
    """Return the log of a walk once around a circle [m] at a speed [m/s], with rest before and after.

    From its middle on the first foot `slides` forwards in every stance [m/s], and all feet sink by `sinks`
    [m] where they stand.
    """
    random, dt = np.random.default_rng(seed), 1.0 / RATE
    walked = 2.0 * np.pi * radius / speed + 1.0
    T = round((walked + 2.0 * REST) / dt)
    time = dt * np.arange(T)
    along = np.clip(time - REST, 0.0, walked)
    pace = np.clip(np.minimum(along, walked - along), 0.0, 1.0)  # a second to begin, and one to end
    way = np.cumsum(speed * pace * pace * (3.0 - 2.0 * pace)) * dt
    way *= 2.0 * np.pi * radius / way[-1]
    heading, bob = way / radius, pace * np.sin(4.0 * np.pi * along / PERIOD)
    height = float(robot.nominal[2])
    place: FloatArray = np.stack(
        [radius * np.sin(heading), radius * (1.0 - np.cos(heading)), height + 0.004 * bob], axis=1
    )
    tilt = np.stack([heading, 0.02 * pace * np.sin(2.0 * np.pi * along / PERIOD), 0.01 * bob], axis=1)
    turn = Rotation.from_euler("ZYX", tilt)
    contact, feet = _footholds(robot, np.asarray(time, dtype=np.float64), place, heading, walked)
    fault = _moved(contact, slides, sinks, heading, dt)
    wander = fault + _wander(random, contact, noise, np.gradient(heading, dt), dt)
    leg, rolled = Leg(robot), np.zeros_like(feet)
    for _ in range(3):
        centres = feet + np.where(contact[:, :, None], wander + rolled, 0.0)
        angles = leg.angles(_in_body(turn, place, centres))
        rolled = _rolled(robot, turn, angles, contact)
    q = np.concatenate([place, turn.as_quat(), angles.reshape(T, 12)], axis=1)
    bias = np.concatenate(
        [_bias(random, T, noise.gyro_bias, noise.gyro_drift, dt),
         _bias(random, T, noise.accelerometer_bias, noise.accelerometer_drift, dt)], axis=1,
    )  # fmt: skip
    gyro, force = _imu(turn, place, dt)
    gyro = gyro + bias[:, :3] + random.normal(0.0, noise.gyro * np.sqrt(RATE), (T, 3))
    force = force + bias[:, 3:] + random.normal(0.0, noise.accelerometer * np.sqrt(RATE), (T, 3))
    joints = q[:, 7:] + random.normal(0.0, noise.joint, (T, 12))
    return CircleLog(gyro, force, joints, np.gradient(q[:, 7:], dt, axis=0), contact, q, bias, centres)


def _in_body(turn: Rotation, place: FloatArray, points: FloatArray) -> FloatArray:
    return np.asarray(np.einsum("tji,tkj->tki", turn.as_matrix(), points - place[:, None]))


def _footholds(
    robot: sf.Robot, time: FloatArray, place: FloatArray, heading: FloatArray, walked: float
) -> tuple[BoolArray, FloatArray]:
    """Return which feet (T, 4) stand, and the places (T, 4, 3) of their centres."""
    dt, T = time[1] - time[0], len(time)
    stance = robot.foot_positions(robot.nominal) - [*robot.nominal[:2], 0.0]
    contact, feet = np.ones((T, 4), dtype=bool), np.empty((T, 4, 3))

    def under(k: int, row: int) -> FloatArray:
        row = min(max(row, 0), T - 1)
        c, s = np.cos(heading[row]), np.sin(heading[row])
        x, y, z = stance[k]
        return np.array([place[row, 0] + c * x - s * y, place[row, 1] + s * x + c * y, z])

    for k in range(4):
        here, row = under(k, 0), 0
        begin = REST + (0.0 if k in (0, 3) else 0.5 * PERIOD)
        while begin + SWING < REST + walked:
            up, down = round(begin / dt), round((begin + SWING) / dt)
            last = begin + PERIOD + SWING >= REST + walked
            there = under(k, T - 1 if last else down + round(0.5 * (PERIOD - SWING) / dt))
            feet[row:up, k] = here
            s = np.linspace(0.0, 1.0, down - up, endpoint=False)
            smooth = s * s * s * (10.0 - 15.0 * s + 6.0 * s * s)
            feet[up:down, k] = here + smooth[:, None] * (there - here)
            feet[up:down, k, 2] += LIFT * (64.0 * (s * (1.0 - s)) ** 3)
            contact[up:down, k] = False
            here, row, begin = there, down, begin + PERIOD
        feet[row:, k] = here
    return contact, feet


def _moved(contact: BoolArray, slides: float, sinks: float, heading: FloatArray, dt: float) -> FloatArray:
    """Return how far (T, 4, 3) feet have been moved by a fault since they landed."""
    out, begin = np.zeros((*contact.shape, 3)), len(contact) // 2
    for t in range(begin, len(contact)):
        held = contact[t] & contact[t - 1] & (contact[t - 1] if t > begin else True)
        out[t] = np.where(held[:, None], out[t - 1], 0.0)
        out[t, 0, :2] += slides * dt * np.array([np.cos(heading[t]), np.sin(heading[t])]) * held[0]
        out[t, :, 2] -= (sinks + out[t, :, 2]) * dt / SINKING * held
    return out


def _wander(
    random: np.random.Generator, contact: BoolArray, noise: FilterNoise, rate: FloatArray, dt: float
) -> FloatArray:
    """Return how far (T, 4, 3) standing feet have crept since they landed."""
    landed = np.zeros(contact.shape)
    for t in range(1, len(contact)):
        landed[t] = np.where(
            contact[t], np.where(contact[t - 1], np.maximum(landed[t - 1] - dt, 0.0), 0.02), 0
        )
    density = np.where(landed > 0.0, noise.landing, noise.foot) ** 2 + (noise.turning * rate[:, None]) ** 2
    steps = random.normal(size=(*contact.shape, 3)) * np.sqrt(density * dt)[:, :, None]
    out = np.zeros_like(steps)
    for t in range(1, len(contact)):
        out[t] = np.where((contact[t] & contact[t - 1])[:, None], out[t - 1] + steps[t], 0.0)
    return out


def _rolled(robot: sf.Robot, turn: Rotation, angles: FloatArray, contact: BoolArray) -> FloatArray:
    """Return how far (T, 4, 3) the centres of standing feet have rolled since they landed."""
    radius, out = float(robot.contact_points.foot_radii[0]), np.zeros((*contact.shape, 3))
    for k in range(4):
        hip, pitch = angles[:, k, 0], angles[:, k, 1] + angles[:, k, 2]
        calf = turn * Rotation.from_euler("XY", np.stack([hip, pitch], axis=1))
        turned = (calf[1:] * calf[:-1].inv()).as_rotvec()
        moved = radius * np.cross(turned, [0.0, 0.0, 1.0])
        for t in range(1, len(contact)):
            if contact[t, k] and contact[t - 1, k]:
                out[t, k] = out[t - 1, k] + moved[t - 1]
    return out


def _bias(random: np.random.Generator, T: int, start: float, drift: float, dt: float) -> FloatArray:
    walk = random.normal(0.0, drift * np.sqrt(dt), (T, 3))
    return np.asarray(random.normal(0.0, start, 3) + np.cumsum(walk, axis=0))


def _imu(turn: Rotation, place: FloatArray, dt: float) -> tuple[FloatArray, FloatArray]:
    """Return mean turn rates and specific forces (T, 3) since the row before, base axes."""
    R, v = turn.as_matrix(), np.gradient(place, dt, axis=0)
    gyro, force = np.zeros((len(R), 3)), np.zeros((len(R), 3))
    gyro[1:] = (turn[:-1].inv() * turn[1:]).as_rotvec() / dt
    middle = (turn[:-1] * Rotation.from_rotvec(0.5 * dt * gyro[1:])).inv()
    force[1:] = middle.apply(np.diff(v, axis=0) / dt + [0.0, 0.0, GRAVITY])
    gyro[0], force[0] = gyro[1], R[0].T @ [0.0, 0.0, GRAVITY]
    return gyro, force


FAULTS = (
    "gyro bias jumps", "accelerometer bias jumps", "one foot slides", "map 0.2 m off", "soft soles",
    "knee's zero off", "encoder stuck", "gyro's scale off", "IMU late", "false contact",
)  # fmt: skip
"""Faults that `spoilt_circle` puts in."""


def spoilt_circle(robot: sf.Robot, seed: int, fault: str) -> CircleLog:
    """Return a circle with one fault, from its middle on or throughout."""
    log = random_circle(
        robot, seed, slides=0.3 if fault == "one foot slides" else 0.0,
        sinks=0.015 if fault == "soft soles" else 0.0,
    )  # fmt: skip
    half, random = len(log.q) // 2, np.random.default_rng(seed + 1000)
    axis = random.integers(3)
    if fault == "gyro bias jumps":
        log.gyro[half:, axis] += 0.1
    elif fault == "accelerometer bias jumps":
        log.accelerometer[half:, axis] += 1.0
    elif fault == "map 0.2 m off":
        log.height = 0.2
    elif fault == "knee's zero off":
        log.joints[half:, 3 * random.integers(4) + 2] += 0.1
    elif fault == "encoder stuck":
        joint = 3 * random.integers(4) + 1 + random.integers(2)
        log.joints[half:, joint] = log.joints[half, joint]
    elif fault == "gyro's scale off":
        log.gyro *= 1.3
    elif fault == "IMU late":
        log.gyro[40:], log.accelerometer[40:] = log.gyro[:-40].copy(), log.accelerometer[:-40].copy()
    elif fault == "false contact":
        log.contact[half:, random.integers(4)] = True
    return log


def estimate_circle(
    robot: sf.Robot, log: CircleLog, noise: FilterNoise = QUIET, *, mapped: bool = False
) -> tuple[sf.InvariantEkf, list[str]]:
    """Return the filter at the end of a circle, from a start with the noise's tilt, and all its doubts."""
    ekf = sf.InvariantEkf(robot, log.dt, noise, sf.FlatTerrain() if mapped else None)
    begin = log.q[0].copy()
    begin[2] += log.height
    tilted = Rotation.from_rotvec([*np.random.default_rng(len(log.q)).normal(0.0, noise.tilt, 2), 0.0])
    begin[3:7] = (tilted * Rotation.from_quat(begin[3:7])).as_quat()
    ekf.reset(begin)
    doubts: list[str] = []
    for t in range(len(log.q)):
        if t:
            ekf.predict(log.gyro[t], log.accelerometer[t])
        ekf.update(log.joints[t], log.speeds[t], log.contact[t])
        if not ekf.trust.good and ekf.trust.reason not in doubts:
            doubts.append(ekf.trust.reason)
    return ekf, doubts


def end_error(ekf: sf.InvariantEkf, log: CircleLog) -> tuple[FloatArray, FloatArray]:
    """Return the errors (12,) of turn, place and biases at the end, and their covariance (12, 12)."""
    body, n = ekf.filter, 15 + 3 * ekf.filter.n
    off = body.rotation @ Rotation.from_quat(log.q[-1, 3:7]).as_matrix().T
    place = body.position - off @ log.q[-1, :3]
    parts = np.r_[0:3, 6:9, n - 6 : n]
    error = np.concatenate([Rotation.from_matrix(off).as_rotvec(), place, body.bias - log.bias[-1]])
    return error, body.covariance[np.ix_(parts, parts)]
