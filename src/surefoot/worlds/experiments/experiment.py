"""One experiment, one world: what was measured, what a closed form says, and how far a step may be off.

A world's own step error is measured, not assumed. The experiment is run with steps of 2 dt, dt and dt / 2; an
error of first order, x = x₀ + c dt, then shows as |x(2dt) - x(dt)| = 2 |x(dt) - x(dt/2)| = |c| dt. Twice
the larger of the two is the tolerance: a world agrees with a closed form when its value at dt lies that
close, and when the tolerance itself is a small share of what was measured (`RESOLVED`), so that a world that
does not converge cannot agree with everything.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from surefoot.base.arrays import real_number
from surefoot.base.errors import SurefootError

RESOLVED = 0.1
"""Largest tolerance that still says something, as a share of the quantity's scale."""
FLOOR = 1e-6
"""Least tolerance, as a share of the scale: solvers' tolerances, and times of events within a step."""
SAFETY = 2.0
"""Tolerance over step error."""


class MeasuredQuantity(NamedTuple):
    """A number that a world gave, and its closed form.

    Attributes
    ----------
    name, unit
        What it is.
    value, exact
        The world's and the closed form's.
    scale
        What would be a large error, in the same unit; 0.0 for the size of `exact` itself.
    """

    name: str
    unit: str
    value: float
    exact: float
    scale: float = 0.0


Measured = tuple[MeasuredQuantity, ...]
"""What a world did in an experiment."""


@dataclass(frozen=True)
class WorldExperiment:
    """Something that every world can be asked to do.

    Attributes
    ----------
    name
        One word.
    says
        What happens, in one sentence.
    compares
        Which quantities are compared with which closed form, in one sentence.
    measure
        World's name and step [s] to what it did.
    """

    name: str
    says: str
    compares: str
    measure: Callable[[str, float], Measured]


@dataclass(frozen=True)
class Row:
    """One quantity in one world.

    Attributes
    ----------
    experiment, world, quantity, unit
        Which.
    exact, value
        The closed form's and the world's.
    step_error
        The world's own at this step: what halving and doubling the step changes, whichever says more.
    tolerance
        `SAFETY` times as much, at least `FLOOR` of the scale.
    verdict
        "agrees", "differs", or "unresolved" where the tolerance is more than `RESOLVED` of the scale.
    """

    experiment: str
    world: str
    quantity: str
    unit: str
    exact: float
    value: float
    step_error: float
    tolerance: float
    verdict: str

    @property
    def error(self) -> float:
        """Distance from the closed form, in the unit of the row."""
        return abs(self.value - self.exact)

    def as_dict(self) -> dict[str, Any]:
        """Return every number and word."""
        return {**self.__dict__, "error": self.error, "agrees": self.verdict == "agrees"}


@dataclass(frozen=True)
class WorldsOutcome:
    """An experiment in several worlds.

    Attributes
    ----------
    experiment
        Which.
    rows
        One per quantity and world.
    failures
        World to what stopped it.
    """

    experiment: WorldExperiment
    rows: list[Row] = field(default_factory=list)
    failures: dict[str, str] = field(default_factory=dict)

    @property
    def agrees(self) -> bool:
        """Whether every world kept to the closed form and none failed."""
        return not self.failures and all(row.verdict == "agrees" for row in self.rows)


def compare(
    experiment: WorldExperiment, world: str, dt: float = 1e-3, tell: Callable[[str], object] | None = None
) -> list[Row]:
    """Return what an experiment gives in a world at a step of `dt` [s], quantity by quantity.

    `tell` is called before each of the three runs with a phrase that says which.

    Raises
    ------
    ProblemError
        For a step that is no step.
    SurefootError
        What the world raises.
    """
    step = real_number("dt", dt, low=1e-5, high=0.02)
    runs = []
    for h in (2.0 * step, step, 0.5 * step):
        if tell is not None:
            tell(f"{experiment.name} in {world}, step {h:g} s")
        runs.append(experiment.measure(world, h))
    return [_row(experiment, world, *same) for same in zip(*runs, strict=True)]


def carry_out(
    experiment: WorldExperiment,
    worlds: Sequence[str],
    dt: float = 1e-3,
    tell: Callable[[str], object] | None = None,
) -> WorldsOutcome:
    """Return an experiment in some worlds; what stops one is kept, not raised.

    `tell` is called before each run with a phrase that says which.

    Raises
    ------
    ProblemError
        For a step that is no step.
    """
    real_number("dt", dt, low=1e-5, high=0.02)
    outcome = WorldsOutcome(experiment)
    for world in worlds:
        try:
            outcome.rows.extend(compare(experiment, world, dt, tell))
        except SurefootError as error:
            outcome.failures[world] = str(error)
    return outcome


def _row(
    experiment: WorldExperiment, world: str, coarse: MeasuredQuantity, quantity: MeasuredQuantity,
    fine: MeasuredQuantity,
) -> Row:  # fmt: skip
    """Return one quantity at a step, judged by those of twice and of half the step."""
    value = float(quantity.value)
    scale = quantity.scale or abs(quantity.exact)
    step_error = max(abs(float(coarse.value) - value), 2.0 * abs(value - float(fine.value)))
    tolerance = max(SAFETY * step_error, FLOOR * scale)
    if not (math.isfinite(value) and tolerance <= RESOLVED * scale):
        verdict = "unresolved"
    else:
        verdict = "agrees" if abs(value - quantity.exact) <= tolerance else "differs"
    return Row(
        experiment.name, world, quantity.name, quantity.unit, quantity.exact, value, step_error, tolerance,
        verdict,
    )  # fmt: skip
