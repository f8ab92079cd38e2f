"""Signals of a story from logs made by hand: each number by its closed form, and what stands in for it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio
import pytest

from surefoot.records.audit.story.signals import Signals
from tests.records.audit.made_signals import made_signals

T, DT, MASS, G = 12, 0.004, 5.0, 9.81
WEIGHT = MASS * G
RNG = np.random.default_rng(3)
TIME = DT * np.arange(T)


def signals(facts: dict[str, Any] | None = None, /, **arrays: Any) -> Signals:
    """Return the signals of a log of two contact points, one a foot, without any force unless given."""
    known = {"time": TIME, "forces": np.zeros((T, 2, 3)), **arrays}
    return made_signals(known, facts or {}, ("a", "b"), WEIGHT, DT)


def turns(*angles: tuple[float, float, float]) -> Any:
    return np.array([pinocchio.Quaternion(pinocchio.rpy.rpyToMatrix(*one)).coeffs() for one in angles])


def free(angles: Any = None, place: Any = None, joints: int = 2) -> dict[str, Any]:
    """Return q and v of a floating base, upright and at rest unless given."""
    q = np.zeros((T, 7 + joints))
    q[:, 3:7] = [0.0, 0.0, 0.0, 1.0] if angles is None else angles
    q[:, :3] = 0.0 if place is None else place
    return {"q": q, "v": np.zeros((T, 6 + joints))}


def pressed(normal: Any, side: Any = 0.0) -> Any:
    f = np.zeros((T, 2, 3))
    f[..., 2], f[..., 0] = normal, side
    return f


def test_rows_are_a_time_over_the_step_one_at_least() -> None:
    one = signals()
    assert [one.rows(s) for s in (0.0, 0.004, 0.0101, 0.02)] == [1, 1, 3, 5]
    assert "gaps" not in one
    assert "forces" in one
    still = signals()
    still.dt = 0.0
    assert still.rows(5.0) == 1


def test_gravity_is_the_logs_and_up_is_against_it() -> None:
    np.testing.assert_array_equal(signals().gravity, [0.0, 0.0, -9.81])
    tilted = signals({"gravity": [3.0, 0.0, -4.0]})
    np.testing.assert_allclose(tilted.up, [-0.6, 0.0, 0.8])
    np.testing.assert_allclose(signals({"gravity": [0.3, 0.0, -0.4]}).up, [-0.6, 0.0, 0.8])
    np.testing.assert_array_equal(signals({"gravity": [0.0, 0.0, 0.0]}).up, [0.0, 0.0, 1.0])
    assert signals().mass == pytest.approx(MASS)
    np.testing.assert_allclose(tilted.level_axes @ tilted.up, 0.0, atol=1e-12)
    np.testing.assert_allclose(tilted.level_axes @ tilted.level_axes.T, np.eye(2), atol=1e-12)


RISES, AHEAD, TURN = [0, 0, 1, 0, 0, 0], [1, 0, 0, 0, 0, 0], [0, 0, 0, 0, 1, 0]


@pytest.mark.parametrize(("wrenches", "turn", "floating"), [
    ([AHEAD, RISES, TURN], 2, True), ([TURN, RISES], 0, True), ([RISES, AHEAD], None, True),
    ([AHEAD, TURN], None, False), ([TURN, RISES, TURN], None, True), ([RISES], None, True),
    ([TURN], None, False),
    ([RISES, AHEAD, TURN, AHEAD, AHEAD, AHEAD], None, True), ([RISES, AHEAD, TURN, AHEAD, AHEAD], None, True),
    ([[1, 2]], None, False), ([0, 0, 1], None, False),
])  # fmt: skip
def test_a_base_in_an_upright_plane_turns_by_one_of_its_joints(
    wrenches: Any, turn: int | None, floating: bool
) -> None:
    one = signals(
        {"free_wrenches": wrenches}, q=np.zeros((T, 4)), v=np.zeros((T, 4)), torques=np.zeros((T, 1))
    )
    assert one.plane_turn == turn
    assert one.floating == floating
    bare = signals({"free_wrenches": wrenches})
    assert (bare.plane_turn, bare.floating) == (None, False)


def test_a_base_of_five_ways_turns_in_a_plane_too() -> None:
    wrenches = [RISES, AHEAD, TURN, AHEAD, AHEAD]
    assert signals({"free_wrenches": wrenches}, q=np.zeros((T, 5))).plane_turn == 2
    assert signals({"free_wrenches": [*wrenches, AHEAD]}, q=np.zeros((T, 6))).plane_turn is None


def test_a_base_is_bolted_where_its_model_has_no_free_joint() -> None:
    for facts, bolted in (
        ({}, False),
        ({"model_joint_kinds": ["free", "hinge"]}, False),
        ({"model_joint_kinds": ["hinge"]}, True),
        ({"model_joint_kinds": ["slide"], "free_wrenches": [RISES]}, False),
    ):
        assert signals(facts).bolted == bolted


def test_the_lean_is_the_angle_between_up_axes() -> None:
    angles = turns(*[(0.1, 0.0, 0.5)] * 6, *[(0.1, 0.0, 2.0)] * 3, *[(0.4, 0.0, 0.5)] * 3)
    lean = signals(**free(angles)).lean
    up = np.array([pinocchio.Quaternion(row).matrix()[:, 2] for row in angles])
    np.testing.assert_allclose(lean, np.arccos(np.clip(up @ up[0], -1.0, 1.0)), atol=1e-7)
    assert lean[-1] == pytest.approx(0.3)
    angles[4] = np.nan
    assert signals(**free(angles)).lean[4] == pytest.approx(0.0, abs=1e-7)
    assert not signals().lean.any()
    assert signals().lean.shape == (T,)


def test_the_lean_in_a_plane_is_the_angle_from_the_first() -> None:
    q = np.zeros((T, 3))
    q[:, 2] = 0.5 - 0.1 * np.arange(T)
    one = signals({"free_wrenches": [AHEAD, RISES, TURN]}, q=q, v=np.zeros((T, 3)), torques=np.zeros((T, 1)))
    np.testing.assert_allclose(one.lean, 0.1 * np.arange(T))
    np.testing.assert_array_equal(one.base_state[:, 0], q[:, 2])
    assert one.base_state.shape == (T, 4)


def test_the_centre_of_mass_is_the_logs_else_the_base() -> None:
    place, com = np.outer(TIME**2, [1.0, 2.0, 0.0]), RNG.normal(size=(T, 3))
    one = signals(**free(place=place))
    np.testing.assert_array_equal(one.com, place)
    np.testing.assert_allclose(one.com_velocity[1:-1], np.outer(2.0 * TIME, [1.0, 2.0, 0.0])[1:-1])
    np.testing.assert_array_equal(signals(**free(place=place), com=com).com, com)
    momentum = RNG.normal(size=(T, 6))
    np.testing.assert_allclose(signals(momentum=momentum).com_velocity, momentum[:, :3] / MASS)
    assert not signals().com.any()
    assert signals().com.shape == (T, 3)


def test_contacts_are_feet_on_ground_unless_the_log_tells_otherwise() -> None:
    loads = pressed([[WEIGHT, 0.0]] * 4 + [[0.0, WEIGHT]] * 8)
    one = signals(forces=loads)
    assert (one.is_foot.tolist(), one.on_movable.tolist()) == ([True, True], [False, False])
    assert list(one.feet_down) == ["a", "b"]
    assert one.feet_down["a"].tolist() == [True] * 4 + [False] * 8
    facts = {"contact_is_foot": [1, 0], "contact_other_moves": [0, 0], "contact_body": ["toe", "hand"]}
    other = signals(facts, forces=loads)
    assert other.links == ("toe", "hand")
    assert list(other.feet_down) == ["toe"]
    held = signals({"contact_is_foot": [1, 1], "contact_other_moves": [1, 0]}, forces=loads)
    assert held.ground_feet.tolist() == [False, True]
    pair = signals({"contact_body": ["toe", "toe"]}, forces=loads)
    assert pair.feet_down["toe"].tolist() == [True] * T
    assert (one.base, signals({"model_bodies": ["torso", "leg"]}).base) == ("body", "torso")


def test_normals_are_up_where_there_are_none() -> None:
    normals = np.tile([0.0, 0.6, 0.8], (T, 2, 1))
    normals[3, 1], normals[4, 0] = 0.0, [0.0, 1.2, 1.6]
    one = signals(normals=normals)
    np.testing.assert_allclose(one.normals[3], [[0.0, 0.6, 0.8], [0.0, 0.0, 1.0]])
    np.testing.assert_allclose(one.normals[4, 0], [0.0, 0.6, 0.8])
    np.testing.assert_allclose(signals().normals, np.tile([0.0, 0.0, 1.0], (T, 2, 1)))
    loads = RNG.normal(size=(T, 2, 3))
    world = signals(normals=np.tile([0.0, 0.6, 0.8], (T, 2, 1)), forces=loads).world_forces
    np.testing.assert_allclose(np.einsum("tpi,i->tp", world, [0.0, 0.6, 0.8]), loads[..., 2])
    np.testing.assert_allclose(np.linalg.norm(world, axis=2), np.linalg.norm(loads, axis=2))


def test_contacts_are_loaded_from_two_percent_of_the_weight() -> None:
    loads = pressed(0.021 * WEIGHT)
    loads[:, 1, 2] = 0.019 * WEIGHT
    loads[:5] = 0.0
    one = signals(forces=loads)
    assert one.loaded[6].tolist() == [True, False]


def test_friction_is_each_contacts_or_the_grounds_or_without_end() -> None:
    own, ground = RNG.uniform(0.2, 1.0, (T, 2)), RNG.uniform(0.2, 1.0, T)
    np.testing.assert_array_equal(signals(contact_friction=own, mu=ground).mu, own)
    np.testing.assert_array_equal(signals(mu=ground).mu, np.stack([ground, ground], axis=1))
    assert np.isposinf(signals().mu).all()
    use = signals(forces=pressed(WEIGHT, 0.3 * WEIGHT), mu=np.full(T, 0.5)).friction_use
    np.testing.assert_allclose(use, 0.6)
    both = pressed(WEIGHT, 0.3 * WEIGHT)
    both[..., 1], both[:, 1, 2] = 0.4 * WEIGHT, 0.001
    use = signals(forces=both, mu=np.full(T, 0.5)).friction_use
    np.testing.assert_allclose(use, [[1.0, 0.0]] * T)


def test_contacts_slide_that_are_loaded_fast_and_at_their_limit() -> None:
    velocities = np.zeros((T, 2, 3))
    velocities[..., 0], velocities[..., 1] = 0.03, 0.04
    loads = pressed(WEIGHT, 0.5 * WEIGHT)
    loads[:3, 0] = 0.0
    mu = np.full(T, 0.5)
    one = signals({"contact_is_foot": [1, 0]}, forces=loads, contact_velocities=velocities, mu=mu)
    np.testing.assert_allclose(one.slip_speed[3:], 0.048)
    assert not one.slip_speed[:3, 0].any()
    assert one.sliding[:, 0].tolist() == [False] * 3 + [True] * (T - 3)
    assert not one.sliding[:, 1].any()
    crept = signals(forces=loads, contact_velocities=velocities, mu=mu, contact_creep=np.full((T, 2), 0.025))
    np.testing.assert_allclose(crept.slip_speed[3:], 0.025)
    assert not crept.sliding.any()
    assert not signals(forces=loads, contact_velocities=velocities, mu=1.1 * mu).sliding.any()
    assert not signals(forces=loads).slip_speed.any()


def test_the_height_is_that_of_the_first_load_over_the_lowest_contact() -> None:
    loads = pressed(WEIGHT)
    loads[:4] = 0.0
    places = np.zeros((T, 2, 3))
    places[:, 0, 2], places[:, 1, 2], places[:4] = 0.1, -0.2, -9.0
    com = np.tile([0.0, 0.0, 0.5], (T, 1))
    com[5:] = 7.0
    one = signals(forces=loads, contact_positions=places, com=com)
    assert one.height == pytest.approx(0.7)
    assert one.pendulum_time == pytest.approx(np.sqrt(0.7 / 9.81))
    assert signals().height == 0.0
    assert signals().pendulum_time == pytest.approx(np.sqrt(1e-3 / 9.81))


def test_the_heading_is_the_bases_first_axis_across_gravity() -> None:
    angles = turns(*[(0.3, 0.4, 0.9)] * T)
    one = signals(**free(angles))
    expected = [[np.cos(0.9), np.sin(0.9), 0.0], [-np.sin(0.9), np.cos(0.9), 0.0]]
    np.testing.assert_allclose(one.heading[2], expected, atol=1e-12)
    bolted = signals()
    np.testing.assert_allclose(bolted.heading[3], bolted.level_axes)
    upright = turns(*[(0.0, -np.pi / 2, 0.0)] * T)
    assert np.linalg.det(np.vstack([signals(**free(upright)).heading[0], [0, 0, 1]])) == pytest.approx(1.0)


def test_the_capture_point_is_outside_by_its_way_to_the_feet() -> None:
    places = np.zeros((T, 2, 3))
    places[:, 0, 1], places[:, 1, 1] = 0.1, -0.1
    com = np.tile([0.0, 0.0, 0.4], (T, 1))
    momentum = np.tile([MASS * 0.5, 0.0, 0.0, 0.0, 0.0, 0.0], (T, 1))
    loads = pressed(WEIGHT)
    loads[8:] = 0.0
    one = signals(forces=loads, contact_positions=places, com=com, momentum=momentum)
    outside = one.capture_outside
    assert outside.shape == (T,)
    np.testing.assert_allclose(outside[:8], 0.5 * np.sqrt(0.4 / 9.81), rtol=1e-6)
    assert np.isnan(outside[8:]).all()


def test_torques_that_are_asked_for_are_held_between_ticks() -> None:
    torques, asked = RNG.normal(size=(T, 2)), np.repeat(RNG.normal(size=(4, 2)), 3, axis=0)
    one = signals(torques=torques, torques_commanded=asked)
    np.testing.assert_array_equal(one.asked, asked)
    assert (one.ticks.tolist(), one.hold) == ([0, 3, 6, 9], 3)
    own = signals(torques=torques)
    np.testing.assert_array_equal(own.asked, torques)
    assert (own.ticks.tolist(), own.hold) == (list(range(T)), 1)
    assert (signals().torques.shape, signals().hold) == ((T, 0), 1)
    assert signals(torques=np.zeros((T, 2))).ticks.tolist() == [0]


def test_limits_and_names_of_joints_are_the_logs_where_they_fit() -> None:
    torques = {"torques": np.zeros((T, 2))}
    both = {"effort_limits": [1.0, 2.0], "model_torque_limits": [5.0, 6.0]}
    assert signals(both, **torques).torque_limits.tolist() == [1.0, 2.0]
    assert signals({"model_torque_limits": [5.0, 6.0]}, **torques).torque_limits.tolist() == [5.0, 6.0]
    assert np.isposinf(signals({"effort_limits": [1.0]}, **torques).torque_limits).all()
    assert signals(**torques).torque_limits.shape == (2,)
    assert signals({"joints": ["hip", "knee"]}, **torques).joints == ("hip", "knee")
    assert signals({"joints": ["hip"]}, **torques).joints == ("joint 0", "joint 1")


def test_the_state_of_joints_is_the_last_of_q_and_v_unless_told() -> None:
    both = free()
    both["q"][:, -2:], both["v"][:, -2:] = RNG.normal(size=(T, 2)), RNG.normal(size=(T, 2))
    torques = np.zeros((T, 2))
    positions, velocities = signals(**both, torques=torques).joint_state
    np.testing.assert_array_equal(positions, both["q"][:, 7:])
    np.testing.assert_array_equal(velocities, both["v"][:, 6:])
    own = {"joint_positions": RNG.normal(size=(T, 2)), "joint_velocities": RNG.normal(size=(T, 2))}
    positions, velocities = signals(**both, torques=torques, **own).joint_state
    np.testing.assert_array_equal(positions, own["joint_positions"])
    np.testing.assert_array_equal(velocities, own["joint_velocities"])
    assert [part.shape for part in signals(torques=torques).joint_state] == [(T, 2)] * 2
    assert [part.shape for part in signals(**both).joint_state] == [(T, 0)] * 2


def test_the_state_of_a_free_base_is_lean_turning_and_way() -> None:
    both = free(turns(*[(0.2, 0.0, 0.0)] * T))
    both["v"][:, 3:6] = [0.1, 0.2, 0.3]
    momentum = np.tile([MASS * 0.5, MASS * -0.25, 0.0, 0.0, 0.0, 0.0], (T, 1))
    state = signals(**both, momentum=momentum).base_state
    up = np.array([0.0, np.sin(0.2)])  # up in base axes
    np.testing.assert_allclose(state[3], [*up, 0.1, 0.2, 0.3, 0.5, -0.25], atol=1e-12)
    assert signals().base_state.shape == (T, 0)


def test_the_first_of_enough_rows_is_found() -> None:
    where = np.array([0, 1, 0, 1, 1, 0, 1, 1, 1], dtype=bool)
    one = signals()
    assert [one.first(where, least) for least in (1, 2, 3, 4)] == [1, 3, 6, None]
    assert one.first(where) == 1


@pytest.mark.parametrize(("share", "came"), [(0.2, True), (0.3, False), (-0.3, True)])
def test_a_hand_goes_to_what_it_takes_up_where_its_place_moves(share: float, came: bool) -> None:
    """Both close in by 4 mm a row over the five rows before; the contact's place goes by a share of it."""
    velocities, places = np.zeros((T, 2, 3)), np.full((T, 2, 3), 5.0)
    velocities[3:8, 0, 2], velocities[2, 0, 2], velocities[8, 0, 2] = -1.0, 30.0, 30.0
    places[3, 0, 2], places[8, 0, 2] = 2.0, 2.0 - 0.02 * share
    facts, on = {"model_joint_kinds": ["hinge"]}, np.array([True, False])
    channels = {"contact_velocities": velocities, "contact_positions": places}
    assert signals(facts, **channels).came_at(8, on) == came
    assert signals(**channels).came_at(8, on)
    assert signals(facts, contact_positions=places).came_at(8, on)
    assert signals(facts, **channels).came_at(8, ~on)
    assert signals(facts, **channels).came_at(8, np.zeros(2, dtype=bool))
    velocities[3:8, 0, 2] = 1.0
    assert signals(facts, **channels).came_at(8, on)


def test_what_touches_in_the_first_row_came_by_itself() -> None:
    channels = {"contact_velocities": np.full((T, 2, 3), -1.0), "contact_positions": np.zeros((T, 2, 3))}
    channels["contact_positions"][1, :, 2] = -1.0
    one = signals({"model_joint_kinds": ["hinge"]}, **channels)
    assert one.came_at(0, np.array([True, True]))
    assert not one.came_at(1, np.array([True, True]))
