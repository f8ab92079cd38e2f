"""The filter on its own error bars: they hold on circles and on a recorded robot, faults raise a doubt."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.stats import chi2

import surefoot as sf
from benchmarks.problems.circles import (
    FAULTS,
    QUIET,
    end_error,
    estimate_circle,
    random_circle,
    spoilt_circle,
)
from surefoot.base.errors import ProblemError
from surefoot.motion.estimation.trust import TrustMonitor, TrustSettings

GO1 = Path(__file__).resolve().parents[4] / "shared/data/go1_log/go1.csv"
LEGS = ("FL", "FR", "RL", "RR")


@pytest.fixture(scope="module")
def robot() -> sf.Robot:
    return sf.load_robot("go1")


def check_circles(robot: sf.Robot, seeds: range) -> None:
    """NEES of turn, place and biases after a circle within the 95 % bounds of their sum, and no doubt."""
    total = 0.0
    for seed in seeds:
        log = random_circle(robot, seed)
        ekf, doubts = estimate_circle(robot, log)
        error, covariance = end_error(ekf, log)
        total += float(error @ np.linalg.solve(covariance, error))
        assert doubts == [], seed
    low, high = chi2.ppf([0.025, 0.975], 12 * len(seeds))
    assert low < total < high


@pytest.mark.long
def test_error_bars_hold_after_a_circle(robot: sf.Robot) -> None:
    check_circles(robot, range(2))


@pytest.mark.long
def test_error_bars_hold_after_twenty_circles(robot: sf.Robot) -> None:
    check_circles(robot, range(20))


@pytest.mark.parametrize(
    "fault", [pytest.param(f, marks=() if k in (2, 3) else pytest.mark.long) for k, f in enumerate(FAULTS)]
)
def test_a_fault_raises_a_doubt_and_says_why(robot: sf.Robot, fault: str) -> None:
    log = spoilt_circle(robot, FAULTS.index(fault), fault)
    _, doubts = estimate_circle(robot, log, mapped=fault.startswith("map"))
    assert doubts, fault
    if fault.startswith("map"):
        assert "map is +0.2" in doubts[0]


def test_a_right_map_raises_none(robot: sf.Robot) -> None:
    ekf, doubts = estimate_circle(robot, random_circle(robot, 3), mapped=True)
    assert doubts == []
    assert ekf.trust.good
    assert ekf.trust.reason == ""


def test_feet_wander_more_while_the_body_turns_shakes_or_the_foot_slides(robot: sf.Robot) -> None:
    """The variance that a step adds to a standing foot is the sum of squares that `FilterNoise` tells."""
    noise = QUIET.__class__(foot=1e-3, landing=1e-3, turning=0.1, slip=0.0, impact=0.01)
    ekf, dt = sf.InvariantEkf(robot, 0.0025, noise), 0.0025
    still = np.zeros(robot.joints)
    for rate, force in ((0.0, 9.81), (1.0, 9.81), (0.0, 19.81)):
        ekf.reset(robot.nominal)
        for _ in range(3):
            ekf.predict([0.0, 0.0, rate], [0.0, 0.0, force])
            ekf.update(robot.nominal[7:], still, [True] * 4)
        turned = float(np.linalg.norm(ekf.filter.bias[:3] - [0.0, 0.0, rate]))
        added = ekf.filter.memory[-4 * 4 - 1 - 5 - 4 :][
            :4
        ]  # the feet's densities, before walks, gate and the rest
        expected = 1e-6 + (0.1 * turned) ** 2 + (0.01 * (force - 9.80665)) ** 2
        np.testing.assert_allclose(added, expected, rtol=0.02)
    assert dt == ekf.dt


def test_a_monitor_forgets_a_doubt_and_keeps_it_for_a_while() -> None:
    monitor = TrustMonitor(("a", "b"), 0.01, np.array([0.01, 0.1]), TrustSettings(hold=0.5))
    quiet, on = np.zeros((2, 3)), np.ones(2, dtype=bool)

    def step(innovations: np.ndarray = quiet, bias: float = 0.0) -> sf.Robot:
        monitor.take_correction(innovations, on, on, on, np.full(6, bias))
        return monitor.trust

    assert step().good
    assert not step(np.array([[0.0, 0.0, 0.0], [11.0, 0.0, 0.0]])).good
    assert monitor.trust.reason.startswith("b has jumped")
    for _ in range(40):
        assert not step().good
    for _ in range(20):
        step()
    assert monitor.trust == (True, "")
    assert "gyro's bias" in step(bias=0.06).reason
    monitor.reset()
    assert monitor.trust.good
    assert "not finite" in step(np.full((2, 3), np.nan)).reason
    monitor.reset()
    flags = np.zeros(2, dtype=bool)
    for count in range(200):
        monitor.take_correction(quiet, flags, flags, np.array([False, count == 50]), np.zeros(6))
        assert monitor.trust.good or count >= 150
    assert not monitor.trust.good
    assert monitor.trust.reason == "no foot has touched for 1 s: place and speed are the IMU's alone"
    with pytest.raises(ProblemError, match="refused"):
        TrustSettings(refused=-1.0)


def read_go1(robot: sf.Robot) -> tuple[np.ndarray, ...]:
    """Time, accelerometer, gyro, joints in the model's order, and contacts by the sensors in the feet."""
    table = np.genfromtxt(GO1, delimiter=",", names=True)
    stack = lambda names: np.stack([table[name] for name in names], axis=1)  # noqa: E731
    joints = stack([f"JointPos{leg}_{part}" for leg in LEGS for part in ("hip", "thigh", "calf")])
    pressed = stack([f"{leg}_Force" for leg in LEGS])
    contact = pressed > np.percentile(pressed, 5, axis=0) + 60.0
    axes = stack([f"BaseA{c}" for c in "xyz"]), stack([f"BaseW{c}" for c in "xyz"])
    return table["Times"], *axes, joints, contact


