"""Sensor models: noise of the stated size, seeded, late, in steps; and the motion that an IMU means."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pinocchio
import pytest

from surefoot.base.errors import ProblemError
from surefoot.base.spatial import GRAVITY, rotation_from_quaternion
from surefoot.mechanics.robot import Robot
from surefoot.motion.estimation.inekf import STIFF_FEET, FilterNoise
from surefoot.worlds.running.sensor_kernels import mean_readings
from surefoot.worlds.running.sensors import (
    EncoderModel,
    ImuModel,
    SensorModel,
    Sensors,
    TouchModel,
)

DT = 0.001


def mean_motion(last: tuple, now: tuple, dt: float, arm: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return mean turn rate [rad/s] and specific force [m/s²] at an arm [m] between two states."""
    rate, force = np.empty(3), np.empty(3)
    mean_readings(*last, *now, dt, arm, rate, force)
    return rate, force


def test_mean_motion_integrates_back_to_the_motion(robot: Robot) -> None:
    """Turn rate and specific force of a tumbling flight, from a point off the base."""
    q, v, arm = robot.nominal.copy(), np.zeros(18), np.array([0.1, -0.2, 0.3])
    v[:6] = [0.5, -0.3, 0.2, 2.0, -1.0, 3.0]
    R = rotation_from_quaternion(q[3:7])
    speed = R @ (v[:3] + np.cross(v[3:6], arm))
    for _ in range(200):
        last = q, v
        a = np.array([0.3, -0.4, 0.5, 1.0, -2.0, 0.5])
        q = pinocchio.integrate(robot.model, q, DT * v)
        v = v + DT * np.r_[a, np.zeros(12)]
        rate, force = mean_motion(last, (q, v), DT, arm)
        half = pinocchio.exp3(0.5 * DT * rate)
        speed = speed + DT * (R @ half @ force - [0.0, 0.0, GRAVITY])
        R = R @ half @ half
    np.testing.assert_allclose(R, rotation_from_quaternion(q[3:7]), atol=1e-12)
    np.testing.assert_allclose(speed, R @ (v[:3] + np.cross(v[3:6], arm)), atol=1e-12)


def test_at_rest_an_imu_feels_its_weight(robot: Robot) -> None:
    sensors = Sensors(SensorModel().scaled(0.0), robot, DT)
    for _ in range(3):
        reading = sensors.read(robot.nominal, np.zeros(18))
    np.testing.assert_allclose(reading.accelerometer, [0.0, 0.0, GRAVITY], atol=0.0025)  # half a step
    np.testing.assert_allclose(reading.gyro, 0.0, atol=1e-12)
    np.testing.assert_allclose(reading.positions, robot.nominal[7:], atol=2e-4)


def test_noise_and_biases_have_their_size(robot: Robot) -> None:
    model = SensorModel(
        ImuModel(accelerometer_step=0.0, gyro_step=0.0, gyro_drift=0.0, accelerometer_drift=0.0),
        EncoderModel(step=0.0, speed_step=0.0),
    )
    sensors = Sensors(model, robot, DT, 3)
    rows = [sensors.read(robot.nominal, np.zeros(18)) for _ in range(4000)]
    gyro, force = (np.array([getattr(r, name) for r in rows]) for name in ("gyro", "accelerometer"))
    np.testing.assert_allclose(gyro.std(axis=0), 2.5e-4 / np.sqrt(DT), rtol=0.05)
    np.testing.assert_allclose(force.std(axis=0), 2e-3 / np.sqrt(DT), rtol=0.05)
    np.testing.assert_allclose(gyro.mean(axis=0), sensors.biases[0].copy(), atol=5e-4)
    angles, speeds = (np.array([getattr(r, name) for r in rows]) for name in ("positions", "speeds"))
    np.testing.assert_allclose(angles.std(axis=0), 2e-4, rtol=0.1)
    np.testing.assert_allclose(speeds.std(axis=0), 0.05, rtol=0.1)
    starts = [Sensors(model, robot, DT, k) for k in range(300)]
    assert np.std([s.biases[0].copy() for s in starts]) == pytest.approx(5e-3, rel=0.1)
    assert np.std([s.biases[1].copy() for s in starts]) == pytest.approx(0.05, rel=0.1)
    offsets = [s.read(robot.nominal, np.zeros(18)).positions - robot.nominal[7:] for s in starts]
    assert np.std(offsets) == pytest.approx(np.hypot(1e-3, 2e-4), rel=0.1)
    torques = np.array([s.torques(np.full(12, 10.0)) for s in starts])
    assert torques.std() == pytest.approx(np.hypot(0.3, starts[0]._torque_noise), rel=0.1)


def test_biases_walk(robot: Robot) -> None:
    model = SensorModel(ImuModel(gyro_bias=0.0, gyro_drift=0.01, accelerometer_bias=0.0))
    ends = []
    for seed in range(60):
        sensors = Sensors(model, robot, 0.01, seed)
        for _ in range(100):
            sensors.read(robot.nominal, np.zeros(18))
        ends.append(sensors.biases[0].copy())
    assert np.std(ends) == pytest.approx(0.01, rel=0.2)  # after one second


