"""Interior point on Coulomb's law itself: what is done with the central path, and where it is lost.

The path (`central_path`) is followed from afresh. Where it leads to 1e-5 of an answer it is followed while
it lasts, and ADMM with one penalty polishes what was found (`polish`). Where it is lost it is followed again,
all of it, with unequal shares of the gap: longer, and surer. A few such paths are lost,
too, and mostly the next one, of other shares, is not.
Where the shift is held at what was found, a convex program is left that has no turns: coarse answers are
reached sooner so, and fine ones where a polish comes to rest. The fixed point of shifts (Acary and Cadoux)
shrinks by a third to two thirds each, which Anderson's mixing shortens to a few, but not at all where
contacts slide without any other force.

Source: V. Acary, M. Brémond, O. Huber, "On solving contact problems with Coulomb friction: formulations and
numerical comparisons", 2018; V. Acary, F. Cadoux, C. Lemaréchal, J. Malick, ZAMM
91(2), 2011 (the fixed point).

Limits: of G alone mostly dense, so for ranks up to some hundreds; no normal bounds, no bilateral contacts. It
cannot begin at a border, so a warm start is only what it is compared with: begun at the central point nearest
to the last step's forces, at any gap, a third of paths of balls in a pit are lost, and the others no shorter.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum
from typing import Any

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.kernels import working_time
from surefoot.contact.problem.problem import ContactProblem
from surefoot.contact.solution import Status
from surefoot.contact.solvers.central_path import CentralPath
from surefoot.contact.solvers.central_step import Iterate
from surefoot.contact.solvers.delassus_factor import find_factor
from surefoot.contact.solvers.mixing import Mixing
from surefoot.contact.solvers.newton import solve_newton
from surefoot.contact.solvers.on_blocks import admm_and_newton, heavy
from surefoot.contact.solvers.path_step import IRRATIONAL, unequal_shares
from surefoot.contact.solvers.polish import polish
from surefoot.contact.solvers.reduced_structure import Structure
from surefoot.contact.solvers.solver import Answer, SolverSettings, nearest_to_zero, register

MOST_SHIFTS = 12
"""Shifts that are held one after the other."""
MOST_ALL = 300_000
"""All iterations together, those of a polish, which are light, among them."""
STARTS = (1.0, 3.0, 10.0, 0.3)
"""First normal forces, over what stops each contact's speed: where one leads nowhere, the next is tried."""
POLISH_FROM, NEAR, COARSE, FIRST_POLISH, MOST_POLISH = 1e-5, 1e-3, 3e-5, 250, 800
"""Velocity error at which the path is left to polish what it found, that below which other forces are
polished, the tolerance from which on no turn of the path is followed, and iterations of a polish where shifts
can still be held, and else: one that ends takes hundreds, others come to rest."""
POLISHED, MOST_NEWTON = 1e-7, 30
"""Velocity error from which on no other start or long path leads nearer, and Newton's steps from there."""
MOST_TURNING, MOST_UNEQUAL, MOST_ENDING, PATIENCE, PATHS = 40, 1000, 100, 200, 4
"""Steps along turns of the path, of all paths whose contacts have unequal shares of the gap, and of one from
where that is near an answer; how many in turn may bring no smaller gap, how many such paths are tried: one
that loses itself says nothing of another."""
MOST_LONG, LONG_WORK, MOST_FINISH, FINISH_FROM = 6000, 3e10, 24_000, 1e3
"""Steps of a long path, multiplications of all its matrices, iterations of ADMM from the end of each, and the
velocity error, over the tolerance, at which a path has gone far enough for them."""
HELPED, IDLE_SHIFTS, DEPTH = 0.5, 2, 3
"""Share of the error that a new shift has to leave at most, how many in turn may leave more, and how many
differences of them are mixed to find the next one."""

Method = Callable[[ContactProblem, SolverSettings, FloatArray], Answer]
"""As a solver's function, from forces (n, 3)."""


