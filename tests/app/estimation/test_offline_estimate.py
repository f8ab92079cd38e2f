"""A stranger's log in one call: order, sides, units, speeds and the start's height are found, and told."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import surefoot as sf
from benchmarks.problems.circles import CircleLog, random_circle
from surefoot.base.errors import ProblemError

GO1 = Path(__file__).resolve().parents[4] / "shared/data/go1_log/go1.csv"
ROWS = 2400
MIRRORED = [3, 4, 5, 0, 1, 2, 9, 10, 11, 6, 7, 8]
"""Right legs first, as Unitree has them."""


@pytest.fixture(scope="module")
def robot() -> sf.Robot:
    return sf.load_robot("go1")


@pytest.fixture(scope="module")
def circle(robot: sf.Robot) -> CircleLog:
    return random_circle(robot, 4)


def made_log(circle: CircleLog, robot: sf.Robot, order: list[int], feet: list[int], named: bool) -> sf.Log:
    """A log with columns in some order; the feet's sensors press by 100 where a foot stands."""
    arrays = {
        "time": 7.0 + circle.dt * np.arange(ROWS), "imu_angular_velocity": circle.gyro[:ROWS],
        "imu_acceleration": circle.accelerometer[:ROWS], "joint_positions": circle.joints[:ROWS][:, order],
        "foot_sensors": 100.0 * circle.contact[:ROWS][:, feet] + 3.0,
    }  # fmt: skip
    facts = {"feet": [robot.feet[k].name for k in feet]}
    if named:
        facts["joints"] = [robot.joint_names[k].replace("_joint", "") for k in order]
    return sf.Log(arrays, facts)


def check_estimate(found: sf.Log, circle: CircleLog) -> None:
    """Joints as they were, the base within centimetres of the truth."""
    np.testing.assert_allclose(found["q"][:, 7:], circle.joints[:ROWS], atol=1e-9)
    off = found["q"][-1, :3] - circle.q[ROWS - 1, :3]
    assert np.abs(off).max() < 0.05
    assert found["v"].shape == (ROWS, 18)


def test_names_order_joints_and_feet(robot: sf.Robot, circle: CircleLog) -> None:
    found = sf.estimate_state(made_log(circle, robot, MIRRORED, [1, 0, 3, 2], named=True), robot)
    check_estimate(found, circle)
    told = found.facts["computed"]
    assert "joint speeds are differences of the angles" in told
    assert not any("order" in line for line in told)
    assert found.facts["joints"] == list(robot.joint_names)
    # the feet stand on the ground at the start, and the estimate of the height stays
    assert abs(robot.foot_positions(found["q"][0])[:, 2].mean() - 0.02) < 0.005
    assert found["innovations"].shape == (ROWS, 4)


@pytest.mark.parametrize(
    "order", [MIRRORED, pytest.param([0, 3, 6, 9, 1, 4, 7, 10, 2, 5, 8, 11], marks=pytest.mark.long)]
)
def test_without_names_the_order_that_fits_is_taken(
    robot: sf.Robot, circle: CircleLog, order: list[int]
) -> None:
    found = sf.estimate_state(made_log(circle, robot, order, [0, 1, 2, 3], named=False), robot)
    check_estimate(found, circle)
    assert any(line.startswith("joints are ordered by best fit") for line in found.facts["computed"])


def test_swapped_sides_and_units_are_found(robot: sf.Robot, circle: CircleLog) -> None:
    log = made_log(circle, robot, list(range(12)), [0, 1, 2, 3], named=True)
    arrays = dict(log.arrays) | {
        "joint_positions": np.degrees(log["joint_positions"])[:, MIRRORED],
        "imu_acceleration": log["imu_acceleration"] / 9.80665,
        "imu_angular_velocity": np.degrees(log["imu_angular_velocity"]), "time": 1e3 * log["time"] + 1.7e12,
    }  # fmt: skip
    found = sf.estimate_state(sf.Log(arrays, log.facts), robot)
    check_estimate(found, circle)
    assert found["time"][-1] - found["time"][0] == pytest.approx(circle.dt * (ROWS - 1))
    told = " ".join(found.facts["computed"])
    assert "time is in milliseconds" in told
    assert "turn rates are in degrees per second" in told
    assert "degrees" in told
    assert "in g" in told
    assert "against their names" in told