@pytest.mark.skipif(not GO1.exists(), reason="the recorded Go1 is not here")
@pytest.mark.parametrize("start", [0, 300, 500, 700])
@pytest.mark.long
def test_a_recorded_circle_keeps_its_biases_heading_and_height(robot: sf.Robot, start: int) -> None:
    time, force, gyro, joints, contact = read_go1(robot)
    rest, end = (time > time[0] + 1.75) & (time < time[0] + 1.95), time > time[-1] - 0.5
    speeds, dt = np.gradient(joints, time, axis=0), float(np.median(np.diff(time)))
    ekf = sf.InvariantEkf(robot, dt, ground=sf.FlatTerrain())
    q = robot.nominal.copy()
    up = force[start : start + 20].mean(axis=0)
    pitch, roll = np.arctan2(-up[0], np.hypot(up[1], up[2])), np.arctan2(up[1], up[2])
    from scipy.spatial.transform import Rotation

    turn = first = Rotation.from_euler("ZYX", [0.0, pitch, roll])
    q[3:7], q[7:] = first.as_quat(), joints[start]
    q[2] -= robot.foot_positions(q)[:, 2].mean() - 0.02
    ekf.reset(q)
    still = gyro[(time > time[0] + 1.05) & (time < time[0] + 1.95)].mean(axis=0)
    for t in range(start, len(time)):
        if t > start:
            ekf.predict(gyro[t], force[t])
            turn = turn * Rotation.from_rotvec((gyro[t] - still) * dt)
        ekf.update(joints[t], speeds[t], contact[t])
        if rest[t] and not rest[t + 1] and start < 600:
            check_bias(ekf, still)
    check_bias(ekf, gyro[end].mean(axis=0))
    off = (Rotation.from_matrix(ekf.filter.rotation) * turn.inv()).as_rotvec()
    assert abs(np.degrees(off[2])) < 4.0
    assert abs(robot.foot_positions(ekf.q_v()[0])[:, 2].mean() - 0.02) < 0.05
    assert ekf.trust.good


def check_bias(ekf: sf.InvariantEkf, rest: np.ndarray) -> None:
    """The gyro's bias is within three of its standard deviations of what rest says."""
    n = len(ekf.filter.covariance)
    spread = np.sqrt(np.diag(ekf.filter.covariance)[n - 6 : n - 3])
    assert np.all(np.abs(ekf.filter.bias[:3] - rest) < 3.0 * spread)
