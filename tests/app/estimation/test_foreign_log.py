"""What a log of another maker means for a robot: units, order, speeds and contacts."""

from __future__ import annotations

from collections.abc import Iterable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from surefoot.app.estimation.column_orders import (
    ColumnOrder,
    foot_orders,
    leg_joints,
    named_orders,
    unnamed_orders,
)
from surefoot.app.estimation.foreign_log import ForeignLog, read_foreign
from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.errors import ProblemError
from surefoot.records import Log
from tests.robots import go2

PLACES = np.array([[0.3, 0.0, 0.0], [-0.3, 0.0, 0.0]])
"""Of the legs of a robot whose joints slide its feet along x, y and z [m]."""
NAMES = ("FL_hip_joint", "FL_thigh_joint", "FL_calf_joint", "FR_hip_joint", "FR_thigh_joint", "FR_calf_joint")
SWAPPED = [3, 4, 5, 0, 1, 2]
RATE = 100.0


class Slider:
    """A robot of two legs with three slides each: its feet are where the joints say."""

    name, joints, joint_names = "slider", 6, NAMES
    feet = (SimpleNamespace(name="FL_foot", frame=0), SimpleNamespace(name="FR_foot", frame=1))
    model = SimpleNamespace(
        frames=[SimpleNamespace(parentJoint=4), SimpleNamespace(parentJoint=7)],
        joints=[SimpleNamespace(idx_q=k) for k in (0, 0, 7, 8, 9, 10, 11, 12)],
        parents=[0, 0, 1, 2, 3, 1, 5, 6],
    )
    nominal = np.full(13, np.nan)

    def foot_positions(self, q: FloatArray) -> FloatArray:
        assert q[:7].tolist() == [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]
        return np.asarray(PLACES + q[7:].reshape(2, 3), dtype=np.float64)


class FourSliders(Slider):
    """The same with four legs, the hind ones where the front ones are."""

    name, joints = "four", 12
    joint_names = tuple(
        f"{leg}_{part}_joint" for leg in ("FL", "FR", "RL", "RR") for part in ("hip", "thigh", "calf")
    )
    feet = tuple(
        SimpleNamespace(name=f"{leg}_foot", frame=k) for k, leg in enumerate(("FL", "FR", "RL", "RR"))
    )
    model = SimpleNamespace(
        frames=[SimpleNamespace(parentJoint=3 * k + 4) for k in range(4)],
        joints=[SimpleNamespace(idx_q=k) for k in (0, 0, *range(7, 19))],
        parents=[0, 0, *(p for k in range(4) for p in (1, 3 * k + 2, 3 * k + 3))],
    )
    nominal = np.full(19, np.nan)

    def foot_positions(self, q: FloatArray) -> FloatArray:
        return np.asarray(np.tile(PLACES, (2, 1)) + q[7:].reshape(4, 3), dtype=np.float64)


SLIDER: Any = Slider()
FOUR: Any = FourSliders()


def turned(count: int = 60, rate: float = 0.5, step: float = 1.0 / RATE) -> FloatArray:
    """Return the (T, 6) slides of a body that turns to its left and goes ahead, on feet that stand."""
    time = step * np.arange(count)
    stand = (
        PLACES + np.array([0.0, 0.0, -0.3]) - np.stack([0.4 * time, 0.0 * time, 0.0 * time], axis=1)[:, None]
    )
    c, s = np.cos(rate * time)[:, None], np.sin(rate * time)[:, None]
    x, y = c * stand[..., 0] + s * stand[..., 1], c * stand[..., 1] - s * stand[..., 0]
    return np.asarray((np.stack([x, y, stand[..., 2]], axis=-1) - PLACES).reshape(count, 6))


def log_of(
    joints: FloatArray, facts: dict[str, Any] | None = None, step: float = 1.0 / RATE, **more: Any
) -> Log:
    count = len(joints)
    arrays = {
        "time": step * np.arange(count), "imu_angular_velocity": np.tile([0.0, 0.0, 0.5], (count, 1)),
        "imu_acceleration": np.tile([0.0, 0.0, 9.81], (count, 1)), "joint_positions": joints,
    }  # fmt: skip
    arrays = {name: array for name, array in {**arrays, **more}.items() if array is not None}
    return Log(arrays, facts or {})