@pytest.mark.parametrize("named", [False, True])
def test_without_contacts_the_two_feet_that_reach_lowest_tell_the_order(
    robot: sf.Robot, circle: CircleLog, named: bool
) -> None:
    log = made_log(circle, robot, list(range(12)), [0, 1, 2, 3], named)
    arrays = {name: array for name, array in log.arrays.items() if name != "foot_sensors"}
    arrays["joint_positions"] = arrays["joint_positions"][:, MIRRORED]  # whatever the names say
    arrays["imu_angular_velocity"] = np.degrees(arrays["imu_angular_velocity"])
    found = sf.estimate_state(sf.Log(arrays, log.facts), robot)
    np.testing.assert_allclose(found["q"][:, 7:], circle.joints[:ROWS], atol=1e-9)
    told = " ".join(found.facts["computed"])
    assert ("against their names" if named else "joints are ordered by best fit") in told
    assert "in doubt" not in told
    assert "turn rates are in degrees per second" in told


def test_a_robot_that_stands_tells_no_order_and_that_is_said(robot: sf.Robot) -> None:
    rows = 600
    arrays = {
        "time": 0.002 * np.arange(rows), "imu_angular_velocity": np.zeros((rows, 3)),
        "imu_acceleration": np.tile([0.0, 0.0, 9.81], (rows, 1)),
        "joint_positions": np.tile(robot.nominal[7:], (rows, 1)),
    }  # fmt: skip
    found = sf.estimate_state(sf.Log(arrays), robot)
    np.testing.assert_allclose(found["q"][-1], robot.nominal, atol=0.01)
    told = found.facts["computed"]
    assert "joints are ordered by best fit, as the robot has them: 0.000 m/s rms" in told
    assert "the order of the joints is in doubt: another fits to 0.000 m/s rms" in told


def test_feet_whose_sensors_tell_nothing_touch_where_they_are_lowest(
    robot: sf.Robot, circle: CircleLog
) -> None:
    log, truth = made_log(circle, robot, list(range(12)), [0, 1, 2, 3], named=True), circle.contact[:ROWS]
    noise = np.random.default_rng(0).normal(size=(ROWS, 4))
    for sensors, lines in (
        (np.where([False, True, False, False], 3.0, log["foot_sensors"]), 1),  # one is stuck
        (100.0 * truth + 40.0 * noise, 4),  # and all are noise
    ):
        found = sf.estimate_state(sf.Log({**log.arrays, "foot_sensors": sensors}, log.facts), robot)
        told = [line for line in found.facts["computed"] if "does not tell its contacts" in line]
        assert len(told) == lines
        # feet that lift off or come down are within the centimetre for some rows
        assert (found["contact_estimated"] == truth).mean() > 0.85
        check_estimate(found, circle)


@pytest.mark.long
def test_numbered_joints_and_columns_that_never_change(robot: sf.Robot, circle: CircleLog) -> None:
    log = made_log(circle, robot, list(range(12)), [0, 1, 2, 3], named=False)
    names = [f"{leg}_{k}" for leg in ("FL", "FR", "RL", "RR") for k in range(3)]
    found = sf.estimate_state(sf.Log(dict(log.arrays), log.facts | {"joints": names}), robot)
    check_estimate(found, circle)
    assert not any("order" in line for line in found.facts["computed"])
    wider = np.hstack([log["joint_positions"], np.zeros((ROWS, 4))])
    arrays = dict(log.arrays) | {
        "joint_positions": wider,
        "joint_velocities": np.gradient(wider, circle.dt, axis=0),
    }
    found = sf.estimate_state(sf.Log(arrays, log.facts), robot)
    check_estimate(found, circle)
    assert any(line.startswith("columns 13, 14, 15, 16") for line in found.facts["computed"])


def test_torques_tell_friction_under_each_foot(robot: sf.Robot) -> None:
    """A robot that stands still, at 50 Hz, its torques in the file's order of legs."""
    rows = 100
    q = sf.place(robot)
    arrays = {
        "time": 0.02 * np.arange(rows), "imu_angular_velocity": np.zeros((rows, 3)),
        "imu_acceleration": np.tile([0.0, 0.0, 9.81], (rows, 1)),
        "joint_positions": np.tile(q[7:], (rows, 1)),
        "joint_velocities": np.zeros((rows, 12)), "torques": np.ones((rows, 12)),
    }  # fmt: skip
    found = sf.estimate_state(sf.Log(arrays, {"joints": list(robot.joint_names)}), robot)
    told = [line for line in found.facts["computed"] if "mu above" in line]
    assert [line.split(":")[0] for line in told] == [foot.name for foot in robot.feet]
    spoilt = arrays | {"torques": np.full((rows, 12), np.nan)}
    found = sf.estimate_state(sf.Log(spoilt, {"joints": list(robot.joint_names)}), robot)
    assert not any("mu above" in line for line in found.facts["computed"])


