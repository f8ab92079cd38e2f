"""The active system of a contact problem in given modes, its pseudo-inverse, and the polish by it.

With the modes' columns C, rows R and weights W put together (`derivative_modes`)::

    λ' = C y + j,    u' = G λ' + b,    R u' + W y = t    →    A y = t - R (b + G j),   A = R G C + W

Redundant contacts make A singular. Its pseudo-inverse then stands for the inverse: the part of the right
hand side that no forces answer is taken off (and off the active velocities, u' + S r with R S = 1), and of
the forces that do the same the least are taken.

Source: implicit function theorem on the active pieces; for the generalised inverse G. H. Golub,
V. Pereyra, SIAM J. Numer. Anal. 10(2), 1973.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.contact.derivative.modes import (
    HELD,
    HIGH,
    LOW,
    ContactState,
    Mode,
    contacts_of,
    defect,
    natural_mode,
)
from surefoot.contact.problem.problem import ContactProblem
from surefoot.contact.problem.residuals import residuals

RANK = 1e-12
"""Singular values of the active system below this share of the largest are zero: redundant contacts."""
SHORT = 1e-200
"""Squares of rows below this are those of a sliding force without radius: nothing to be taken off."""
POLISH_STEPS = 12
"""Newton steps on the active system; two are the rule."""


class ActiveSystem:
    """The active system of modes, one per contact, at a (3n, 3n) G; see the module for the symbols."""

    def __init__(self, G: FloatArray, modes: Sequence[Mode]) -> None:
        n = len(modes)
        counts = [mode.weight.size for mode in modes]
        self.G, self.modes, self.size = G, tuple(modes), int(sum(counts))
        self.C, self.R = np.zeros((3 * n, self.size)), np.zeros((self.size, 3 * n))
        self.S = np.zeros((3 * n, self.size))
        self.target_mu = np.zeros((self.size, n))
        self.jump_mu, self.jump_low, self.jump_high = (np.zeros((3 * n, n)) for _ in range(3))
        weight, at = np.zeros(self.size), 0
        for k, (mode, count) in enumerate(zip(modes, counts, strict=True)):
            own, mine = slice(3 * k, 3 * k + 3), slice(at, at + count)
            self.C[own, mine], self.R[mine, own], weight[mine] = mode.columns, mode.rows, mode.weight
            # R S = 1: S spreads what the equations lack back over the contact's velocities
            size = (mode.rows**2).sum(axis=1)  # a contact's rows are orthogonal
            self.S[own, mine] = (mode.rows / np.where(size > SHORT, size, np.inf)[:, None]).T
            self.target_mu[mine, k] = mode.target_mu
            if mode.normal != HELD:
                self.jump_mu[own, k] = mode.jump_mu
            if mode.normal == LOW:
                self.jump_low[own, k] = mode.jump_bound
            elif mode.normal == HIGH:
                self.jump_high[own, k] = mode.jump_bound
            at += count
        self.A = self.R @ G @ self.C + np.diag(weight)

    @cached_property
    def _factors(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Left and right singular vectors, and values, without those that are zero."""
        if self.size == 0:
            return np.zeros((0, 0)), np.zeros(0), np.zeros((0, 0))
        left, values, right = np.linalg.svd(self.A)
        rank = int((values > RANK * values[0]).sum())
        return left[:, :rank], values[:rank], right[:rank]

    @property
    def rank(self) -> int:
        """The rank of A."""
        return self._factors[1].size

    @property
    def condition(self) -> float:
        """Largest over smallest singular value of A that is not zero; 1 for an empty system."""
        values = self._factors[1]
        return float(values[0] / values[-1]) if values.size else 1.0

    def solve(self, q: FloatArray) -> FloatArray:
        """Return A⁺ q, (k,) or (k, c) as q."""
        left, values, right = self._factors
        return np.asarray(right.T @ ((left.T @ q).T / values).T)

    def beyond(self, q: FloatArray) -> FloatArray:
        """Return the part of q, (k,) or (k, c), that A reaches by no y."""
        if self.rank == self.size:
            return np.zeros_like(q)
        left = self._factors[0]
        return np.asarray(q - left @ (left.T @ q))

    @cached_property
    def after(self) -> tuple[FloatArray, FloatArray]:
        """Forces and velocities (3n, 6n) after u at fixed forces (3n), mu, normal_min, normal_max (n each).

        Formed once and used both ways: rates and gradients are adjoint whatever A's condition.
        """
        n = len(self.modes)
        # unit perturbations all at once: 6n right sides with one factorisation
        b, mu, low, high = np.split(np.eye(6 * n), [3 * n, 4 * n, 5 * n])
        return move(self, b, (mu, low, high))[:2]

    @cached_property
    def loose(self) -> float:
        """How far velocities are open: the largest ||G C y|| / ||G|| over unit y with A y = 0."""
        if self.rank == self.size:
            return 0.0
        # y with A y = 0 moves forces; whether it moves velocities as well is what G C y tells
        open_directions = np.linalg.svd(self.A)[2][self.rank :]
        scale = float(np.abs(self.G).max(initial=0.0))
        return float(np.linalg.norm(self.G @ self.C @ open_directions.T, 2)) / scale if scale > 0.0 else 0.0