NAMED: dict[str, Any] = {"joints": list(NAMES)}
FEET = ("FL", "FR")


def read(log: Log, contact: BoolArray | None = None, names: Any = FEET) -> ForeignLog:
    """Return what is read where both feet touch, unless something else is given."""
    contact = np.ones((len(log), 2), dtype=bool) if contact is None else contact
    return read_foreign(log, SLIDER, contact, names)


@pytest.mark.parametrize("name", ["imu_angular_velocity", "imu_acceleration"])
def test_a_log_without_an_imu_s_channel_is_refused(name: str) -> None:
    with pytest.raises(ProblemError, match=f"needs the channel {name}; the log has time, "):
        read(log_of(turned(), None, 1.0 / RATE, **{name: None}))


def test_a_log_without_joints_is_refused() -> None:
    with pytest.raises(ProblemError, match="needs joint_positions or q; the log has time, imu"):
        read(log_of(turned(), joint_positions=None))


def test_joints_and_speeds_of_a_whole_state_are_those_behind_its_base() -> None:
    joints = turned()
    q, v = np.hstack([np.full((60, 7), 0.5), joints]), np.hstack([np.full((60, 6), 0.5), 2.0 * joints])
    found = read(log_of(joints, NAMED, joint_positions=None, q=q, v=v))
    np.testing.assert_allclose(found.joints, joints)
    np.testing.assert_allclose(found.speeds, 2.0 * joints)
    own = read(log_of(joints, NAMED, q=9.0 * q, v=v, joint_velocities=3.0 * joints))
    np.testing.assert_allclose(own.joints, joints)
    np.testing.assert_allclose(own.speeds, 3.0 * joints)


def test_columns_that_never_change_are_left_out_by_their_numbers() -> None:
    wide = np.hstack([np.ones((60, 1)), turned(), np.zeros((60, 2))])
    wide[:, 3] = 0.01 * np.arange(60)  # the legs' heights change as well
    wide[:, 6] = 0.02 * np.arange(60)
    found = read(log_of(wide, torques=np.tile(np.arange(9.0), (60, 1))), names=())
    np.testing.assert_allclose(np.sort(found.joints[5]), np.sort(wide[5, 1:7]))
    assert found.torques is not None
    assert set(found.torques[0].tolist()) == {1.0, 2.0, 3.0, 4.0, 5.0, 6.0}
    assert found.told[0] == (
        "columns 1, 8, 9 of the joints never change and are left out: slider has no such joints"
    )


def test_joints_that_are_not_the_robot_s_are_refused() -> None:
    for joints in (turned()[:, :5], np.hstack([turned()] * 2)):
        with pytest.raises(ProblemError, match=rf"slider has 6 joints, the log has {joints.shape[1]}"):
            read(log_of(joints))
    with pytest.raises(ProblemError, match="the log has 5"):
        read(log_of(np.cumsum(np.ones((60, 5)), axis=0)))


def test_angles_beyond_seven_are_degrees_and_so_are_their_speeds() -> None:
    joints = np.zeros((60, 6))
    joints[3, 2] = -7.0
    still = read(log_of(joints, NAMED, joint_velocities=np.ones((60, 6))))
    assert still.joints[3, 2] == -7.0
    assert still.speeds[0, 0] == 1.0
    joints[3, 2] = -7.5
    log = log_of(joints, NAMED, joint_velocities=np.full((60, 6), 180.0))
    found = read(log)
    assert found.joints[3, 2] == pytest.approx(np.radians(-7.5))
    assert found.speeds[0, 0] == pytest.approx(np.pi)
    assert "joint angles are in degrees: they go beyond 7" in found.told
    assert log["joint_positions"][3, 2] == -7.5  # the log is left as it is
    assert still.told == ()


def test_turn_rates_beyond_thirty_five_are_degrees_per_second() -> None:
    gyro = np.zeros((60, 3))
    gyro[4, 0] = -35.0
    assert read(log_of(turned(), NAMED, imu_angular_velocity=gyro)).gyro[4, 0] == -35.0
    gyro[4, 0] = -90.0
    found = read(log_of(turned(), NAMED, imu_angular_velocity=gyro))
    assert found.gyro[4, 0] == pytest.approx(-0.5 * np.pi)
    assert found.told[0] == "turn rates are in degrees per second: they go beyond 35"


