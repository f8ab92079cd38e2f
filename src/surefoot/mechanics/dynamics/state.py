"""The values that go into a step and come out of it."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, IntArray
from surefoot.base.errors import ProblemError
from surefoot.contact import ContactProblem, ContactSolution


class StepRemainder(NamedTuple):
    """What a step leaves to the next one besides q and v.

    Attributes
    ----------
    impulses
        (p, 3) of the last step, in contact axes [N s]: which contacts hold on, and the warm start.
    leaving
        (p, 3) contact velocities right after them [m/s].
    airborne
        Whether nothing was near the ground.
    rate, q, v
        Acceleration of free motion where it is known (nv,), and the state that it belongs to.
    pace
        Length of the next step over the mean of its own and the last one's.
    """

    impulses: FloatArray
    leaving: FloatArray
    airborne: bool
    rate: FloatArray | None = None
    q: FloatArray | None = None
    v: FloatArray | None = None
    pace: float = 1.0


class State(NamedTuple):
    """Where a robot is between two steps; its arrays are not to be written to.

    Attributes
    ----------
    q, v
        (nq,) and (nv,) in Pinocchio's order.
    steps
        Steps since the start.
    memory
        From the step before; None where there was none: the first step then starts by stopping what would hit
        the ground before the first impulses.
    """

    q: FloatArray
    v: FloatArray
    steps: int = 0
    memory: StepRemainder | None = None

    @property
    def rate(self) -> FloatArray | None:
        """Acceleration of free motion (nv,) [m/s², rad/s²], None where unknown for just this q and v."""
        m = self.memory
        return m.rate if m is not None and m.q is self.q and m.v is self.v else None

    def as_plain(self) -> dict[str, Any]:
        """Return copies of all numbers by their names.

        The rate of free motion counts while its q and v are the state's own arrays, and is kept only then.
        """
        out: dict[str, Any] = {"q": self.q.copy(), "v": self.v.copy(), "steps": self.steps}
        left = self.memory
        if left is not None:
            out |= {"impulses": np.array(left.impulses), "leaving": np.array(left.leaving)}
            out |= {"airborne": bool(left.airborne), "pace": float(left.pace)}
            out["rate"] = None if self.rate is None else self.rate.copy()
        return out

    @staticmethod
    def from_plain(plain: dict[str, Any], like: State) -> State:
        """Return the state that `as_plain` has told, of a robot as that of another state.

        Raises
        ------
        ProblemError
            For arrays of another shape or type.
        """
        wanted = {"q": like.q.shape, "v": like.v.shape}
        if "impulses" in plain:
            shape = (len(plain["impulses"]), 3)
            wanted |= {"impulses": shape, "leaving": shape}
            wanted |= {} if plain["rate"] is None else {"rate": like.v.shape}
        read = {name: np.array(plain[name]) for name in wanted}
        for name, shape in wanted.items():
            if read[name].shape != shape or read[name].dtype != np.float64:
                raise ProblemError(f"{name} of a state must be {shape} of float64, got {read[name].shape}")
        q, v, rate, steps = read["q"], read["v"], read.get("rate"), int(plain["steps"])
        if "impulses" not in read:
            return State(q, v, steps)
        impulses, leaving, pace = read["impulses"], read["leaving"], float(plain["pace"])
        left = StepRemainder(impulses, leaving, bool(plain["airborne"]), pace=pace)
        return State(q, v, steps, left if rate is None else left._replace(rate=rate, q=q, v=v))

    @property
    def airborne(self) -> bool:
        """Whether the step may go through the air: nothing was near the ground so far."""
        return self.memory is None or self.memory.airborne


class Impact(NamedTuple):
    """The exchange of impulses in the middle of a step: what its problem was made of, and the outcome.

    Attributes
    ----------
    q
        (nq,) configuration of the impulses.
    before, free, after
        (nv,) velocities on arrival, after all forces but the ground's, and after the impulses.
    near
        (k,) contacts of the problem; under a soft law those that press.
    rows
        (3k, nv) (L⁻¹ Jᵀ)ᵀ of those contacts, with M = L Lᵀ: G = rows rowsᵀ; None without any.
    impulses
        (p, 3) of all contacts, in contact axes [N s].
    leaving, velocities
        (p, 3) contact velocities right after the impulses, and those that the laws hold for: the means until
        the next impulses [m/s].
    solution
        With its problem; None without near contacts.
    summed
        (p,) contacts whose `velocities` are sums of those before and right after the impulses, twice their
        means; None for none.
    """

    q: FloatArray
    before: FloatArray
    free: FloatArray
    after: FloatArray
    near: IntArray
    rows: FloatArray | None
    impulses: FloatArray
    leaving: FloatArray
    velocities: FloatArray
    solution: ContactSolution | None
    summed: BoolArray | None = None

    @property
    def means(self) -> FloatArray:
        """(p, 3) mean contact velocities that the laws hold for [m/s]."""
        if self.summed is None:
            return self.velocities
        return np.where(self.summed[:, None], 0.5 * self.velocities, self.velocities)

    def work(self, impulses: FloatArray, velocities: FloatArray) -> float:
        """Return λᵀ (u⁺ + u⁻) / 2 [J] for (p, 3) impulses and the velocities that the laws tie to them."""
        if self.rows is None:
            return 0.0
        change = self.rows.T @ self.impulses[self.near].ravel()
        return float(np.sum(impulses * velocities)) - 0.5 * float(change @ change)


class Piece(NamedTuple):
    """A part of a step whose impacts are located: flight under all forces, and what ended it.

    Attributes
    ----------
    start, seconds
        Where it began, and its length [s].
    impact
        The impulses at its end; None where the step ended first.
    first
        The contact whose touch ended it.
    rest
        Instead of a flight: an ordinary step of that length, where a contact presses.
    """

    start: State
    seconds: float
    impact: Impact | None = None
    first: int = -1
    rest: Step | None = None


class Step(NamedTuple):
    """One step: the state behind it, and what the ground did.

    Attributes
    ----------
    state
        After the step.
    dt
        Its length [s].
    impulses
        (p, 3) of the ground on the robot, in contact axes [N s].
    velocities
        (p, 3) contact velocities that the laws tie to them: the means until the next impulses [m/s].
    gaps, positions
        (p,) and (p, 3) of the contact points at the impulses, the middle of the step [m]; for a step without
        contacts velocities, gaps and positions are those at its start.
    impact
        What the contact problem was made of; None for a step through the air.
    unsolved
        How many of the step's contact problems were left above the tolerance.
    worst_residual
        Their largest velocity error, see `Residuals`.
    law_error
        Under a soft law: largest distance of the normal impulses from it, as a share of the largest one.
    pieces
        Of a step with located impacts; impulses are the sum, `impact`, gaps and positions the last one's.
    """

    state: State
    dt: float
    impulses: FloatArray
    velocities: FloatArray
    gaps: FloatArray
    positions: FloatArray
    impact: Impact | None
    unsolved: int
    worst_residual: float
    law_error: float = 0.0
    pieces: tuple[Piece, ...] = ()

    @property
    def forces(self) -> FloatArray:
        """(p, 3) mean forces of the ground on the robot over the step, in contact axes [N]."""
        return self.impulses / self.dt

    @property
    def solution(self) -> ContactSolution | None:
        """Solution of the contact problem (impulses [N s]); None without contacts."""
        return None if self.impact is None else self.impact.solution

    @property
    def problem(self) -> ContactProblem | None:
        """The contact problem; None without contacts."""
        return None if self.solution is None else self.solution.problem

    @property
    def contact_work(self) -> float:
        """Work of the ground's impulses [J].

        λᵀ (u⁺ + u⁻) / 2 with u⁻ the velocity without them; never positive without restitution and
        Baumgarte's term. Soft ground gives back what it stored.
        """
        if self.pieces:
            parts = [p.impact.work(p.impact.impulses, p.impact.velocities) for p in self.pieces if p.impact]
            return sum(parts) + sum(p.rest.contact_work for p in self.pieces if p.rest)
        return 0.0 if self.impact is None else self.impact.work(self.impulses, self.velocities)


def grown(values: FloatArray, count: int) -> FloatArray:
    """Return (p, 3) values of contacts with rows of zeros for those up to `count` that have come since."""
    more = count - len(values)
    return values if more == 0 else np.vstack([values, np.zeros((more, 3))])