class Extent(Enum):
    """How far a solve goes: by all but a long path, by that alone, or by one after the other."""

    SHORT = "short"
    LONG = "long"
    WHOLE = "whole"


@register("interior_point", bounds=False)
def solve_interior(
    problem: ContactProblem, settings: SolverSettings, warm_start: FloatArray | None
) -> Answer:
    """Solve Coulomb's or the convex law; a warm start (n, 3) is returned where nothing better is found."""
    active = active_contacts(problem)
    found = find_factor(problem, np.repeat(active, 3))
    assert found is not None  # without a limit there is one
    return solve_factored(problem, settings, warm_start, active, *found, Extent.WHOLE)


def active_contacts(problem: ContactProblem) -> BoolArray:
    """Return which contacts (n,) can carry a force and meet a velocity at all."""
    return np.asarray((problem.normal_max > 0.0) & (problem.scales[1] > 0.0))


def solve_factored(
    problem: ContactProblem, settings: SolverSettings, warm_start: FloatArray | None, active: BoolArray,
    factor: Any, structure: Structure, extent: Extent = Extent.SHORT,
) -> Answer:  # fmt: skip
    """Solve with the factor (rows, r) of the active contacts' G."""
    end = working_time() + settings.max_time
    forces = nearest_to_zero(problem) if warm_start is None else warm_start.reshape(-1, 3).copy()
    forces[~active] = nearest_to_zero(problem)[~active]
    if not active.any() or factor.shape[1] == 0:  # a G of zeros
        return Answer(forces, 0, Status.STALLED)
    most = MOST_ALL if settings.max_iterations is None else settings.max_iterations
    path = CentralPath(problem, active, settings.tol, most, end, factor, structure)
    run = InteriorRun(problem, active, path, min(MOST_LONG, int(LONG_WORK / max(structure.work, 1.0))))
    before = path.measure_error(np.ascontiguousarray(forces[active]))
    if extent is not Extent.LONG:
        run.go()
    if extent is not Extent.SHORT and path.error > settings.tol:
        run.go_long()
    if path.error < before:
        forces[active] = path.best
    stop = Status.MAX_TIME if working_time() > end else Status.STALLED
    return Answer(forces, path.done, Status.MAX_ITERATIONS if path.done >= most else stop)