def test_what_is_no_log_of_the_robot_is_refused(robot: sf.Robot, circle: CircleLog) -> None:
    log = made_log(circle, robot, list(range(12)), [0, 1, 2, 3], named=True)
    for name in ("imu_acceleration", "joint_positions"):
        with pytest.raises(ProblemError, match=name.split("_")[0]):
            sf.estimate_state(sf.Log({k: v for k, v in log.arrays.items() if k != name}, log.facts), robot)
    with pytest.raises(ProblemError, match="has 29 joints, the log has 12"):
        sf.estimate_state(sf.Log({k: v for k, v in log.arrays.items() if k != "foot_sensors"}), "g1")
    with pytest.raises(ProblemError, match="second"):
        sf.estimate_state(log.rows(np.arange(ROWS) < 50), robot)


@pytest.mark.skipif(not GO1.exists(), reason="the recorded Go1 is not here")
def test_a_recorded_log_ends_on_the_floor_it_began_on(robot: sf.Robot) -> None:
    found = sf.estimate_state(GO1, robot)
    assert found["trusted"].all()
    assert abs(robot.foot_positions(found["q"][-1])[:, 2].mean() - 0.02) < 0.05


def test_rows_that_are_missing_are_bridged_and_a_hole_is_no_longer_trusted(
    robot: sf.Robot, circle: CircleLog
) -> None:
    log = made_log(circle, robot, list(range(12)), [0, 1, 2, 3], named=True)
    kept = np.random.default_rng(0).random(ROWS) > 0.1
    kept[[0, ROWS - 1]] = True
    found = sf.estimate_state(
        sf.Log({name: array[kept] for name, array in log.arrays.items()}, log.facts), robot
    )
    whole = sf.estimate_state(log, robot)
    for one in (found, whole):
        off = one["q"][-1, :7] - circle.q[ROWS - 1, :7]
        assert np.abs(off).max() < 0.05  # a tenth of the turn would be 0.19 rad
        assert one["trusted"].all()
    hole = (np.arange(ROWS) < 900) | (np.arange(ROWS) >= 1200)
    found = sf.estimate_state(
        sf.Log({name: array[hole] for name, array in log.arrays.items()}, log.facts), robot
    )
    assert found["trusted"][:900].all()
    assert not found["trusted"][900:].any()
    assert any(f"nothing was recorded for {301 * circle.dt:.2f} s" in one for one in found.facts["computed"])


@pytest.mark.parametrize(
    ("channel", "row", "value", "said"),
    [
        ("time", 7, np.nan, "time must grow from row to row, got .* and nan s in rows 6 and 7"),
        ("time", 7, 0.0, "time must grow from row to row, got .* and 0 s in rows 6 and 7"),
        ("imu_angular_velocity", 5, np.nan, "needs imu_angular_velocity in every row, got .* in row 5 and 0"),
        ("imu_acceleration", 5, np.inf, "needs imu_acceleration in every row, got .* in row 5 and 0 others"),
        ("joint_positions", 0, np.nan, "needs joint_positions in every row, got .* in row 0 and 0 others"),
    ],
)
def test_rows_without_numbers_are_refused_by_their_place(
    robot: sf.Robot, circle: CircleLog, channel: str, row: int, value: float, said: str
) -> None:
    arrays = dict(made_log(circle, robot, list(range(12)), [0, 1, 2, 3], named=True).arrays)
    arrays[channel] = arrays[channel].copy()
    arrays[channel][row] = value
    with pytest.raises(sf.SurefootError, match=said):
        sf.estimate_state(sf.Log(arrays), robot)


def test_logs_of_no_length_are_refused(robot: sf.Robot, circle: CircleLog) -> None:
    log = made_log(circle, robot, list(range(12)), [0, 1, 2, 3], named=True)
    for rows in (0, 1, 30):
        short = sf.Log({name: array[:rows] for name, array in log.arrays.items()}, log.facts)
        with pytest.raises(sf.SurefootError, match="needs a second of a log"):
            sf.estimate_state(short, robot)
