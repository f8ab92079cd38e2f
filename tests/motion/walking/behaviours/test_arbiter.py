"""What is merged of several requests, by the rules of one table, and who the log says has asked for it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from surefoot.motion.walking.behaviours.arbiter import LOGGED, RULES, Arbiter
from surefoot.motion.walking.behaviours.behaviour import NOTHING, FootSearch, Request, WalkView
from tests.motion.walking.behaviours.views import RADIUS, view_of


class Asking:
    """Asks for the same in every step."""

    def __init__(self, name: str, **asked: object) -> None:
        self.name, self.request = name, Request(**asked) if asked else NOTHING  # type: ignore[arg-type]

    def reset(self) -> None:
        """Forget nothing."""

    def propose(self, view: WalkView) -> Request:
        """Return the request."""
        return self.request


def merged(*asking: Asking, command: tuple[float, float, float] = (0.4, 0.0, 0.0)) -> Arbiter:
    """Return an arbiter that has merged requests once."""
    arbiter = Arbiter(asking, RADIUS, [])
    arbiter.merge(view_of(command))
    return arbiter


def asked_by(arbiter: Arbiter, quantity: str) -> int:
    """Return the rank of who has got its way."""
    return int(arbiter.asked_by[LOGGED.index(quantity)])


def test_every_quantity_but_the_note_has_a_rule() -> None:
    assert set(RULES) | {"note"} == set(Request._fields)
    assert set(LOGGED) == set(RULES)


@pytest.mark.parametrize(
    ("quantity", "high", "low", "winner"),
    [
        ("speed_cap", 0.5, 0.2, 1),
        ("pace", 0.5, 0.1, 1),
        ("clearance", 0.02, 0.05, 1),
        ("mu", 0.5, 0.2, 1),
        ("height", 0.3, 0.25, 1),
        ("search", FootSearch(0.1), FootSearch(0.4), 0),
        ("velocity", np.ones(3), np.zeros(3), 0),
        ("foot_goals", min, max, 0),
    ],
)
def test_who_gets_his_way(quantity: str, high: object, low: object, winner: int) -> None:
    asking = Asking("high", **{quantity: high}), Asking("none"), Asking("low", **{quantity: low})
    arbiter = merged(*asking)
    assert getattr(arbiter.merge(view_of()), quantity) is (low if winner else high)
    assert asked_by(arbiter, quantity) == 2 * winner
    assert sum(rank >= 0 for rank in arbiter.asked_by) == 1
    alone = merged(Asking("none"), Asking("low", **{quantity: low}))
    assert getattr(alone.merge(view_of()), quantity) is low
    assert asked_by(alone, quantity) == 1


def test_what_the_walk_cannot_do_is_refused() -> None:
    asking = Asking("high", hold=True, mu=0.3), Asking("low", clearance=0.02, mu=0.2)
    arbiter = Arbiter(asking, RADIUS, [], frozenset(("mu", "speed_cap")))
    request = arbiter.merge(view_of())
    assert (request.hold, request.clearance, request.mu) == (False, 0.0, 0.2)
    assert [asked_by(arbiter, name) for name in ("hold", "clearance", "mu")] == [-1, -1, 1]


def test_the_velocity_is_the_command_within_caps_at_the_pace() -> None:
    free = merged(Asking("none"))
    assert free.velocity.tolist() == free.asked.tolist() == [0.4, 0.0, 0.0]
    assert free.merge(view_of()) is NOTHING
    command = (0.3, 0.4, 1.0)
    capped = merged(Asking("cap", speed_cap=0.3), Asking("slow", pace=0.5), command=command)
    size = math.hypot(*command[:2]) + RADIUS
    assert capped.asked == pytest.approx(np.array(command) * 0.3 / size)
    assert capped.velocity == pytest.approx(0.5 * capped.asked)
    other = merged(Asking("other", velocity=np.array([-0.1, 0.0, 0.0])))
    assert other.velocity.tolist() == [-0.1, 0.0, 0.0]


def test_a_velocity_that_the_gait_is_not_fit_for_is_not_passed() -> None:
    now = np.array([0.2, 0.0, 0.0])
    arbiter = Arbiter([Asking("gait", at_most=now)], RADIUS, [])
    arbiter.merge(view_of((0.4, 0.0, 0.0), velocity=now))
    assert arbiter.velocity.tolist() == [0.2, 0.0, 0.0]
    arbiter.merge(view_of((0.1, 0.0, 0.0), velocity=now))
    assert arbiter.velocity.tolist() == [0.1, 0.0, 0.0]


def test_notes_are_said_once_and_taken_back() -> None:
    notes = ["slowed"]
    arbiter = Arbiter([Asking("one", note="stopped")], RADIUS, notes)
    for _ in range(3):
        arbiter.merge(view_of())
    assert notes == ["slowed", "stopped"]
    arbiter.reset()
    assert notes == ["slowed"]
