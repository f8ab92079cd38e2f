"""Mappings guessed from names alone: what every name means, its unit, and what is left out."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import surefoot as sf
from surefoot.records.log import npz_table
from surefoot.records.log.mapping import LogMapping, Take
from surefoot.records.log.mapping_guess import guess_mapping
from surefoot.records.log.source import Source, Topic

ROWS = 3


def columns(*names: str) -> LogMapping:
    return guess_mapping(Source({"": Topic(None, {name: np.zeros(ROWS) for name in names})}))


def arrays(facts: dict[str, Any] | None = None, /, **shapes: tuple[int, ...]) -> LogMapping:
    fields = {name: np.zeros((ROWS, *shape)) for name, shape in shapes.items()}
    return guess_mapping(Source({"": Topic(None, fields, kind=npz_table.KIND)}, facts=facts or {}))


def messages(**kinds: tuple[str, tuple[str, ...]]) -> LogMapping:
    topics = {
        f"/{name}": Topic(np.arange(3.0), dict.fromkeys(fields, np.zeros(ROWS)), kind=kind)
        for name, (kind, fields) in kinds.items()
    }
    return guess_mapping(Source(topics))


def axes(name: str, letters: str = "xyz") -> tuple[str, ...]:
    return tuple(f"{name}_{one}" for one in letters)


@pytest.mark.parametrize(("names", "channel"), [
    (axes("base_pos"), "base_position"), (axes("pelvis"), "base_position"),
    (axes("p_vicon"), "base_position"),
    (axes("root_linear_vel"), "base_velocity"), (axes("base_linear_velocity"), "base_velocity"),
    (axes("base_quat", "xyzw"), "base_orientation"), (axes("q", "xyzw"), "base_orientation"),
    (axes("imu_acc"), "imu_acceleration"), (axes("gyro"), "imu_angular_velocity"),
    (axes("grf"), "forces"), (axes("FL_foot_force"), "forces"), (axes("force_FL"), "forces"),
    (("FL_force", "FR_force"), "foot_sensors"), (("contact_load_left",), "foot_sensors"),
    (("RL_touch",), "foot_sensors"), (("q_knee",), "joint_positions"), (("knee.pos",), "joint_positions"),
    (("motor_dq_knee",), "joint_velocities"), (("knee_qd",), "joint_velocities"),
    (("tau_knee",), "torques"), (("knee.effort",), "torques"), (("friction",), "mu"),
])  # fmt: skip
def test_a_columns_name_tells_its_channel(names: tuple[str, ...], channel: str) -> None:
    guess = columns("t", *names)
    assert guess.guessed
    assert set(guess.channels) == {"time", channel}
    quaternion = "xyzw" if channel == "base_orientation" else ""
    assert guess.channels[channel] == Take(names, quaternion=quaternion)
    assert guess.channels["time"] == Take(("t",))


@pytest.mark.parametrize("name", ["time", "T", "timestamp", "sim_time", "ros_time_stamp", "stamp"])
def test_the_time_has_many_names(name: str) -> None:
    assert columns(name, "mu").channels["time"] == Take((name,))


@pytest.mark.parametrize(("name", "unit"), [
    ("knee_pos [deg]", "deg"), ("knee_pos(rad)", "rad"), ("knee_pos_deg", "deg"), ("knee_pos_rad", "rad"),
    ("knee_pos [mm]", "mm"), ("knee_tau [Nm]", "N m"), ("knee_vel (deg/s)", "deg/s"), ("knee_pos", ""),
])  # fmt: skip
def test_units_are_taken_off_the_end_of_a_name(name: str, unit: str) -> None:
    guess = columns(name)
    (take,) = guess.channels.values()
    assert take == Take((name,), unit=unit)
    assert guess.joints == ("knee",)


def test_units_of_time_are_bare_and_lengths_are_not() -> None:
    assert columns("time_ms", "mu").channels["time"].unit == "ms"
    assert columns("t_s", "mu").channels["time"].unit == "s"
    assert columns("q_arm_m").joints == ("arm_m",)


def test_a_name_that_is_nothing_but_a_unit_is_a_name() -> None:
    assert columns("_rad", "mu").channels == {"mu": Take(("mu",))}


def test_columns_of_two_units_are_left_out_but_raw_sensors_are_raw() -> None:
    guess = columns("a_pos_deg", "b_pos", "mu", "FL_force [N]", "FR_force")
    assert "joint_positions" not in guess.channels
    assert guess.channels["foot_sensors"] == Take(("FL_force [N]", "FR_force"))
    assert guess.feet == ("FL", "FR")


def test_the_first_of_two_clocks_or_frictions_counts() -> None:
    guess = columns("t", "time", "mu", "friction")
    assert guess.channels == {"time": Take(("t",)), "mu": Take(("mu",))}


def test_joints_are_in_the_order_of_their_angles() -> None:
    guess = columns("b_pos", "a_pos", "a_vel", "b_vel", "c_tau")
    assert guess.joints == ("b", "a")
    assert guess.channels["joint_velocities"].fields == ("b_vel", "a_vel")
    assert "torques" not in guess.channels


def test_axes_are_put_in_order_foot_by_foot() -> None:
    guess = columns("FR_force_z", "FR_force_x", "FL_force_x", "FL_force_y", "FR_force_Y", "FL_force_z")
    fields = ("FR_force_x", "FR_force_Y", "FR_force_z", "FL_force_x", "FL_force_y", "FL_force_z")
    assert guess.channels == {"forces": Take(fields)}
    assert guess.feet == ("FR", "FL")
    short = columns("mu", "FR_force_x", "FR_force_y", "FR_force_z", "FL_force_x")
    assert set(short.channels) == {"mu"}
    odd = columns("mu", *axes("base_vel", "xy"))
    assert set(odd.channels) == {"mu"}


def test_vertical_forces_alone_are_sensors() -> None:
    guess = columns("FL_force_z", "FR_force_z")
    assert guess.channels == {"foot_sensors": Take(("FL_force_z", "FR_force_z"))}
    both = columns("FL_force_z", "FL_touch")
    assert both.channels == {"foot_sensors": Take(("FL_touch",))}


def test_fields_that_mean_nothing_are_listed() -> None:
    names = [f"n{k}" for k in range(13)]
    for count, dots in ((12, ""), (13, " ...")):
        with pytest.raises(sf.ProblemError) as caught:
            columns(*names[:count])
        listed = ", ".join(names[:12])
        words = f"no channel can be guessed from the fields {listed}{dots}: give a mapping"
        assert str(caught.value) == words
    with pytest.raises(sf.ProblemError, match="no channel can be guessed from the fields t: give"):
        columns("t")


@pytest.mark.parametrize(("name", "shape", "channel", "take"), [
    ("qpos", (7,), "q", Take(("qpos",), quaternion="wxyz")), ("qpos", (6,), "q", Take(("qpos",))),
    ("q", (9,), "q", Take(("q",), quaternion="xyzw")), ("qvel", (8,), "v", Take(("qvel",), frame="world")),
    ("root_quat_w", (4,), "base_orientation", Take(("root_quat_w",), quaternion="wxyz")),
    ("base_orientation", (4,), "base_orientation", Take(("base_orientation",), quaternion="xyzw")),
    ("root_lin_vel_b", (3,), "base_velocity", Take(("root_lin_vel_b",), frame="base")),
    ("GRF", (4, 3), "forces", Take(("GRF",))), ("f", (3,), "forces", Take(("f",))),
    ("grf", (2,), "foot_sensors", Take(("grf",))), ("grf", (1,), "forces", Take(("grf",))),
    ("mu", (3,), "contact_friction", Take(("mu",))), ("mu", (), "mu", Take(("mu",))),
    ("friction", (1,), "mu", Take(("friction",))), ("contact", (2,), "active", Take(("contact",))),
    ("Foot_Positions", (2, 3), "contact_positions", Take(("Foot_Positions",))),
    ("tau", (5,), "torques", Take(("tau",))), ("fz", (2,), "foot_sensors", Take(("fz",))),
])  # fmt: skip
def test_an_arrays_name_and_shape_tell_its_channel(
    name: str, shape: tuple[int, ...], channel: str, take: Take
) -> None:
    guess = arrays(**{name: shape})
    assert guess.channels == {channel: take}
    assert guess.guessed


def test_arrays_that_do_not_fit_or_come_second_are_left_aside() -> None:
    assert arrays(mu=(2, 3), q=(8,)).channels.keys() == {"q"}
    assert arrays(mu=(), qfrc_actuator=(8,)).channels.keys() == {"mu"}
    assert arrays(tau=(2,), applied_torque=(2,)).channels["torques"] == Take(("tau",))
    assert arrays(tau=(2,), torques=(2,)).channels["torques"] == Take(("torques",))
    assert arrays(energy=(2,), q=(8,)).channels.keys() == {"q"}


def test_an_array_a_foot_is_the_forces_of_all() -> None:
    guess = arrays(FL=(3,), FR_grf=(3,), left=(2,), mu=())
    assert guess.channels["forces"] == Take(("FL", "FR_grf"))
    assert guess.feet == ("FL", "FR")
    whole = arrays(FL=(3,), forces=(2, 3))
    assert whole.channels["forces"] == Take(("forces",))
    assert whole.feet == ()


def test_columns_among_arrays_are_read_by_their_names() -> None:
    guess = arrays(FL_touch=(), FR_touch=(1,), a_pos=(), pair_pos=(2,))
    assert guess.channels == {
        "foot_sensors": Take(("FL_touch", "FR_touch")),
        "joint_positions": Take(("a_pos",)),
    }
    assert (guess.feet, guess.joints) == (("FL", "FR"), ("a",))


@pytest.mark.parametrize(("dt", "rate"), [(0.002, 500.0), (0.0, 0.0), (np.inf, 0.0), (-1.0, 0.0), (5.0, 0.2)])
def test_a_step_tells_the_rate_of_arrays_without_time(dt: float, rate: float) -> None:
    guess = arrays({"dt": dt, "mass": 3.0}, q=(8,))
    assert guess.rate == pytest.approx(rate)
    assert guess.facts == {"mass": 3.0}
    assert arrays({"dt": dt}, q=(8,), t=()).rate == 0.0


def test_friction_of_an_array_wins_over_that_of_a_fact() -> None:
    assert arrays({"mu": 0.5}, q=(8,)).facts == {"mu": 0.5}
    assert arrays({"mu": 0.5}, q=(8,), mu=()).facts == {}
    assert arrays({"mu": 0.5}, q=(8,), contact_friction=(2,)).facts == {}


def test_the_type_of_a_message_tells_its_channels() -> None:
    guess = messages(
        joints=("sensor_msgs/JointState", ("position", "velocity")),
        odometry=("nav_msgs/msg/Odometry", ("pose.pose.position.x", "pose.pose.orientation.x",
                                            "twist.twist.linear.x", "twist.twist.angular.x")),
        imu=("sensor_msgs.Imu", ("linear_acceleration.x",)),
        pose=("PoseStamped", ("pose.position.x",)),
    )  # fmt: skip
    assert guess.channels == {
        "joint_positions": Take(("/joints.position",)), "joint_velocities": Take(("/joints.velocity",)),
        "base_position": Take(("/odometry.pose.pose.position",)),
        "base_orientation": Take(("/odometry.pose.pose.orientation",), quaternion="xyzw"),
        "base_velocity": Take(("/odometry.twist.twist.linear",), frame="base"),
        "base_angular_velocity": Take(("/odometry.twist.twist.angular",)),
        "imu_acceleration": Take(("/imu.linear_acceleration",)),
    }  # fmt: skip
    assert (guess.feet, guess.joints, guess.guessed) == ((), (), True)


@pytest.mark.parametrize(("count", "known"), [(12, True), (11, False)])
def test_the_state_of_a_unitree_has_twelve_motors(count: int, known: bool) -> None:
    motors = tuple(f"motor_state[{k}].q" for k in range(count))
    guess = messages(low=("unitree/LowState_", ("x",)), state=("go/LowState", (*motors, "foot_force")))
    assert guess.feet == ("FR", "FL", "RR", "RL")
    assert guess.joints[:4] == ("FR_hip_joint", "FR_thigh_joint", "FR_calf_joint", "FL_hip_joint")
    assert len(guess.joints) == 12
    assert guess.channels["foot_sensors"] == Take(("/state.foot_force",))
    assert ("torques" in guess.channels) == known
    if known:
        velocities = tuple(f"/state.motor_state[{k}].dq" for k in range(12))
        assert guess.channels["joint_velocities"] == Take(velocities)
