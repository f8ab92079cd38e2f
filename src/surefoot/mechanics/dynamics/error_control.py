"""Steps whose length follows from a stated error: whole steps against two halves, and a budget for the rest.

A step of h is taken whole and in two halves, and the halves go on. What lies between the two ends is the
error's estimate: of a scheme of order p it is 2^p - 1 times that of the halves, and of a contact that closes,
opens or sticks somewhere inside, met at the middle of whichever step it falls into, at least that of the
halves too. Such an event cannot be stepped over, only shrunk: steps are halved down to it, and the first half
of a step that is refused is the next whole one. Touches out of free flight are located (`located`).

Errors of positions add up. Their estimates are spent from a budget: half the tolerance at the start, and half
of it for every second; a step may take what its own length brings and `SHARE` of what is left. Velocities are
put right by the contacts of every step anew, so each is only held to `SHARE` of the tolerance. What the
motion itself makes of an error afterwards, as of a body that tips over, is not in it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from surefoot.base.arrays import FloatArray, real_number
from surefoot.base.errors import SimulationError
from surefoot.base.memory import Remembering
from surefoot.mechanics.dynamics.state import Piece, State, Step
from surefoot.mechanics.dynamics.stepper import Stepper

SHARE = 0.1
"""Part of the budget that is left which one step may spend, and of the tolerance that velocities may."""
SHORTEST = 2e-6
"""Steps are not halved below [s]: an event is then met so early or late."""
NOISE = 1e-6
"""Solver's tolerance, of velocities, as a share of the state's: its own error must not look like a step's."""
GROW, SAFETY = 4.0, 0.9
"""Most that a step grows by, and how far below the length that its error suggests it stays."""


class ErrorControl(Remembering):
    """Takes steps of a stepper's dt in as many parts as a stated error of the state asks for.

    Parameters
    ----------
    stepper
        What takes the parts; its options' length is changed on the way.
    tol
        Error of the state: [m, rad] of positions, whose estimates add up to at most half of it and another
        half for every second, and [m/s, rad/s] of velocities.

    Attributes
    ----------
    options
        Of the whole steps.
    error
        Sum of the estimates of positions since `restart` [m, rad].
    taken, refused
        Parts that were kept and those that were not, since then.

    Raises
    ------
    ProblemError
        For a tolerance below 1e-8.
    """

    MEMORY = ("_left", "_length", "error", "taken", "refused", "_last")

    def __init__(self, stepper: Stepper, tol: float) -> None:
        self.stepper, self.tol = stepper, real_number("tol", tol, low=1e-8)
        impacts = "located" if stepper.options.soft is None else stepper.options.impacts
        finer = min(stepper.options.solver_tol, NOISE * self.tol)
        self.options = replace(stepper.options, impacts=impacts, solver_tol=finer)
        self.restart()

    def restart(self) -> None:
        """Forget what was spent, and how long steps were."""
        self._left, self._length = 0.5 * self.tol, self.options.dt
        self.error, self.taken, self.refused, self._last = 0.0, 0, 0, 0.0

    def step(
        self, state: State, torques: FloatArray, push: FloatArray | None = None, mu: float = 0.6
    ) -> Step:
        """Return the step of the whole dt; see `Stepper.step`. Its pieces are the parts that were kept."""
        self._begin, left, kept, whole = state, self.options.dt, list[Step](), None
        self._before = self._left, self._length, self._last, self.error, self.taken, self.refused
        given = torques, push, mu
        while left > 0.0:
            h = left if self._length >= left else max(min(self._length, 0.5 * left), SHORTEST)
            h = left if left - h < SHORTEST else h
            half = 0.5 * h
            whole = self._part(state, h, self._last, *given) if whole is None else whole
            first = self._part(state, half, self._last, *given)
            second = self._part(first.state, half, half, *given)
            way, jump = self._apart(whole.state, second.state)
            limit = 0.5 * self.tol * h + SHARE * self._left
            worst = max(way / limit, jump / (SHARE * self.tol))
            if worst > 1.0 and h >= 2.0 * SHORTEST:
                self._length, whole, self.refused = half, first, self.refused + 1
                continue
            self._left = min(max(self._left + 0.5 * self.tol * h - way, 0.0), 0.5 * self.tol)
            self._length = h * min(GROW, SAFETY / np.sqrt(max(worst, 1e-12)))
            self.error, self.taken = self.error + way, self.taken + 1
            state, whole, left, self._last = second.state, None, left - h, half
            kept += [first, second]
        return self._join(kept)

    def _part(
        self, state: State, h: float, last: float, torques: FloatArray, push: FloatArray | None, mu: float
    ) -> Step:
        """Return a step of h [s] behind one of `last` [s]."""
        if state.memory is not None:
            state = state._replace(memory=state.memory._replace(pace=2.0 * h / (h + last)))
        self.stepper.options = replace(self.options, dt=h)
        try:
            return self.stepper.step(state, torques, push, mu)
        except SimulationError as lost:
            what = lost.what
        finally:
            self.stepper.options = self.options
        # The world stays where its whole step began, and so does what was spent. Parts count as steps of a dt
        # of their own and know no time: what is told is the whole step's, but for the joint that was fast in
        # the part.
        self._left, self._length, self._last, self.error, self.taken, self.refused = self._before
        raise self.stepper.told(what, state._replace(steps=self._begin.steps))

    def _apart(self, whole: State, halves: State) -> tuple[float, float]:
        """Return how far two ends are apart: positions [m, rad] and velocities [m/s, rad/s]."""
        import pinocchio

        way = pinocchio.difference(self.stepper.bodies.model, whole.q, halves.q)
        return float(np.abs(way).max(initial=0.0)), float(np.abs(whole.v - halves.v).max(initial=0.0))

    def _join(self, parts: list[Step]) -> Step:
        """Return parts as one step: the sum of their impulses, and what the last impact saw."""
        dt, total = self.options.dt, np.zeros(parts[-1].impulses.shape)
        for part in parts:
            total[: len(part.impulses)] += part.impulses
        seen = next((part for part in reversed(parts) if part.impact is not None), parts[-1])
        return Step(
            parts[-1].state._replace(steps=self._begin.steps + 1), dt, total, seen.velocities, seen.gaps,
            seen.positions, seen.impact, sum(part.unsolved for part in parts),
            max(part.worst_residual for part in parts), max(part.law_error for part in parts),
            tuple(Piece(part.state, part.dt, rest=part) for part in parts),
        )  # fmt: skip
