"""What a tracker tells its estimator, step by step: contacts, stances, torques; and what it returns."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from surefoot.motion.control.controller import Command
from surefoot.motion.drive.state_tracker import StateTracker
from surefoot.motion.estimation.state_estimator import Health, Reading
from tests.robots import go2

ROBOT = go2()
SENSED = np.array([True, False, True, False])
SPEED = np.linspace(-1.0, 1.0, 12)


class Recorder:
    """An estimator that records what it is told; feet touch that were told not to."""

    def __init__(self) -> None:
        self.told: list[tuple[str, Any]] = []
        self.forces, self.health = np.ones((4, 3)), Health.GOOD

    def reset(self, q: Any) -> None:
        self.told.append(("reset", q))

    def predict(self, reading: Any) -> Any:
        self.told.append(("predict", reading))
        return SENSED

    def decide(self, measured: Any) -> Any:
        self.told.append(("decide", measured))
        return ~measured

    def update(self, touching: Any, standing: Any = None) -> Any:
        self.told.append(("update", (touching, standing)))
        return ROBOT.nominal, np.concatenate([np.full(6, 9.0), SPEED])

    def expect(self, pushing: Any, planned: Any) -> None:
        self.told.append(("expect", (pushing, planned)))

    def applied(self, torques: Any) -> None:
        self.told.append(("applied", torques))

    def last(self, name: str) -> Any:
        """Return what it was told last of a kind."""
        return next(value for kind, value in reversed(self.told) if kind == name)


def tracker(**words: Any) -> tuple[StateTracker, Recorder]:
    """Return a tracker whose estimator records."""
    out, recorder = StateTracker(ROBOT, 0.002, **words), Recorder()
    out.estimator = recorder  # type: ignore[assignment]
    return out, recorder


READING = Reading(np.zeros(3), np.array([0.0, 0.0, 9.81]), ROBOT.nominal[7:], np.zeros(12))


class Planned(Command):
    """A command that says which feet should stand."""

    def rows(self) -> dict[str, Any]:
        return {"planned": np.array([1.0, 0.0, 0.0, 1.0])}


def test_a_tracker_starts_at_rest_where_the_robot_stands() -> None:
    estimator = StateTracker(ROBOT, 0.002).estimator
    assert estimator.health is Health.GOOD
    np.testing.assert_allclose(estimator.ekf.q, ROBOT.nominal, atol=1e-9)
    assert not estimator.ekf.v.any()
    assert estimator.ekf.dt == 0.002


def test_a_reading_becomes_a_state_with_forces_of_its_own() -> None:
    own, told = tracker()
    state = own.state(READING, 1.5)
    assert told.last("predict") is READING
    np.testing.assert_array_equal(told.last("decide"), SENSED)
    np.testing.assert_array_equal(told.last("update")[0], ~SENSED)
    np.testing.assert_array_equal(state.contact, ~SENSED)
    assert state.time == 1.5
    np.testing.assert_array_equal(state.q, ROBOT.nominal)
    np.testing.assert_array_equal(state.v[6:], SPEED)
    told.forces[:] = 7.0
    assert state.forces is not None
    assert (state.forces == 1.0).all()


def test_sensors_in_the_feet_know_better() -> None:
    own, told = tracker()
    touch = np.array([True, True, False, False])
    own.state(READING, 0.0, lambda sensed: touch & sensed)
    np.testing.assert_array_equal(told.last("decide"), touch & SENSED)


def test_feet_that_push_are_those_of_active_points_until_the_next_command() -> None:
    own, told = tracker()
    own.state(READING, 0.0)
    assert told.last("update")[1] is None
    active = np.array([True, False, False, True])
    own.plan(Command(np.zeros(12), np.zeros((4, 3)), active))
    for part in told.last("expect"):
        np.testing.assert_array_equal(part, active)  # those that push should stand, for nothing else is said
    own.state(READING, 0.0)
    np.testing.assert_array_equal(told.last("update")[1], active)
    own.plan(Planned(np.zeros(12), np.zeros((4, 3)), active & SENSED))
    pushing, planned = told.last("expect")
    np.testing.assert_array_equal(pushing, [True, False, False, False])
    np.testing.assert_array_equal(planned, [True, False, False, True])
    assert planned.dtype == np.bool_


def test_points_belong_to_feet() -> None:
    """Of a command with eight points, two to a foot."""
    own, told = tracker(point_foot=[0, 0, 1, 1, 2, 2, 3, 3])
    active = np.zeros(8, dtype=bool)
    active[[3, 4]] = True
    own.plan(Command(np.zeros(12), np.zeros((8, 3)), active))
    np.testing.assert_array_equal(told.last("expect")[0], [False, True, True, False])


def test_a_command_that_says_nothing_of_feet_leaves_even_odds() -> None:
    own, told = tracker()
    own.plan(Command(np.zeros(12), np.zeros((4, 3)), np.ones(4, dtype=bool)))
    own.plan(Command(np.zeros(12)))
    pushing, planned = told.last("expect")
    assert not pushing.any()
    assert planned.all()
    own.state(READING, 0.0)
    assert told.last("update")[1] is None


def test_a_beginning_forgets_who_stands() -> None:
    own, told = tracker()
    own.plan(Command(np.zeros(12), np.zeros((4, 3)), np.ones(4, dtype=bool)))
    q = ROBOT.nominal + 0.0
    own.begin(q)
    assert told.last("reset") is q
    own.state(READING, 0.0)
    assert told.last("update")[1] is None


def test_motors_give_what_friction_leaves_at_the_last_speeds() -> None:
    torques = np.full(12, 3.0)
    own, told = tracker()
    own.note_torques(torques)
    np.testing.assert_array_equal(told.last("applied"), torques)
    lossy: Any = SimpleNamespace(losses=lambda speed: 0.5 * speed)
    own, told = tracker(actuators=lossy)
    own.note_torques(torques)
    np.testing.assert_array_equal(told.last("applied"), torques)
    own.state(READING, 0.0)
    own.note_torques(torques)
    np.testing.assert_allclose(told.last("applied"), torques - 0.5 * SPEED)


@pytest.mark.parametrize("health", list(Health))
def test_a_failure_is_told_while_there_is_one(health: Health) -> None:
    own, told = tracker()
    told.health = health
    assert own.failure == ("" if health is Health.GOOD else str(health))