@pytest.mark.parametrize("level", [0.0, 1.0, 30.0])
def test_a_filter_believes_in_no_less_noise_than_there_is(level: float) -> None:
    """A filter that trusts a sensor more than it deserves drifts; and no belief falls below the default."""
    sensors, usual = SensorModel().scaled(level), replace(FilterNoise(), **STIFF_FEET)
    imu, encoders, belief = sensors.imu, sensors.encoders, sensors.filter_noise()
    there = {
        "gyro": imu.gyro_noise, "accelerometer": imu.accelerometer_noise,
        "gyro_drift": imu.gyro_drift, "accelerometer_drift": imu.accelerometer_drift,
        "joint": np.hypot(encoders.noise, encoders.step / np.sqrt(12.0)),
        "joint_speed": np.hypot(encoders.speed_noise, encoders.speed_step / np.sqrt(12.0)),
        "tilt": sensors.tilt, "gyro_bias": imu.gyro_bias, "accelerometer_bias": imu.accelerometer_bias,
    }  # fmt: skip
    for one in fields(usual):
        assert getattr(belief, one.name) >= max(getattr(usual, one.name), there.get(one.name, 0.0)), one.name
    if level == 0.0:
        assert belief == usual


def test_numbers_come_late_in_steps_and_within_range(robot: Robot) -> None:
    quiet = SensorModel().scaled(0.0)
    late = replace(quiet, encoders=replace(quiet.encoders, latency=0.003, step=0.01, speed_step=0.5))
    late = replace(late, imu=replace(late.imu, latency=0.0, accelerometer_range=20.0))
    sensors, q = Sensors(late, robot, DT), robot.nominal.copy()
    seen = []
    for k in range(6):
        q = q.copy()
        q[7] = 0.1 * k
        v = np.zeros(18)
        v[2], v[6] = 0.03 * k * k, 0.7
        seen.append(sensors.read(q, v))
    assert [round(r.positions[0], 9) for r in seen] == [0.0, 0.0, 0.0, 0.0, 0.1, 0.2]
    assert seen[-1].speeds[0] == 0.5
    assert max(r.accelerometer[2] for r in seen) == 20.0
    steps = seen[-1].positions / 0.01
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-9)


def test_touches_are_missed_and_invented(robot: Robot) -> None:
    sensors = Sensors(SensorModel(touch=TouchModel(missed=0.3, false=2.0, false_time=0.02)), robot, DT, 1)
    missed = np.zeros(4)
    for _ in range(200):  # contacts of 50 ms, 50 ms apart
        for _ in range(50):
            assert sensors.touches(np.zeros(4, dtype=bool)) is not None
        told = np.array([sensors.touches(np.ones(4, dtype=bool)) for _ in range(50)])
        missed += ~told[25:].all(axis=0)
    assert missed.mean() / 200 == pytest.approx(0.3 * np.exp(-2.0 * 0.025), abs=0.04)
    idle = np.array([sensors.touches(np.zeros(4, dtype=bool)) for _ in range(20000)])
    assert idle.mean() == pytest.approx(1.0 - np.exp(-2.0 * 0.02), rel=0.2)
    exact = Sensors(SensorModel(), robot, DT, 1)
    assert exact.touches(np.array([True, False, True, False])).tolist() == [True, False, True, False]


def test_a_start_is_tilted_and_runs_are_seeded(robot: Robot) -> None:
    q = robot.nominal
    tilts = []
    for seed in range(300):
        out = Sensors(SensorModel(), robot, DT, seed).attitude_at_start(q)
        turn = pinocchio.log3(rotation_from_quaternion(out[3:7]) @ rotation_from_quaternion(q[3:7]).T)
        assert turn[2] == pytest.approx(0.0, abs=1e-12)
        tilts.append(turn[:2])
    assert np.std(tilts) == pytest.approx(0.01, rel=0.1)
    pairs = [Sensors(SensorModel(), robot, DT, 5).read(q, np.zeros(18)) for _ in range(2)]
    for a, b in zip(*pairs, strict=True):
        np.testing.assert_array_equal(a, b)


@pytest.mark.parametrize(
    ("model", "message"),
    [
        (SensorModel(imu=ImuModel(gyro_noise=-1.0)), "gyro noise must be"),
        (SensorModel(encoders=EncoderModel(latency=2.0)), "latency must be"),
        (SensorModel(touch=TouchModel(missed=1.5)), "missed must be"),
        (SensorModel(imu=ImuModel(gyro_range=0.0)), "ranges of an IMU must be positive"),
    ],
)
def test_sensors_that_cannot_be_are_refused(robot: Robot, model: SensorModel, message: str) -> None:
    with pytest.raises(ProblemError, match=message):
        Sensors(model, robot, DT)


def test_a_level_scales_what_is_wrong_and_nothing_else() -> None:
    twice, usual = SensorModel().scaled(2.0), SensorModel()
    assert twice.imu.gyro_noise == 2.0 * usual.imu.gyro_noise
    assert twice.imu.gyro_drift == 2.0 * usual.imu.gyro_drift
    assert twice.encoders.bias == 2.0 * usual.encoders.bias
    assert twice.encoders.step == usual.encoders.step
    assert twice.imu.latency == usual.imu.latency
    assert twice.filter_noise().gyro >= usual.filter_noise().gyro
    with pytest.raises(ProblemError, match="level must be"):
        usual.scaled(-1.0)