@pytest.mark.parametrize(("size", "factor"), [(0.5, 1.0), (0.51, 9.80665), (1.9, 9.80665), (2.0, 1.0)])
def test_specific_forces_near_one_are_in_g(size: float, factor: float) -> None:
    force = np.tile([0.0, 0.6 * size, 0.8 * size], (60, 1))
    force[:5] = 100.0  # of jolts in few rows nothing is made
    found = read(log_of(turned(), NAMED, imu_acceleration=force))
    np.testing.assert_allclose(found.accelerometer, factor * force)
    line = f"specific forces are in g: {size:.2f} in the middle"
    assert (line in found.told) == (factor > 1.0)


@pytest.mark.parametrize(("cosine", "sign"), [(-0.75, 1.0), (-0.85, -1.0), (-1.0, -1.0), (0.9, 1.0)])
def test_specific_forces_that_point_down_are_of_the_other_sign(cosine: float, sign: float) -> None:
    force = 9.81 * np.tile([np.sqrt(1.0 - cosine**2), 0.0, cosine], (60, 1))
    found = read(log_of(turned(), NAMED, imu_acceleration=force))
    np.testing.assert_allclose(found.accelerometer, sign * force)
    line = "specific forces point down, as gravity does: their sign is turned"
    assert (line in found.told) == (sign < 0.0)


def test_speeds_that_a_log_lacks_are_differences_of_its_angles() -> None:
    joints = 0.01 * np.arange(60)[:, None] * np.arange(1.0, 7.0)
    found = read(log_of(joints, NAMED))
    np.testing.assert_allclose(found.speeds, np.tile(np.arange(1.0, 7.0), (60, 1)))
    assert found.told[-1] == "joint speeds are differences of the angles"
    assert found.torques is None


def test_names_in_other_words_order_joints_feet_and_torques() -> None:
    """Left front is front left; HAA, HFE and KFE are hip, thigh and calf, and so are 0, 1 and 2."""
    joints, contact = turned(), np.zeros((60, 2), dtype=bool)
    contact[:, 1] = True
    for names in (
        ["rf_HAA", "rf_HFE", "rf_KFE", "LF-haa", "LF-hfe", "LF-kfe"],
        ["leg_rf_0", "leg_rf_1", "leg_rf_2", "leg_lf_0_joint", "leg_lf_1_joint", "leg_lf_2_joint"],
        ["fr_abad", "fr_thigh", "fr_knee", "fl_abduction", "fl_thigh", "fl_knee"],
    ):
        log = log_of(joints[:, SWAPPED], {"joints": names}, torques=np.tile(np.arange(6.0), (60, 1)))
        found = read(log, contact, ("RF_TOE", "LF_FOOT"))
        np.testing.assert_allclose(found.joints, joints)
        assert found.torques is not None
        np.testing.assert_allclose(found.torques[0], SWAPPED)
        assert found.contact[0].tolist() == [True, False]
        assert found.told == ("joint speeds are differences of the angles",)


def test_the_legs_of_a_robot_are_its_joints_from_the_base_to_each_foot() -> None:
    assert leg_joints(go2()) == [[0, 1, 2], [3, 4, 5], [6, 7, 8], [9, 10, 11]]
    assert leg_joints(SLIDER) == [[0, 1, 2], [3, 4, 5]]


