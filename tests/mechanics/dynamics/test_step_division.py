"""How a step is divided for a stated error, worked out by hand for a slide that Euler's steps move."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pinocchio
import pytest

from surefoot.base.errors import SimulationError
from surefoot.mechanics.dynamics.error_control import ErrorControl
from surefoot.mechanics.dynamics.options import StepOptions
from surefoot.mechanics.dynamics.state import State, Step, StepRemainder


class Slide:
    """A slide: x grows by h v, v by h a + c h², and x by an event besides.

    Between a step and its halves lie h² a / 4 and what is less than a thousandth of it in x, c h² / 2 in v.
    """

    def __init__(self, dt: float, a: float = 0.0, c: float = 0.0, event: float = 0.0) -> None:
        self.options, self.a, self.c, self.event = StepOptions(dt), a, c, event
        model = pinocchio.Model()
        model.addJoint(0, pinocchio.JointModelPX(), pinocchio.SE3.Identity(), "slide")
        self.bodies = SimpleNamespace(model=model)
        self.made: list[tuple[float, float]] = []
        self.lost_at = -1

    def step(self, state: State, torques: Any, push: Any, mu: float) -> Step:
        """Return the next state; a contact is there, and from the fifth step on another one."""
        h = self.options.dt
        if len(self.made) == self.lost_at:
            raise SimulationError("slide", 9.0, h, "none", 0.0)
        self.made.append((h, state.memory.pace if state.memory is not None else 0.0))
        q = state.q + h * state.v + self.event
        v = state.v + h * self.a + self.c * h * h
        count = len(self.made)
        contacts = 1 if count < 5 else 2
        impulses = np.full((contacts, 3), h)
        impact: Any = f"impact {count}" if count == 5 else None
        memory = StepRemainder(impulses, impulses, False)
        gaps = np.full(contacts, float(count))
        return Step(
            State(q, v, state.steps + 1, memory), h, impulses, impulses, gaps, impulses, impact, 1, h, 2.0 * h
        )

    def told(self, what: str, state: State) -> SimulationError:
        return SimulationError(what, state.steps * self.options.dt, self.options.dt, "slide", 0.0)


START = State(np.zeros(1), np.zeros(1), 7, StepRemainder(np.zeros((1, 3)), np.zeros((1, 3)), False))


def controlled(slide: Slide, tol: float) -> ErrorControl:
    """Return the control of a slide."""
    stepper: Any = slide
    return ErrorControl(stepper, tol)


def test_a_step_is_halved_until_its_error_fits_the_budget() -> None:
    """By hand, for an error of h² / 4 and a tolerance of 0.01, of which 0.005 are there at first.

    h = 0.1: 0.0025 of 0.0005 + 0.0005: refused. 0.05: 0.000625 of 0.00025 + 0.0005: kept, and 0.004625 are
    left. 0.0493 are suggested, the half of what is left is 0.025: 0.00015625 of 0.000125 + 0.0004625. The
    last 0.025 go at once, as 0.0436 are suggested.
    """
    slide = Slide(0.1, a=1.0)
    control = controlled(slide, 0.01)
    step = control.step(START, np.zeros(1))
    assert [piece.seconds for piece in step.pieces] == pytest.approx(2 * [0.025] + 4 * [0.0125])
    assert (control.taken, control.refused) == (3, 1)
    assert control.error == pytest.approx(0.000625 + 2 * 0.00015625)
    made = [h for h, _ in slide.made]
    # the first half of what was refused is the next whole step
    assert made == pytest.approx(
        [0.1, 0.05, 0.05, 0.025, 0.025, 0.025, 0.0125, 0.0125, 0.025, 0.0125, 0.0125]
    )
    assert step.state.v[0] == pytest.approx(0.1)
    assert step.state.q[0] == pytest.approx(0.025**2 + 0.0125 * (0.05 + 0.0625 + 0.075 + 0.0875))
    assert step.state.steps == 8
    slide.made.clear()
    control.step(step.state, np.zeros(1))
    assert slide.made[0][0] == pytest.approx(0.025 * 0.9 / np.sqrt(0.00015625 / 0.000584375))


def test_a_part_knows_its_length_over_the_mean_of_its_own_and_the_last() -> None:
    """Two behind nothing, one behind its like, and 2 / 3 for a half behind a whole."""
    slide = Slide(0.1, a=1.0)
    controlled(slide, 0.01).step(START, np.zeros(1))
    paces = [pace for _, pace in slide.made]
    assert paces == pytest.approx([2.0, 2.0, 1.0, 2.0, 1.0, 1.0, 2.0 / 3.0, 1.0, 4.0 / 3.0, 1.0, 1.0])


def test_a_calm_step_is_taken_at_once_and_earns_no_more_than_half_the_tolerance() -> None:
    slide = Slide(0.1)
    control = controlled(slide, 0.01)
    for _ in range(3):
        step = control.step(START, np.zeros(1))
    assert [h for h, _ in slide.made] == pytest.approx(3 * [0.1, 0.05, 0.05])
    assert (control.taken, control.refused, control.error) == (3, 0, 0.0)
    assert len(step.pieces) == 2


@pytest.mark.parametrize(("c", "parts"), [(0.19, 1), (0.21, 2)])
def test_velocities_may_be_off_by_a_tenth_of_the_tolerance(c: float, parts: int) -> None:
    """c 0.1² / 2 against 0.001."""
    control = controlled(Slide(0.1, c=c), 0.01)
    control.step(START, np.zeros(1))
    assert control.taken >= parts
    assert (control.refused > 0) is (parts > 1)


def test_an_event_is_met_by_halving_down_to_two_microseconds() -> None:
    """20 µs: 20, 10 and 5 are refused, 2.5 is kept; seven of 2 follow, and one of the 3.5 that are left."""
    control = controlled(Slide(2e-5, event=1.0), 1e-3)
    step = control.step(START, np.zeros(1))
    assert (control.taken, control.refused) == (9, 3)
    seconds = np.array([piece.seconds for piece in step.pieces])
    np.testing.assert_allclose(seconds, np.repeat([1.25e-6, *7 * [1e-6], 1.75e-6], 2), rtol=1e-9)
    assert control.error == pytest.approx(9.0)


def test_parts_are_told_as_one_step() -> None:
    """Impulses add up, of contacts that came later from there on; what was seen is the last impact's."""
    slide = Slide(0.1, a=1.0)
    step = controlled(slide, 0.01).step(START, np.zeros(1))
    assert step.dt == 0.1
    assert step.unsolved == 6
    assert step.worst_residual == pytest.approx(0.025)
    assert step.law_error == pytest.approx(0.05)
    # the first of the parts that are kept is the fourth that was made, and has one contact
    np.testing.assert_allclose(step.impulses, [3 * [0.1], 3 * [0.075]])
    assert str(step.impact) == "impact 5"
    assert step.gaps.tolist() == [5.0, 5.0]


def test_options_ask_for_located_touches_and_a_finer_solver() -> None:
    slide = Slide(0.1)
    assert controlled(slide, 1e-3).options == StepOptions(0.1, impacts="located", solver_tol=1e-9)
    assert controlled(slide, 1.0).options.solver_tol == 1e-8


def test_a_lost_part_leaves_everything_as_it_was() -> None:
    slide = Slide(0.1, a=1.0)
    control = controlled(slide, 0.01)
    before = control.step(START, np.zeros(1))
    spent = control.error, control.taken, control.refused
    slide.lost_at = len(slide.made) + 4
    with pytest.raises(SimulationError, match=r"at 0\.8 s the slide"):
        control.step(before.state, np.zeros(1))
    assert (control.error, control.taken, control.refused) == spent
    assert slide.options is control.options
    slide.lost_at = -1
    again = control.step(before.state, np.zeros(1))
    fresh = controlled(Slide(0.1, a=1.0), 0.01)
    fresh.step(START, np.zeros(1))
    once = fresh.step(before.state, np.zeros(1))
    assert [p.seconds for p in again.pieces] == [p.seconds for p in once.pieces]
    assert control.error == fresh.error
