"""Rivals of `ForceDistributor`: cone solvers with exact cones and QP solvers with facets.

Each gets the problem in its own words, made ready outside the clock (the Hessian too, which
`ForceDistributor` does not need and does not get). `cold` solves from nothing; `warm`, where the rival can,
goes on from the last solution.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.prepared import RIVALS, rival
from benchmarks.problems.allocation_program import Program, cone_program
from surefoot.base.arrays import FloatArray
from surefoot.contact.solvers.backends import Backend, Options, installed

TOLERANCE = 1e-6
"""Asked of solvers that stop by a tolerance, unless the benchmark finds that a looser one will do."""


@dataclass(frozen=True)
class Kind:
    """A solver by its name in tables; in small letters it is its name in `RIVALS`."""

    name: str

    @property
    def backend(self) -> str:
        """Its name in `RIVALS`."""
        return self.name.lower()

    @property
    def exact(self) -> bool:
        """Whether it is given exact cones, not facets."""
        return RIVALS[self.backend].takes_cones

    @property
    def can_warm(self) -> bool:
        """Whether it can go on from the last solution."""
        return RIVALS[self.backend].warm_starts

    @property
    def has_tol(self) -> bool:
        """Whether it stops by a tolerance that decides how accurate it is: not so an active set."""
        return RIVALS[self.backend].has_tol and self.backend != "daqp"

    def __call__(self, tol: float = TOLERANCE) -> Rival:
        """Return one with nothing to go on from."""
        return Rival(self, tol)


class Rival:
    """A solver of one kind with its stopping tolerance, and with what it keeps from call to call."""

    def __init__(self, kind: Kind, tol: float) -> None:
        self.kind, self.tol = kind, tol
        given = tol if kind.has_tol else None
        self._cold = rival(kind.backend, Options(given))
        self._warm = rival(kind.backend, Options(given, keep=True, warm=True))

    def ready(self, p: Program) -> Any:
        """Return a program in the rival's own words: well before the call, for it empties the caches."""
        return self._cold.ready(cone_program(p))

    def ask(self, item: Any, warm: bool) -> Asked:
        """Return the call that solves a ready program, from the last answer where it is warm and can."""
        solver = self._warm if warm and self.kind.can_warm else self._cold
        return Asked(solver.call(item), solver)

    def solve(self, p: Program, warm: bool) -> FloatArray | None:
        """Set up and solve a program, from the last answer where it is warm and can; see `Asked.read`."""
        asked = self.ask(self.ready(p), warm)
        return asked.read(asked.call())


@dataclass(frozen=True)
class Asked:
    """A program that is ready to be solved: `call` is what is timed, `read` makes x of its answer."""

    call: Callable[[], Any]
    solver: Backend

    def read(self, answer: Any) -> FloatArray | None:
        """Return x, or None if the solver says that it is no solution."""
        found = self.solver.read(answer)
        return np.array(found.x) if found.found else None


EXACT_RIVALS = tuple(map(Kind, ("Clarabel", "ECOS", "SCS")))
DAQP = Kind("DAQP")
FACET_RIVALS = (DAQP, *map(Kind, ("quadprog", "ProxQP", "OSQP", "PIQP", "HiGHS")))


def available(rivals: tuple[Kind, ...]) -> list[Kind]:
    """Return the rivals whose package is installed."""
    return [kind for kind in rivals if installed(kind.backend)]
