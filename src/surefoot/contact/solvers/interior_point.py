"""Interior point on Coulomb's law itself: the De Saxcé shift is linearised in each Newton step, then held.

With forces x and velocities y scaled so that every contact's cone is the second-order cone L, the law reads
L ∋ x ⟂ y ∈ L, y = Y Yᵀ x + g + ||ȳ|| e_3, G = Y Yᵀ. A step of Nesterov and Todd's scaling, predictor and
corrector, is one solve with I + Yᵀ P S⁻¹ Y (see `cone_pairs`): as large as the rank of G, the velocities of
the bodies, however many contacts hold them.

The shift's derivative is in S: quadratic, from far away. Coulomb's law is not monotone, so that its central
path may turn, or nearly: where steps become short the path is followed by its length (`path_step`). It loses
itself near an answer, where forces that velocities do not determine drift with rounding (an error of 3e-6);
from 1e-5 on it is followed while it lasts, and ADMM with one penalty polishes what was found (`polish`).
Where the path is lost it is followed again, all of it, with unequal shares of the gap: longer, and surer.
Where the shift is held at what was found, a convex program is left that has no turns: coarse answers are
reached sooner so, and fine ones where a polish comes to rest. The fixed point of shifts (Acary and Cadoux)
shrinks by a third to two thirds each, which Anderson's mixing shortens to a few, but not at all where
contacts slide without any other force.

Source: V. Acary, M. Brémond, O. Huber, "On solving contact problems with Coulomb friction: formulations and
numerical comparisons", 2018; V. Acary, F. Cadoux, C. Lemaréchal, J. Malick, ZAMM
91(2), 2011 (the fixed point).

Limits: of G alone mostly dense, so for ranks up to some hundreds; no normal bounds, no bilateral contacts. It
cannot begin at a border, so a warm start is only what it is compared with.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.kernels import working_time
from surefoot.contact.problem.problem import ContactProblem
from surefoot.contact.solution import Status
from surefoot.contact.solvers.central_step import Iterate, fill_residual
from surefoot.contact.solvers.delassus_factor import find_factor
from surefoot.contact.solvers.mixing import Mixing
from surefoot.contact.solvers.on_blocks import admm_and_newton
from surefoot.contact.solvers.path_step import IRRATIONAL, unequal_shares
from surefoot.contact.solvers.polish import polish
from surefoot.contact.solvers.reduced_structure import Structure
from surefoot.contact.solvers.reduced_system import ReducedSystem
from surefoot.contact.solvers.solver import Answer, SolverSettings, nearest_to_zero, register
from surefoot.contact.solvers.step_memory import StepMemory, Turning
from surefoot.contact.solvers.stopping import fill_measure, velocity_error

MOST, MOST_HELD, MOST_SHIFTS = 60, 40, 12
"""Iterations with the shift linearised besides those along turns, with one held shift, and shifts that are
held one after the other."""
MOST_ALL = 300_000
"""All iterations together, those of a polish, which are light, among them."""
STARTS = (1.0, 3.0, 10.0, 0.3)
"""First normal forces, over what stops each contact's speed: where one leads nowhere, the next is tried."""
LEAST, AHEAD = 0.3, 10.0
"""Least centring while the residual is so many times the gap, over their scales: else the gap ends first."""
POLISH_FROM, NEAR, COARSE, FIRST_POLISH, MOST_POLISH = 1e-5, 1e-3, 3e-5, 250, 800
"""Velocity error at which the path is left to polish what it found, that below which other forces are
polished, the tolerance from which on no turn of the path is followed, and iterations of a polish where shifts
can still be held, and else: one that ends takes hundreds, others come to rest."""
POLISHED = 1e-7
"""Velocity error from which on no other start leads nearer."""
SHORT, IDLE = 0.1, 3
"""A step is short below this share of a whole one; so many short ones end a phase."""
TURN, TURN_FROM, MOST_TURNING, PASSED = 0.3, 1e-2, 40, -0.15
"""Share of a whole step below which the path may turn, share of the first gap from which on it is followed by
its length then, steps that this may take, and the change of the log gap after which the turn is passed."""
MOST_UNEQUAL = 700
"""Steps along turns of a path whose contacts have unequal shares of the gap."""
MOST_LONG, LONG_WORK, MOST_FINISH, FINISH_FROM = 6000, 3e10, 24_000, 1e3
"""Steps of a long path, multiplications of all its matrices, iterations of ADMM from the end of each, and the
velocity error, over the tolerance, at which a path has gone far enough for them."""
BEFORE = 1e-5
"""Share of the first gap from which a program with a held shift begins."""
KNOWN, HELD = 1e-2, 0.3
"""Velocity error below which the path leads near an answer; share of the tolerance to which a program with a
held shift is solved."""
WORSE = 3
"""Iterations that leave more of a held program's error than its best, after which rounding has taken over."""
OWN_SHIFT = np.empty(0)
"""In place of a shift: that of the point itself."""
HELPED, IDLE_SHIFTS, DEPTH = 0.5, 2, 3
"""Share of the error that a new shift has to leave at most, how many in turn may leave more, and how many
differences of them are mixed to find the next one."""


