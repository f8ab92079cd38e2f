"""The central path of Coulomb's law, and of programs whose shift is held: how points of it are found.

With forces x and velocities y scaled so that every contact's cone is the second-order cone L, the law reads
L ∋ x ⟂ y ∈ L, y = Y Yᵀ x + g + ||ȳ|| e_3, G = Y Yᵀ. A step of Nesterov and Todd's scaling, predictor and
corrector, is one solve with I + Yᵀ P S⁻¹ Y (see `cone_pairs`): as large as the rank of G, the velocities of
the bodies, however many contacts hold them.

The shift's derivative is in S: quadratic, from far away. Coulomb's law is not monotone, so that its central
path may turn, or nearly: where steps become short the path is followed by its length (`path_step`), with
equal or unequal shares of the gap. Near an answer forces that velocities do not determine drift with rounding
(an error of 3e-6).

`interior_point` has the source, and what is done with the paths.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.kernels import working_time
from surefoot.contact.problem.problem import ContactProblem
from surefoot.contact.solvers.central_step import Iterate, fill_residual
from surefoot.contact.solvers.reduced_structure import Structure
from surefoot.contact.solvers.reduced_system import ReducedSystem
from surefoot.contact.solvers.step_memory import StepMemory, Turning
from surefoot.contact.solvers.stopping import fill_measure, velocity_error

MOST, MOST_HELD = 60, 40
"""Iterations with the shift linearised besides those along turns, and with one held shift."""
LEAST, AHEAD = 0.3, 10.0
"""Least centring while the residual is so many times the gap, over their scales: else the gap ends first."""
SHORT, IDLE = 0.1, 3
"""A step is short below this share of a whole one; so many short ones end a phase."""
TURN, TURN_FROM, PASSED = 0.3, 1e-2, -0.15
"""Share of a whole step below which the path may turn, share of the first gap from which on it is followed by
its length then, and the change of the log gap after which the turn is passed."""
BEFORE = 1e-5
"""Share of the first gap from which a program with a held shift begins."""
KNOWN, HELD = 1e-2, 0.3
"""Velocity error below which the path leads near an answer; share of the tolerance to which a program with a
held shift is solved."""
WORSE = 3
"""Iterations that leave more of a held program's error than its best, after which rounding has taken over."""
OWN_SHIFT = np.empty(0)
"""In place of a shift: that of the point itself."""


class CentralPath:
    """The scaled problem of the contacts that are on, points of its path, and the best forces so far.

    Attributes
    ----------
    tol, most, end
        Velocity error wanted, iterations at most, and the working time at which to stop.
    done
        Iterations so far.
    points
        Of the path followed last, each with its gap.
    last, best, error
        Forces (n, 3) found last, those with the least velocity error, and that.
    memory
        What an iteration works in.
    """

    def __init__(
        self, problem: ContactProblem, active: BoolArray, tol: float, most: int, end: float, factor: Any,
        structure: Structure,
    ) -> None:  # fmt: skip
        self.tol, self.most, self.end, self.done = tol, most, end, 0
        self.coulomb = problem.law.shift != 0.0
        rows = np.repeat(active, 3)
        self.mu, self.free = np.ascontiguousarray(problem.mu[active]), problem.g[rows].reshape(-1, 3)
        n = len(self.mu)
        # forces are x times it, y velocities times it: of mu = 0 the axis is left, and no row grows
        self.scale = np.empty((n, 3))
        self.scale[:, :2] = np.minimum(self.mu, 1.0)[:, None]
        self.scale[:, 2] = 1.0 / np.maximum(self.mu, 1.0)
        self.memory = StepMemory(ReducedSystem(factor, self.scale, structure), n)
        scales = np.ascontiguousarray(problem.scales[:, active])
        weight = np.where(scales[0] > 0.0, scales[0], scales[1])
        self.speed, self.force = scales[1], scales[1] / weight
        self.energy = float(np.sum(scales[1] * self.force)) / n
        self.measure = np.empty((n, 2))
        fill_measure(scales, self.measure)
        self.low, self.high = np.zeros(n), np.full(n, np.inf)
        self.points: list[tuple[float, Iterate]] = []
        self.best = self.last = np.zeros((n, 3))
        self.error = math.inf

    def over(self) -> bool:
        """Tell whether iterations or time are spent."""
        return self.done >= self.most or working_time() > self.end

    def start(self, size: float) -> Iterate:
        """Return the point that begins afresh: every contact's speed, and the force that stops it."""
        x, y = np.zeros(self.scale.shape), np.zeros(self.scale.shape)
        x[:, 2], y[:, 2] = size * self.force, self.speed
        return Iterate(x, x[:, 2].copy(), y, y[:, 2].copy())

    def nearer(self, first: Iterate) -> Iterate:
        """Return the last point of the path that is far enough from the border to go on from."""
        far = [point for gap, point in self.points if gap > BEFORE * self.energy]
        return far[-1] if far and self.error < KNOWN else first

    def _velocities(self, forces: FloatArray) -> FloatArray:
        """Return u (n, 3) of forces (n, 3)."""
        return self.memory.system.multiply_square(forces) + self.free

    def find_shift(self) -> FloatArray:
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

    def judge(self, forces: FloatArray, u: FloatArray | None = None) -> float:
        """Return the velocity error of forces (n, 3) as `measure_error`, and keep the best."""
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
        return gap, forces, u, self.judge(forces, u) if gap > 0.0 else math.inf

    def follow(self, point: Iterate, turns: int, enough: float) -> bool:
        """Follow the central path with the shift linearised; tell whether the problem is solved.

        So many steps may go along turns. An error may be enough.
        """
        short = 0
        turning: Turning | None = None
        for _ in range(min(MOST + turns, self.most - self.done)):
            gap, self.last, u, error = self._look(point, 1.0)
            if not gap > 0.0 or error <= self.tol:  # below the smallest number
                return error <= self.tol
            self.points.append((gap, point))
            if error <= enough or working_time() > self.end:
                break
            far = fill_residual(point.y, self.scale, u, OWN_SHIFT, self.speed, self.memory.residual)
            self.done += 1
            after: Iterate | None
            if turning is not None:
                turns -= 1
                log, after = turning.step(self.memory, point, gap)
                if turning.lost:
                    break
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

    def follow_held(self, point: Iterate, shift: FloatArray) -> bool:
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
                self.points.append((gap, point))
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

    def follow_unequally(self, point: Iterate, most: int, enough: float, patience: float = math.inf) -> bool:
        """Follow a path by its length, with unequal shares of the gap; tell whether it was ever met.

        It ends where an error is enough, after so many steps, or where the path is lost: after so many that
        bring no smaller gap, too.
        """
        turning = Turning(True, patience)
        for _ in range(min(most, self.most - self.done)):
            gap, self.last, u, error = self._look(point, 1.0)
            if not gap > 0.0 or error <= max(enough, self.tol) or turning.lost:
                break
            self.points = [(gap, point)]
            if working_time() > self.end:
                break
            fill_residual(point.y, self.scale, u, OWN_SHIFT, self.speed, self.memory.residual)
            self.done += 1
            after = turning.step(self.memory, point, gap)[1]
            if after is None:
                break
            point = after
        return turning.met is not None
