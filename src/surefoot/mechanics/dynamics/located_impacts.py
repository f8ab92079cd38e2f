"""A step in which something that flies touches: the time of each touch is found inside the step.

At the middle of a step an impact comes up to dt / 2 early or late, by as much as the grid says, whatever the
height of the fall: the motion is right to first order, its derivative with respect to what moves the touch in
time can be wrong by any amount. Here the step is flown to the root of the gap; impulses and restitution act
there, and what is left of the step goes on behind them. Its derivative has the saltation term
(`derivative.saltation`).

A contact that touches more slowly than gravity makes in two steps is not an impact: what is left of the step
is then an ordinary one, so that bounces end, and a contact at rest makes no events. Several touches in a step
are taken one after the other, up to `EVENTS`; those within `TOUCH` at once. While a contact presses, others
are met in the middle of the step; a corner that dips into the ground and out of it within one is not seen.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.mechanics.dynamics.bodies import Bodies
from surefoot.mechanics.dynamics.detection import Contacts
from surefoot.mechanics.dynamics.free_motion import Ahead, moved
from surefoot.mechanics.dynamics.impacts import Meeting, Tally
from surefoot.mechanics.dynamics.options import StepOptions
from surefoot.mechanics.dynamics.state import Impact, Piece, State, Step, StepRemainder, grown

EVENTS = 16
"""Most touches of one step; after them what is left is an ordinary step."""
TOUCH = 1e-10
"""Gap of a contact that touches [m]."""
SEARCH = 60
"""Most Newton steps to a touch; a few do."""


class ImpactModel(Protocol):
    """What a step with located impacts needs: contacts, impulses and an ordinary step; a `Stepper` is one.

    Attributes
    ----------
    options
        Of a step; its dt is the whole step's.
    bodies
        What moves.
    """

    options: StepOptions
    bodies: Bodies

    def contacts(self, state: State) -> Contacts:
        """Return the contact points at a state."""

    def detect(self, q: FloatArray) -> Contacts:
        """Return the contacts at (nq,) q [m, -, rad], in work arrays."""

    def meeting(
        self, q: FloatArray, before: FloatArray, free: FloatArray, contacts: Contacts, horizon: float,
        mu: float, tally: Tally,
    ) -> Meeting:  # fmt: skip
        """Return the contacts about to exchange impulses at (nq,) q with (nv,) before and free."""

    def meet_ground(
        self, state: State, effort: FloatArray, push: FloatArray | None, mu: float,
        seconds: float | None = None,
    ) -> Step:  # fmt: skip
        """Return an ordinary step of `seconds` [s] under (nv,) effort and a (3,) push on the base [N]."""


def touching_step(stepper: ImpactModel, state: State, effort: FloatArray, mu: float) -> Step | None:
    """Return the step from a state in the air under (nv,) forces [N, N m], with its touches where they are.

    None where a contact presses or touches slowly from the start: the step is then an ordinary one.
    """
    tally, left, pieces = Tally(), stepper.options.dt, list[Piece]()
    seen, last = stepper.contacts(state), None
    nothing = np.zeros(seen.positions.shape)
    total, velocities = nothing, seen.velocities(state.v)
    while left > 0.0 and (found := first_touch(stepper, state, effort, left)) is not None:
        seconds, (q, v, _), touching = found
        if not touching.any():
            pieces.append(Piece(state, left))
            left = 0.0
        elif len(pieces) == EVENTS:
            break
        else:
            seen = stepper.contacts(State(q, v))
            last = struck(stepper, q, v, touching, mu, tally)
            pieces.append(Piece(state, seconds, last, int(np.flatnonzero(touching)[0])))
            total = grown(total, len(last.impulses)) + last.impulses
            velocities = last.leaving
            left, v = left - seconds, last.after
        state = State(q, v, state.steps, StepRemainder(nothing, velocities, True))
    if last is None:
        if left > 0.0:
            return None
        pieces = []  # a flight
    elif left > 0.0:
        # Who presses or touches slowly has no root of its gap to go to: what is left is an ordinary, shorter
        # step.
        rest = stepper.meet_ground(state, effort, None, mu, left)
        pieces.append(Piece(state, left, rest=rest))
        total = grown(total, len(rest.impulses)) + rest.impulses
        state = rest.state._replace(steps=state.steps)
        tally.unsolved, tally.worst = tally.unsolved + rest.unsolved, max(tally.worst, rest.worst_residual)
    return Step(
        state._replace(steps=state.steps + 1), stepper.options.dt, total, velocities, seen.gaps,
        seen.positions, last, tally.unsolved, tally.worst, pieces=tuple(pieces),
    )  # fmt: skip


def first_touch(
    stepper: ImpactModel, state: State, effort: FloatArray, seconds: float
) -> tuple[float, Ahead, BoolArray] | None:
    """Return when a flight of `seconds` [s] from a state first touches, where, and which (p,) contacts do.

    None of them where it ends in the air. Nothing is returned if a contact presses already, or would touch
    too slowly to bounce.
    """
    (q, v), slow = state[:2], stepper.options.rest_speed
    start = stepper.detect(q)
    speeds = start.velocities(v)[:, 2]
    pressed = (start.gaps <= TOUCH) & (speeds <= 0.0)
    if pressed.any():
        return None if (speeds[pressed] >= -slow).any() else (0.0, Ahead(q, v, None), pressed)
    low, after, high = 0.0, seconds, np.inf
    for _ in range(SEARCH):
        ahead = moved(stepper.bodies.flight, q, v, after, effort)
        seen = stepper.detect(ahead.q)
        speeds = seen.velocities(ahead.v)[:, 2]
        late = (seen.gaps < -TOUCH) & (speeds < 0.0)
        touching = (seen.gaps <= TOUCH) & (speeds < 0.0) & (after < seconds)  # else the next step's
        if not late.any() and (after == seconds or touching.any()):
            slowly = touching.any() and (speeds[touching] >= -slow).all()
            return None if slowly else (after, ahead, touching)
        # Newton on the gap of whoever touches first, halved where it leaves the bracket
        closing = late if late.any() else speeds < 0.0
        low, high = (low, after) if late.any() else (after, high)
        turn = seen.gaps[closing] / speeds[closing]
        after -= float(turn.max()) if turn.size else np.inf
        if not low < after < high:
            after = 0.5 * (low + high)
    return None


def struck(
    stepper: ImpactModel, q: FloatArray, v: FloatArray, touching: BoolArray, mu: float, tally: Tally
) -> Impact:
    """Return the impulses on those of the (p,) contacts at (nq,) q, (nv,) v that touch; no time goes by."""
    seen = stepper.detect(q)
    # Contacts that do not touch at this instant are infinitely far, so that no impulse of the others takes
    # them in.
    level = seen._replace(gaps=np.where(touching, 0.0, np.inf))
    stepper.bodies.weigh(q)
    meeting = stepper.meeting(q, v, v, level, stepper.options.dt, mu, tally)
    nothing = np.zeros(seen.positions.shape)
    return meeting.collide(np.flatnonzero(touching), nothing, nothing)