class InteriorRun:
    """One solve of a problem's active contacts (n,) along its path, of which a long one has so many steps."""

    def __init__(self, problem: ContactProblem, active: BoolArray, path: CentralPath, most_long: int) -> None:
        self.problem, self.active, self.path, self.most_long = problem, active, path, most_long

    def go(self) -> None:
        """Try one start after the other until the problem is solved, or iterations or time are spent."""
        path = self.path
        if not path.coulomb:
            self._hold(path.start(STARTS[0]))
            return
        for number, size in enumerate(STARTS):
            path.points, first = [], number == 0
            if self._from(path.start(size), first) or path.over() or path.error <= POLISHED:
                return

    def _from(self, first: Iterate, unequally: bool) -> bool:
        """Follow the path from a point, and polish what is near an answer; tell whether it is solved.

        Where it is lost paths of unequal shares may be followed, alike from every start.
        """
        path = self.path
        coarse = path.tol >= COARSE
        if path.follow(first, 0 if coarse else MOST_TURNING, POLISH_FROM) or not path.points:
            return path.error <= path.tol
        # a coarse answer is reached sooner where the shift is held
        if coarse and (self._hold(first) or path.follow(path.points[-1][1], MOST_TURNING, POLISH_FROM)):
            return True
        if self.end(first) or (unequally and self._follow_unequally(first)):
            return True
        # nearer than that, the shift has been held
        return not coarse and path.error > NEAR and (self._hold(first) or self._polish())

    def _follow_unequally(self, first: Iterate) -> bool:
        """Follow one path of unequal shares after the other, and polish; tell whether the problem is solved.

        Nearer to an answer than a polish begins it is followed only where that comes to rest. Newton's steps
        come before all of them where next to nothing is left: they mostly end it.
        """
        path = self.path
        if path.error <= POLISHED and not heavy(self.problem):
            path.last = path.best
            if self._finish(solve_newton, MOST_NEWTON):
                return True
        left = min(MOST_UNEQUAL, self.most_long)
        for number in range(PATHS):
            path.memory.unequal, point, met = unequal_shares(len(path.mu), number), first, False
            for most, enough in ((left, POLISH_FROM), (MOST_ENDING, path.tol)):
                if path.over() or left <= 0:
                    return False
                before = path.done
                met |= path.follow_unequally(point, min(most, left), enough, PATIENCE)
                left -= path.done - before
                point, last = path.points[-1][1], path.last
                if path.error <= path.tol or self.end(first):
                    return True
                if path.judge(last) > NEAR:
                    break
            if not met:  # nor are the others: where there is no answer, mostly
                return False
        return False

    def end(self, first: Iterate) -> bool:
        """Go on from where a path led near an answer; tell whether the problem is solved.

        To its very end, and from there by a polish; where that comes to rest, by holding the shift that the
        path had found: a polish of the convex program's forces is mostly a short one.
        """
        path = self.path
        error, near = path.judge(path.last), path.last
        if error > NEAR:
            return False
        if error <= POLISH_FROM and path.follow(path.points[-1][1], 0, 0.0):
            return True
        if self._polish(FIRST_POLISH):
            return True
        path.last = near
        return self._hold(first) or self._polish()

    def go_long(self) -> None:
        """Follow a path with unequal shares for long, and go on by ADMM and Newton from there.

        Where that is no answer others are followed, with other shares: of a wall of 60 bricks all of them
        wind at an error of 1e-3, and from half of their ends ADMM comes to one of 1e-6.
        """
        path = self.path
        for number in range(len(IRRATIONAL) if path.coulomb else 0):
            path.memory.unequal = unequal_shares(len(path.mu), number)
            enough = max(FINISH_FROM * path.tol, POLISH_FROM)
            path.follow_unequally(path.start(STARTS[0]), self.most_long, enough)
            solved = path.error <= path.tol or self._finish(admm_and_newton, MOST_FINISH)
            if solved or path.over() or path.error <= POLISHED:
                return

    def _polish(self, most: int = MOST_POLISH) -> bool:
        """Polish the forces found last, or the best where those are far; tell whether the problem is solved.

        Others than the last may be nearer, where a polish came to rest before.
        """
        path = self.path
        error = path.judge(path.last)
        if error > NEAR:  # programs with a held shift may run away
            path.last, error = path.best, path.error
        return path.tol < error <= NEAR and self._finish(polish, most)

    def _finish(self, method: Method, most: int) -> bool:
        """Go on from the forces found last by another method; tell whether the problem is solved."""
        path, forces = self.path, nearest_to_zero(self.problem)
        forces[self.active] = path.last
        left = SolverSettings(path.tol, min(path.most - path.done, most), path.end - working_time())
        found = method(self.problem, left, forces)
        path.done += found.iterations
        return path.judge(np.ascontiguousarray(found.forces[self.active])) <= path.tol

    def _hold(self, first: Iterate) -> bool:
        """Hold one shift after the other as long as that helps; tell whether the problem is solved."""
        path, idle = self.path, 0
        shift, mixing = path.find_shift(), Mixing(DEPTH, path.speed)
        for _ in range(MOST_SHIFTS if path.coulomb else 1):
            before = path.error
            if path.follow_held(path.nearer(first), shift):
                return True
            idle = 0 if path.error <= HELPED * before else idle + 1
            if idle >= IDLE_SHIFTS or path.over():
                return False
            found = path.find_shift()
            if not np.isfinite(found).all():  # forces that run away
                return False
            shift = np.maximum(mixing.next(shift, found), 0.0)
        return False