def test_other_orders_are_those_of_the_legs_leg_by_leg_or_joint_by_joint() -> None:
    def listed(orders: Iterable[ColumnOrder]) -> list[tuple[list[int], list[int], str]]:
        return [(one.joints.tolist(), one.feet.tolist(), one.words) for one in orders]

    legs, joints, feet = [[0, 1], [2, 3]], np.arange(4), np.array([5, 6])
    swap, own = "legs in the order 2, 1 of the robot's", ", feet as the robot has them"
    assert listed(named_orders(legs, joints, feet)) == [
        ([2, 3, 0, 1], [6, 5], swap), ([2, 3, 0, 1], [5, 6], swap + own),
    ]  # fmt: skip
    straight = "legs in the order 1, 2 of the robot's"
    assert listed(unnamed_orders(legs, feet)) == [
        ([0, 1, 2, 3], [5, 6], straight), ([0, 2, 1, 3], [5, 6], f"joint by joint, {straight}"),
        ([2, 3, 0, 1], [6, 5], swap), ([2, 3, 0, 1], [5, 6], swap + own),
        ([1, 3, 0, 2], [6, 5], f"joint by joint, {swap}"),
        ([1, 3, 0, 2], [5, 6], f"joint by joint, {swap}{own}"),
    ]  # fmt: skip
    assert listed(named_orders(legs, joints, feet, known=True)) == [([2, 3, 0, 1], [5, 6], swap)]
    assert [one.feet.tolist() for one in unnamed_orders(legs, feet, known=True)] == [[5, 6]] * 4
    assert listed(foot_orders(joints, feet)) == [
        ([0, 1, 2, 3], [6, 5], "feet in the order 2, 1 of the robot's")
    ]


def test_legs_of_a_log_need_not_come_as_the_robots_joints_do() -> None:
    """ANYmal's joints come left side first, its feet front first, as most logs have both."""
    legs = [[0, 1, 2], [6, 7, 8], [3, 4, 5], [9, 10, 11]]
    (order,) = (
        one for one in unnamed_orders(legs, np.arange(4))
        if one.words == "legs in the order 1, 2, 3, 4 of the robot's"
    )  # fmt: skip
    assert order.joints.tolist() == [0, 1, 2, 6, 7, 8, 3, 4, 5, 9, 10, 11]
    assert order.feet.tolist() == [0, 1, 2, 3]


def test_feet_without_names_are_ordered_by_fit_where_joints_have_theirs() -> None:
    """One foot swings while the others stand; the log has their columns in another order."""
    joints, contact = np.hstack([turned(), turned()]), np.ones((60, 4), dtype=bool)
    joints[:, 9:] += np.sin(np.arange(60.0))[:, None]
    contact[:, 3] = False
    log = log_of(joints, {"joints": list(FOUR.joint_names)})
    for columns in ([0, 1, 2, 3], [3, 0, 1, 2], [0, 3, 2, 1]):
        found = read_foreign(log, FOUR, contact[:, columns], ("w", "x", "y", "z"))
        assert not found.contact[:, 3].any()
        assert found.contact[:, :3].all()
        np.testing.assert_allclose(found.joints, joints)
        assert any(line.startswith("feet in the order") for line in found.told) == (columns != [0, 1, 2, 3])


def mixed(share: float, **more: Any) -> FloatArray:
    """Return slides of which each leg's are its own, and by a share those of the other leg.

    In the order of the names feet 0.6 m apart then differ by 0.5 rad/s from a body's by 0.3 m/s times that
    share; in the other order by the rest of 0.3 m/s.
    """
    joints = turned(**more)
    return (1.0 - share) * joints + share * joints[:, SWAPPED]


def test_names_are_overruled_where_another_order_fits_better_by_three_tenths() -> None:
    kept = read(log_of(mixed(0.57), NAMED))
    np.testing.assert_allclose(kept.joints, mixed(0.57))
    assert kept.told == ("joint speeds are differences of the angles",)
    found = read(log_of(mixed(0.61), NAMED))
    np.testing.assert_allclose(found.joints, mixed(0.61)[:, SWAPPED])
    assert found.told[0] == (
        "legs in the order 2, 1 of the robot's, against their names: standing feet then move as one body "
        "(0.117 m/s rms)"
    )


def test_without_names_the_order_that_fits_best_is_taken_and_told() -> None:
    swapped = read(log_of(mixed(0.52)))
    np.testing.assert_allclose(swapped.joints, mixed(0.52)[:, SWAPPED])
    assert swapped.told[0] == (
        "joints are ordered by best fit, legs in the order 2, 1 of the robot's: 0.144 m/s rms"
    )
    own = read(log_of(mixed(0.0)))
    np.testing.assert_allclose(own.joints, mixed(0.0))
    assert own.told[0] == "joints are ordered by best fit, as the robot has them: 0.000 m/s rms"


