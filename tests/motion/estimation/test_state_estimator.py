"""The state estimate of a robot from its sensors: on logged motions, and when it fails."""

from __future__ import annotations

from copy import deepcopy
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import surefoot as sf
from surefoot.base.errors import ProblemError
from surefoot.base.spatial import GRAVITY, rotation_from_quaternion
from surefoot.mechanics.robot import Robot
from surefoot.mechanics.terrain import FlatTerrain
from surefoot.motion.control.controller import Command
from surefoot.motion.drive.state_tracker import StateTracker
from surefoot.motion.estimation.contact_fusion import TouchSettings
from surefoot.motion.estimation.inekf_robot import InvariantEkf
from surefoot.motion.estimation.state_estimator import Health, Reading, StateEstimator, WatchSettings
from surefoot.records.audit.summary.estimate_summary import EstimateErrors, estimate_errors
from surefoot.records.log import Log
from surefoot.worlds.running.sensors import SensorModel, Sensors
from tests.records.audit.logs import TROT, log_of

REST = np.array([0.0, 0.0, GRAVITY])


def replayed(robot: Robot, log: Log, model: SensorModel, seed: int) -> tuple[StateEstimator, EstimateErrors]:
    """Return an estimator that has seen a log through sensors, and its errors."""
    dt, sensors = log.fact("dt"), Sensors(model, robot, log.fact("dt"), seed)
    ground = FlatTerrain() if model.heights else None
    late = model.imu.latency, model.encoders.latency
    ekf = InvariantEkf(robot, dt, model.filter_noise(), ground, model.imu.position)
    estimator = StateEstimator(ekf, latency=late)
    estimator.reset(sensors.attitude_at_start(log["q"][0]))
    told, standing = [], None
    for q, v, torques, active in zip(log["q"], log["v"], log["torques"], log["active"], strict=True):
        touching = estimator.decide(sensors.touches(estimator.predict(sensors.read(q, v))))
        told.append(estimator.update(touching, standing))
        estimator.expect(active, active)
        estimator.applied(sensors.torques(torques))
        standing = active
    q, v = (np.array(part) for part in zip(*told, strict=True))
    seen = Log({"time": log["time"], "q": log["q"], "v": log["v"], "q_estimated": q, "v_estimated": v})
    return estimator, estimate_errors(seen)


def test_a_copy_goes_its_own_way(robot: Robot) -> None:
    log, sensors = log_of(TROT), Sensors(SensorModel(), robot, 1e-3, 3)
    one = StateEstimator(InvariantEkf(robot, 1e-3, ground=FlatTerrain()), latency=(1e-3, 2e-3))
    one.reset(log["q"][0])
    told: list[list[np.ndarray]] = []
    readings = [sensors.read(q, v) for q, v in zip(log["q"][:60], log["v"], strict=False)]
    for k in range(60):
        if k == 30:
            other = deepcopy(one)
            for estimator in (one, other):  # the copy after the end of the first
                told.append([])
                for reading in readings[30:]:
                    touching = estimator.decide(estimator.predict(reading))
                    told[-1] += [*estimator.update(touching), touching, estimator.forces.copy()]
                    estimator.applied(np.ones(12))
            break
        one.update(one.decide(one.predict(readings[k])))
        one.applied(np.ones(12))
    assert one.ekf.filter.memory is not other.ekf.filter.memory
    for a, b in zip(*told, strict=True):
        np.testing.assert_array_equal(a, b)


@pytest.mark.parametrize("seed", range(3))
def test_a_trot_is_followed_within_centimetres_a_second(robot: Robot, seed: int) -> None:
    estimator, errors = replayed(robot, log_of(TROT), SensorModel(), seed)
    assert estimator.health is Health.GOOD
    assert errors.velocity_rms < 0.01
    assert errors.drift < 0.005  # of 0.4 m; whole walks are in tests/worlds/running/test_estimated_walks.py
    assert errors.tilt_rms_deg < 0.5


def test_perfect_sensors_leave_what_the_ground_gives_way(robot: Robot) -> None:
    model = SensorModel().scaled(0.0)
    quick = replace(model, imu=replace(model.imu, latency=0.0), encoders=replace(model.encoders, latency=0.0))
    _, errors = replayed(robot, log_of(TROT), quick, 0)
    assert errors.velocity_rms < 0.002
    assert errors.drift < 0.003