@register("interior_point", bounds=False)
def solve_interior(
    problem: ContactProblem, settings: SolverSettings, warm_start: FloatArray | None
) -> Answer:
    """Solve Coulomb's or the convex law; a warm start (n, 3) is returned where nothing better is found."""
    active = active_contacts(problem)
    found = find_factor(problem, np.repeat(active, 3))
    assert found is not None  # without a limit there is one
    return solve_factored(problem, settings, warm_start, active, *found, None)


def active_contacts(problem: ContactProblem) -> BoolArray:
    """Return which contacts (n,) can carry a force and meet a velocity at all."""
    return np.asarray((problem.normal_max > 0.0) & (problem.scales[1] > 0.0))


def solve_factored(
    problem: ContactProblem, settings: SolverSettings, warm_start: FloatArray | None, active: BoolArray,
    factor: Any, structure: Structure, long: bool | None = False,
) -> Answer:  # fmt: skip
    """Solve with the factor (rows, r) of the active contacts' G: by all but a long path, or by it alone.

    None for one after the other.
    """
    end = working_time() + settings.max_time
    forces = nearest_to_zero(problem) if warm_start is None else warm_start.reshape(-1, 3).copy()
    forces[~active] = nearest_to_zero(problem)[~active]
    if not active.any() or factor.shape[1] == 0:  # a G of zeros
        return Answer(forces, 0, Status.STALLED)
    most = MOST_ALL if settings.max_iterations is None else settings.max_iterations
    run = _Run(problem, active, settings.tol, most, end, factor, structure)
    before = run.measure_error(np.ascontiguousarray(forces[active]))
    if not long:
        run.go()
    if long is not False and run.error > settings.tol:
        run.go_long()
    if run.error < before:
        forces[active] = run.best
    stop = Status.MAX_TIME if working_time() > end else Status.STALLED
    return Answer(forces, run.done, Status.MAX_ITERATIONS if run.done >= most else stop)