def test_the_misfit_is_that_of_rows_in_which_a_turning_body_stands_on_two_feet() -> None:
    """Elsewhere a foot moves as it likes: in the air, and where the body hardly turns."""
    joints, gyro = mixed(0.0), np.tile([0.0, 0.0, 0.5], (60, 1))
    contact = np.ones((60, 2), dtype=bool)
    contact[:25, 0] = False
    gyro[35:] = 0.09
    joints[:24, 0] += 5.0 * np.sin(np.arange(24.0))
    joints[36:, 4] += 5.0 * np.sin(np.arange(24.0))
    for order in ([0, 1, 2, 3, 4, 5], SWAPPED):
        found = read(log_of(joints[:, order], imu_angular_velocity=gyro), contact)
        np.testing.assert_allclose(found.joints, joints)
        assert found.told[0].endswith("0.000 m/s rms")


def test_a_body_that_hardly_turns_is_judged_by_all_rows() -> None:
    """At 0.05 rad/s: what is mixed by six tenths is off by 0.05 x 0.6 x 0.4 m/s in the better order."""
    gyro = np.tile([0.0, 0.0, 0.05], (60, 1))
    found = read(log_of(mixed(0.6, rate=0.05), imu_angular_velocity=gyro))
    assert found.told[0].endswith("legs in the order 2, 1 of the robot's: 0.012 m/s rms")


def test_velocities_are_differences_over_a_hundredth_of_a_second() -> None:
    """At 1 kHz a slide that shakes with a period of a hundredth of a second does not count."""
    joints = mixed(0.6, count=200, step=1e-3)
    joints[:, 0] += 1e-3 * np.sin(2.0 * np.pi * np.arange(200) / 10.0)
    found = read(log_of(joints, step=1e-3))
    assert found.told[0].endswith("2, 1 of the robot's: 0.120 m/s rms")
    slow = read(log_of(mixed(0.6, count=30, step=0.02), step=0.02))
    assert slow.told[0].endswith("2, 1 of the robot's: 0.120 m/s rms")


def test_without_contacts_the_robot_s_own_order_is_taken_and_lowest_feet_touch() -> None:
    joints = np.zeros((60, 6))
    joints[:, 2], joints[:, 5] = -0.3, -0.3
    joints[:20, 5] += 0.008
    joints[40:, 2] += 0.012
    found = read_foreign(log_of(joints), SLIDER, None, ())
    assert found.contact[10].tolist() == [True, True]
    assert found.contact[30].tolist() == [True, True]
    assert found.contact[50].tolist() == [False, True]
    np.testing.assert_allclose(found.joints, joints)
    assert found.told == (
        "joints are taken in the robot's order: the log does not name them as the robot does",
        "joint speeds are differences of the angles",
        "no contacts in the log: feet within 1 cm of the lowest are taken to touch",
    )
    assert len(read_foreign(log_of(joints, NAMED), SLIDER, None, ()).told) == 2


def lowest(slope: FloatArray, step: float = 0.01) -> BoolArray:
    """Return which feet touch, 0.6 m apart, under a specific force of a slope along x (T,)."""
    force = 9.81 * np.column_stack([slope, np.zeros(len(slope)), np.ones(len(slope))])
    log = log_of(np.zeros((len(slope), 6)), NAMED, step, imu_acceleration=force)
    return read_foreign(log, SLIDER, None, ()).contact


def test_the_vertical_is_the_mean_of_the_specific_force_over_a_second() -> None:
    """A slope of 0.025 puts one foot 1.5 cm higher; of half of that both are within 1 cm."""
    slope = np.zeros(400)
    slope[150:250] = 0.025
    contact = lowest(slope)
    assert contact[200].tolist() == [False, True]
    assert contact[145].all()
    assert contact[[20, 380]].all()
    jolt = np.zeros(400)
    jolt[200] = 1.0
    assert lowest(jolt)[195:205].all()
    assert lowest(-np.full(400, 0.025))[200].tolist() == [True, False]
    assert lowest(np.full(3, 0.025), 2.5).tolist() == [[False, True]] * 3


def test_in_free_fall_no_foot_is_lower_than_another() -> None:
    force = np.zeros((60, 3))
    log = log_of(np.zeros((60, 6)), NAMED, imu_acceleration=force)
    assert read_foreign(log, SLIDER, None, ()).contact.all()