def test_an_imu_off_the_base_tells_the_same(robot: Robot) -> None:
    model = SensorModel()
    off = replace(model, imu=replace(model.imu, position=(-0.1, 0.05, 0.1)))
    errors = [replayed(robot, log_of(TROT), one, 1)[1] for one in (model, off)]
    assert errors[1].velocity_rms < 1.5 * errors[0].velocity_rms
    assert errors[1].drift < 0.02


def test_missed_and_false_touches_do_little(robot: Robot) -> None:
    model = SensorModel()
    worse = replace(model, touch=replace(model.touch, missed=0.1, false=3.0))
    estimator, errors = replayed(robot, log_of(TROT), worse, 2)
    assert estimator.health is Health.GOOD
    assert errors.velocity_rms < 0.02


def test_late_readings_are_those_of_one_time_and_the_state_that_of_now(robot: Robot) -> None:
    """A body that turns, rises and swings its joints ever faster, seen 3 and 5 ms late."""
    imu, legs, h = 0.003, 0.005, 0.001
    estimator = StateEstimator(InvariantEkf(robot, h), latency=(imu, legs))
    start, spin, lift, rate = robot.nominal, 0.8, 1.5, 20.0
    estimator.reset(start)

    def joints(t: float) -> tuple[np.ndarray, np.ndarray]:
        return start[7:] + 0.5 * rate * t * t, np.full(12, rate * t)

    def yaw(t: float) -> float:
        return 0.5 * spin * t * t

    for k in range(61):
        now = k * h
        at = max(now - imu, 0.0)
        turn = (yaw(at) - yaw(max(at - h, 0.0))) / h
        rising = lift if now > imu else 0.0
        positions, speeds = joints(max(now - legs, 0.0))
        estimator.predict(
            Reading(np.array([0.0, 0.0, turn]), REST + np.array([0.0, 0.0, rising]), positions, speeds)
        )
        q, v = estimator.update(np.zeros(4, dtype=bool))
        estimator.applied(np.zeros(12))
    t = now
    np.testing.assert_allclose(q[7:], joints(t)[0], atol=1e-9)
    np.testing.assert_allclose(v[6:], joints(t)[1], atol=1e-9)
    assert q[2] - start[2] == pytest.approx(0.5 * lift * t * t, abs=1e-6)
    assert v[2] == pytest.approx(lift * t, abs=1e-6)
    R = rotation_from_quaternion(q[3:7])
    assert np.arctan2(R[1, 0], R[0, 0]) == pytest.approx(yaw(t), abs=spin * imu * h * 4)
    with pytest.raises(ProblemError, match="latency of the IMU"):
        StateEstimator(InvariantEkf(robot, h), latency=(-0.1, 0.0))


def test_a_foot_that_moves_over_the_ground_is_not_used(robot: Robot) -> None:
    ekf = InvariantEkf(robot, 0.001)
    ekf.reset(robot.nominal)
    speeds, everyone = np.zeros(12), [True] * 4
    speeds[1] = 5.0  # a thigh: its foot moves at more than a metre a second
    for _ in range(3):
        ekf.predict(np.zeros(3), REST)
        used = ekf.update(robot.nominal[7:], speeds, everyone)
    assert used.tolist() == [False, True, True, True]


def feed(estimator: StateEstimator, reading: Reading, feet: np.ndarray) -> None:
    estimator.predict(reading)
    estimator.update(feet)
    estimator.applied(np.zeros(12))


def test_without_contact_it_is_lost_and_says_so(robot: Robot) -> None:
    estimator = StateEstimator(InvariantEkf(robot, 0.001))
    reading = Reading(np.zeros(3), REST, robot.nominal[7:], np.zeros(12))
    none = np.zeros(4, dtype=bool)
    for k in range(305):
        assert estimator.health is Health.GOOD or k >= 299
        feed(estimator, reading, none)
    assert estimator.health is Health.NO_CONTACT
    estimator.reset(robot.nominal)
    assert estimator.health is Health.GOOD


def test_what_feet_contradict_is_diverged(robot: Robot) -> None:
    """Feet that touch and go somewhere, each elsewhere, while the joints' speeds say that they rest."""
    estimator = StateEstimator(InvariantEkf(robot, 0.001), watch=WatchSettings(doubt=1.0))
    everyone, angles = np.ones(4, dtype=bool), robot.nominal[7:].copy()
    creep = 0.02 * np.random.default_rng(12).normal(size=12)
    for _ in range(600):
        reading = Reading(np.zeros(3), REST, angles.copy(), np.zeros(12))
        feed(estimator, reading, everyone)
        angles += creep
    assert estimator.health is Health.DIVERGED