def move(
    system: ActiveSystem, b: FloatArray, rates: tuple[FloatArray, ...]
) -> tuple[FloatArray, FloatArray, float]:
    """Return λ' and u', flat or column by column, and the norm of what was taken off.

    `b` is the rate of u at fixed forces, (3n,) or (3n, c); the rates are those of mu, normal_min and
    normal_max, (n,) or (n, c) each. Differentiates the active system, A y = target, by the implicit function
    theorem; where A misses a part of the right side, velocities keep it: no force moves there.
    """
    mu, low, high = rates
    jump = system.jump_mu @ mu + system.jump_low @ low + system.jump_high @ high
    q = system.target_mu @ mu - system.R @ (b + system.G @ jump)
    off = system.beyond(q)
    forces = system.C @ system.solve(q) + jump
    velocities = system.G @ forces + b + system.S @ off
    return forces, velocities, float(np.linalg.norm(off))


def polished(
    problem: ContactProblem, forces: FloatArray, velocities: FloatArray
) -> tuple[FloatArray, FloatArray, list[ContactState], list[Mode]]:
    """Return (n, 3) forces, velocities, contacts and modes after Newton steps on the active system.

    A semismooth Newton method: the modes are read anew from the natural map at every step. The steps stop
    when they shrink no more; the point with the least residual is kept, the given one if none is better.
    """
    best = forces.copy(), velocities.copy()
    error, last = residuals(problem, best[0]).worst, np.inf
    now, moving = best[0].copy(), best[1].copy()
    for _ in range(POLISH_STEPS):
        contacts = contacts_of(problem, now, moving)
        modes = [natural_mode(contact) for contact in contacts]
        system = ActiveSystem(problem.G, modes)
        parts = [defect(c, m) for c, m in zip(contacts, modes, strict=True)]
        jump = np.concatenate([p[0] for p in parts]) if parts else np.zeros(0)
        target = np.concatenate([p[1] for p in parts]) if parts else np.zeros(0)
        y = system.solve(target - system.R @ (moving.ravel() + problem.G @ jump))
        # one semismooth Newton step, without a proximal term: G's redundancy is the pseudo-inverse's affair
        step = system.C @ y + jump
        now = now + step.reshape(-1, 3)
        moving = problem.velocity(now)
        size = float(np.abs(step).max(initial=0.0))
        found = residuals(problem, now).worst
        if found <= error:
            error, best = found, (now.copy(), moving.copy())
        if not np.isfinite(size) or size <= 1e-16 * float(np.abs(now).max(initial=0.0)) or size >= last:
            break
        # quadratic convergence at least halves every step; one that does
        # not is rounding, or a change of modes
        last = 0.5 * size
    contacts = contacts_of(problem, *best)
    return best[0], best[1], contacts, [natural_mode(contact) for contact in contacts]