class _Run:
    """One solve: the scaled problem of the contacts that are on, and the best forces so far."""

    def __init__(
        self, problem: ContactProblem, active: BoolArray, tol: float, most: int, end: float, factor: Any,
        structure: Structure,
    ) -> None:  # fmt: skip
        self.problem, self.active = problem, active
        self.tol, self.most, self.end, self.done = tol, most, end, 0
        self.coulomb = problem.law.shift != 0.0
        rows = np.repeat(active, 3)
        self.mu, self.free = np.ascontiguousarray(problem.mu[active]), problem.g[rows].reshape(-1, 3)
        n = len(self.mu)
        # forces are x times it, y velocities times it: of mu = 0 the axis is left, and no row grows
        self.scale = np.empty((n, 3))
        self.scale[:, :2] = np.minimum(self.mu, 1.0)[:, None]
        self.scale[:, 2] = 1.0 / np.maximum(self.mu, 1.0)
        self.most_long = min(MOST_LONG, int(LONG_WORK / max(structure.work, 1.0)))
        self.memory = StepMemory(ReducedSystem(factor, self.scale, structure), n)
        scales = np.ascontiguousarray(problem.scales[:, active])
        weight = np.where(scales[0] > 0.0, scales[0], scales[1])
        self.speed, self.force = scales[1], scales[1] / weight
        self.energy = float(np.sum(scales[1] * self.force)) / n
        self.measure = np.empty((n, 2))
        fill_measure(scales, self.measure)
        self.low, self.high = np.zeros(n), np.full(n, np.inf)
        self.path: list[tuple[float, Iterate]] = []
        self.best = self.last = np.zeros((n, 3))
        self.error = math.inf

    def go(self) -> None:
        """Try one start after the other until the problem is solved, or iterations or time are spent."""
        if not self.coulomb:
            self._hold(self._start(STARTS[0]))
            return
        for number, start in enumerate(STARTS):
            self.path = []
            if self._from(self._start(start), number == 0) or self._over() or self.error <= POLISHED:
                return

    def _from(self, first: Iterate, unequally: bool) -> bool:
        """Follow the path from a point, and polish what is near an answer; tell whether it is solved.

        Where it is lost it may be followed unequally, which leads to the same place from every start.
        """
        coarse = self.tol >= COARSE
        if self._follow(first, 0 if coarse else MOST_TURNING) or not self.path:
            return self.error <= self.tol
        # a coarse answer is reached sooner where the shift is held than beyond the path's turns
        if coarse and (self._hold(first) or self._follow(self.path[-1][1], MOST_TURNING)):
            return True
        if self._end(first):
            return True
        # nearer than that it is followed only where a polish from there comes to rest
        point = first
        for enough in (POLISH_FROM, self.tol) if unequally else ():
            if self._over():
                break
            self._follow_unequally(point, min(MOST_UNEQUAL, self.most_long), enough)
            point = self.path[-1][1]
            if self.error <= self.tol or self._end(first):
                return True
        # nearer than that, the shift has been held
        return not coarse and self.error > NEAR and (self._hold(first) or self._polish())

    def _end(self, first: Iterate) -> bool:
        """Go on from where a path led near an answer; tell whether the problem is solved.

        To its very end, and from there by a polish; where that comes to rest, by holding the shift that the
        path had found: a polish of the convex program's forces is mostly a short one.
        """
        error, near = self._error(self.last), self.last
        if error > NEAR:
            return False
        if error <= POLISH_FROM and self._follow(self.path[-1][1], 0, 0.0):
            return True
        if self._polish(FIRST_POLISH):
            return True
        self.last = near
        return self._hold(first) or self._polish()

    def go_long(self) -> None:
        """Follow a path with unequal shares for long, and go on by ADMM and Newton from there.

        Where that is no answer others are followed, with other shares: of a wall of 60 bricks all of them
        wind at an error of 1e-3, and from half of their ends ADMM comes to one of 1e-6.
        """
        for number in range(len(IRRATIONAL) if self.coulomb else 0):
            self.memory.unequal = unequal_shares(len(self.mu), number)
            enough = max(FINISH_FROM * self.tol, POLISH_FROM)
            self._follow_unequally(self._start(STARTS[0]), self.most_long, enough)
            if self.error <= self.tol or self._finish(admm_and_newton, MOST_FINISH) or self._over():
                return

    def _follow_unequally(self, point: Iterate, most: int, enough: float) -> None:
        """Follow a path by its length, with unequal shares of the gap.

        It ends where an error is enough, after so many steps, or where the path is lost.
        """
        turning = Turning(True)
        for _ in range(min(most, self.most - self.done)):
            gap, self.last, u, error = self._look(point, 1.0)
            if not gap > 0.0 or error <= max(enough, self.tol) or turning.lost:
                break
            self.path = [(gap, point)]
            if working_time() > self.end:
                break
            fill_residual(point.y, self.scale, u, OWN_SHIFT, self.speed, self.memory.residual)
            self.done += 1
            after = turning.step(self.memory, point, gap)[1]
            if after is None:
                break
            point = after

    def _over(self) -> bool:
        """Tell whether iterations or time are spent."""
        return self.done >= self.most or working_time() > self.end

    def _polish(self, most: int = MOST_POLISH) -> bool:
        """Polish the forces found last if they are near an answer; tell whether the problem is solved.

        Others may be nearer, where a polish came to rest before.
        """
        return self.tol < self._error(self.last) <= NEAR and self._finish(polish, most)

    def _finish(
        self, method: Callable[[ContactProblem, SolverSettings, FloatArray], Answer], most: int
    ) -> bool:
        """Go on from the forces found last by another method; tell whether the problem is solved."""
        forces = nearest_to_zero(self.problem)
        forces[self.active] = self.last
        left = SolverSettings(self.tol, min(self.most - self.done, most), self.end - working_time())
        found = method(self.problem, left, forces)
        self.done += found.iterations
        better = np.ascontiguousarray(found.forces[self.active])
        return self._error(better) <= self.tol

    def _hold(self, first: Iterate) -> bool:
        """Hold one shift after the other as long as that helps; tell whether the problem is solved."""
        shift, idle = self._shift(), 0
        mixing = Mixing(DEPTH, self.speed)
        for _ in range(MOST_SHIFTS if self.coulomb else 1):
            before = self.error
            if self._follow_held(self._nearer(first), shift):
                return True
            idle = 0 if self.error <= HELPED * before else idle + 1
            if idle >= IDLE_SHIFTS or self._over():
                return False
            found = self._shift()
            if not np.isfinite(found).all():  # forces that run away
                return False
            shift = np.maximum(mixing.next(shift, found), 0.0)
        return False

    def _start(self, size: float) -> Iterate:
        """Return the point that begins afresh: every contact's speed, and the force that stops it."""
        x, y = np.zeros(self.scale.shape), np.zeros(self.scale.shape)
        x[:, 2], y[:, 2] = size * self.force, self.speed
        return Iterate(x, x[:, 2].copy(), y, y[:, 2].copy())

    def _nearer(self, first: Iterate) -> Iterate:
        """Return the last point of the path that is far enough from the border to go on from."""
        far = [point for gap, point in self.path if gap > BEFORE * self.energy]
        return far[-1] if far and self.error < KNOWN else first

    def _velocities(self, forces: FloatArray) -> FloatArray:
        """Return u (n, 3) of forces (n, 3)."""
        return self.memory.system.multiply_square(forces) + self.free

    def _shift(self) -> FloatArray:
        """Return ||ȳ|| (n,) at `last`, a program's best forces; zero for the convex law."""
        if not self.coulomb:
            return np.zeros(len(self.mu))
        u = self._velocities(self.last)
        return np.asarray(self.scale[:, 0] * np.sqrt(u[:, 0] ** 2 + u[:, 1] ** 2))

    def measure_error(self, forces: FloatArray, u: FloatArray | None = None) -> float:
        """Return the velocity error of forces (n, 3), with their velocities u (n, 3) if those are known."""
        u = self._velocities(forces) if u is None else u
        convex = not self.coulomb
        return float(
            velocity_error(forces.ravel(), u.ravel(), self.mu, self.low, self.high, self.measure, convex)
        )

    def _error(self, forces: FloatArray, u: FloatArray | None = None) -> float:
        """Return the velocity error of forces as `measure_error`, and keep the best."""
        error = self.measure_error(forces, u)
        if error < self.error:
            self.best, self.error = forces, error
        return error

    def _held_error(self, forces: FloatArray, u: FloatArray, shift: FloatArray) -> float:
        """Return the velocity error where the shift is held."""
        lifted = u.copy()
        lifted[:, 2] += shift / self.scale[:, 2]
        return velocity_error(
            forces.ravel(), lifted.ravel(), self.mu, self.low, self.high, self.measure, True
        )

    def _look(self, point: Iterate, share: float) -> tuple[float, FloatArray, FloatArray, float]:
        """Fill the scalings of a point; return its gap, forces, velocities and velocity error."""
        gap = self.memory.scale(point, share)
        forces = self.scale * point.x
        u = self._velocities(forces)
        return gap, forces, u, self._error(forces, u) if gap > 0.0 else math.inf

    def _follow(self, point: Iterate, turns: int, enough: float = POLISH_FROM) -> bool:
        """Follow the central path with the shift linearised; tell whether the problem is solved.

        So many steps may go along turns. An error may be enough.
        """
        short = 0
        turning: Turning | None = None
        for _ in range(min(MOST + turns, self.most - self.done)):
            gap, self.last, u, error = self._look(point, 1.0)
            if not gap > 0.0 or error <= self.tol:  # below the smallest number
                return error <= self.tol
            self.path.append((gap, point))
            if error <= enough or working_time() > self.end:
                break
            far = fill_residual(point.y, self.scale, u, OWN_SHIFT, self.speed, self.memory.residual)
            self.done += 1
            after: Iterate | None
            if turning is not None:
                turns -= 1
                log, after = turning.step(self.memory, point, gap)
                if log <= PASSED or turns <= 0:
                    turning = None
            else:
                least = LEAST if far > AHEAD * gap / self.energy else 0.0
                length, after = self.memory.advance(point, gap, 1.0, least)
                short = short + 1 if length < SHORT else 0
                if length < TURN and turns > 0 and gap < TURN_FROM * self.energy:
                    turning, short, after = Turning(False), 0, point
                    self.memory.forget()
            if after is None or short >= IDLE:
                break
            point = after
        return False

    def _follow_held(self, point: Iterate, shift: FloatArray) -> bool:
        """Follow the central path of a program whose shift (n,) is held; tell whether all is solved."""
        short, least_held, worse = 0, math.inf, 0
        for _ in range(min(MOST_HELD, self.most - self.done)):
            gap, forces, u, error = self._look(point, 0.0)
            if not gap > 0.0 or working_time() > self.end:
                break
            held = self._held_error(forces, u, shift)
            worse = worse + 1 if held > least_held else 0
            if held < least_held:
                least_held, self.last = held, forces
            sure = gap <= self.tol * self.energy  # the convex law's energy gap is judged, too
            if error <= self.tol and (self.coulomb or sure):
                return True
            if not self.coulomb:
                self.path.append((gap, point))
            if (sure and held <= HELD * self.tol) or worse >= WORSE:
                break
            far = fill_residual(point.y, self.scale, u, shift, self.speed, self.memory.residual)
            least = LEAST if far > AHEAD * gap / self.energy else 0.0
            length, after = self.memory.advance(point, gap, 0.0, least)
            self.done += 1
            short = short + 1 if length < SHORT else 0
            if after is None or short >= IDLE:
                break
            point = after
        return False