def test_a_broken_accelerometer_is_found(robot: Robot) -> None:
    estimator, everyone = StateEstimator(InvariantEkf(robot, 0.001)), np.ones(4, dtype=bool)
    reading = Reading(np.zeros(3), 0.6 * REST, robot.nominal[7:], np.zeros(12))
    for _ in range(2000):
        feed(estimator, reading, everyone)
    assert estimator.health is Health.DIVERGED
    estimator.reset(robot.nominal)
    estimator.predict(reading._replace(gyro=np.full(3, np.nan)))
    estimator.update(everyone)
    estimator.predict(reading._replace(gyro=np.full(3, np.nan)))
    assert estimator.health is Health.DIVERGED


def test_start_and_wrong_input(robot: Robot) -> None:
    random = np.random.default_rng(0)
    q = robot.nominal.copy()
    q[3:7] = np.array([0.1, -0.2, 0.3, 0.9]) / np.sqrt(0.95)
    v = random.normal(size=18)
    ekf = InvariantEkf(robot, 0.001, imu_position=(0.1, 0.2, 0.3))
    ekf.reset(q, v)
    found = ekf.q_v()
    np.testing.assert_allclose(found[0], q, atol=1e-12)
    np.testing.assert_allclose(found[1], v, atol=1e-12)
    R = rotation_from_quaternion(q[3:7])
    np.testing.assert_allclose(ekf.filter.position, q[:3] + R @ [0.1, 0.2, 0.3])
    with pytest.raises(ProblemError, match="floating base"):
        InvariantEkf(sf.load_robot("go2", fixed_base=True), 0.001)
    with pytest.raises(ProblemError, match="patience must be"):
        WatchSettings(patience=0.0)
    with pytest.raises(ProblemError, match="no estimated state"):
        estimate_errors(log_of(TROT))


def test_a_heading_that_is_wrong_by_more_than_half_a_turn_has_grown_by_that_much() -> None:
    """From 170 to 190 degrees while the robot turns on, and the estimate leans by a degree."""
    q, yaw = np.zeros((2, 21, 7)), np.radians(np.linspace(0.0, 60.0, 21))
    off = np.radians(np.linspace(170.0, 190.0, 21))
    q[0, :, 3:] = Rotation.from_euler("z", yaw[:, None]).as_quat()
    lean = Rotation.from_rotvec(np.radians([1.0, 0.0, 0.0]))
    q[1, :, 3:] = (lean * Rotation.from_euler("z", (yaw + off)[:, None])).as_quat()
    still = np.zeros((21, 6))
    log = Log({"time": yaw, "q": q[0], "v": still, "q_estimated": q[1], "v_estimated": still})
    found = estimate_errors(log)
    assert (found.heading_deg, found.tilt_rms_deg) == pytest.approx((20.0, 1.0))
    q[1, 20] = np.nan  # an estimator that blows up
    found = estimate_errors(
        Log({"time": yaw, "q": q[0], "v": still, "q_estimated": q[1], "v_estimated": still})
    )
    assert np.isnan([found.heading_deg, found.tilt_rms_deg, found.drift]).all()


@pytest.mark.parametrize(("pitch", "believed"), [(0.0, True), (0.15, False)])
def test_a_sole_that_turns_about_its_edge_does_not_stand(pitch: float, believed: bool) -> None:
    """Its middle moves, though it touches."""
    g1 = sf.load_robot("g1")
    estimator, q = StateEstimator(InvariantEkf(g1, 0.001)), g1.nominal.copy()
    q[7 + g1.joint_names.index("left_ankle_pitch_joint")] -= pitch
    estimator.reset(q)
    for _ in range(3):
        estimator.predict(Reading(np.zeros(3), REST, q[7:], np.zeros(g1.joints)))
        estimator.update(np.ones(2, dtype=bool))
    assert estimator.ekf.filter.used.tolist() == [believed, True]


def test_a_command_that_says_nothing_of_feet_leaves_even_odds() -> None:
    """A policy's; it was taken for one whose feet all push."""
    go2, odds = sf.load_robot("go2"), []
    for forces in (np.zeros((4, 3)), np.array(np.nan)):
        tracker = StateTracker(go2, 0.001)
        tracker.plan(Command(np.zeros(12), forces, np.ones(4, dtype=bool)).for_points(4))
        tracker.state(Reading(np.zeros(3), np.array([0.0, 0.0, 9.81]), go2.nominal[7:], np.zeros(12)), 0.0)
        odds.append(tracker.estimator.fusion.odds.copy())
    np.testing.assert_allclose(odds[0] - odds[1], TouchSettings().pushing)
