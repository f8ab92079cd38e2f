"""Derivatives of a batch of solutions: products with rates and weights, compiled and on threads."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from surefoot.arrays import BoolArray, FloatArray, finite_array
from surefoot.batch.loops import derive_range, measure_range
from surefoot.contact.derivative import KINK, ContactDerivative
from surefoot.contact.derivative_rates import Cotangents, read_rates
from surefoot.contact.laws import Law
from surefoot.contact.problem import ContactProblem

InRanges = Callable[[Callable[[int, int], None], int, int], None]


@dataclass(frozen=True)
class BatchTangents:
    """Rates of forces and velocities (B, n, 3); zero where `valid` (B,) is False.

    `regular` (B,) is False where contacts are redundant, see `ContactDerivative`.
    """

    forces: FloatArray
    velocities: FloatArray
    valid: BoolArray
    regular: BoolArray


class BatchDerivative:
    """Derivatives of a batch's forces and velocities; `valid` (B,) is False where a problem is not SOLVED.

    Taken at the forces as they were solved, without polish: the error is that of the solution times the
    active system's condition (tol=1e-12 costs a Newton step more, and gives them to about 1e-12). `vjp`
    belongs to the mode that each contact is in; `jvp` is one-sided where `distance` is below 1e-9, each such
    problem by `ContactDerivative`.
    """

    def __init__(
        self, G: FloatArray, g: FloatArray, laws: FloatArray, mask: BoolArray, law: Law, buffers: FloatArray,
        valid: BoolArray, threads: int, in_ranges: InRanges,
    ) -> None:  # fmt: skip
        self._G, self._g, self._laws, self._mask, self._law = G, g, laws, mask, law
        self._buffers, self._threads, self._in_ranges = buffers, threads, in_ranges
        self.valid = valid

    @cached_property
    def distance(self) -> FloatArray:
        """(B,) distance to the nearest change of a mode, as a velocity over the largest of g."""
        B = len(self._g)
        found = np.full(B, np.inf)
        self._in_ranges(
            lambda a, b: measure_range(
                self._G, self._g, self._laws, self._mask, self._law == "convex", self._buffers, found, a, b
            ),
            B, self._threads,
        )  # fmt: skip
        return found

    def jvp(
        self,
        G: ArrayLike | None = None,
        g: ArrayLike | None = None,
        mu: ArrayLike | None = None,
        normal_min: ArrayLike | None = None,
        normal_max: ArrayLike | None = None,
        compliance: ArrayLike | None = None,
    ) -> BatchTangents:
        """Return how forces and velocities move with G (B, 3n, 3n), g (B, 3n), and the rest.

        mu, normal_min and normal_max: a number, (n,) or (B, n); compliance: a number, (n,), (3n,) or (B, 3n).

        Raises
        ------
        ProblemError
            If a shape is wrong or an entry is not finite.
        """
        n = self._g.shape[1] // 3
        rates = read_rates(self._forces, G, g, compliance, (mu, normal_min, normal_max))
        out, regular = self._run(True, rates)
        for k in np.flatnonzero(self.valid & (self.distance <= KINK)):
            self._one_sided(int(k), rates[k], out[k])
        return BatchTangents(out[:, :n], out[:, n:], self.valid, regular)

    def vjp(self, forces: ArrayLike | None = None, velocities: ArrayLike | None = None) -> Cotangents:
        """Return the gradients of forces·f + velocities·u, problem by problem, for (B, n, 3) weights.

        Raises
        ------
        ProblemError
            If a shape is wrong or an entry is not finite.
        """
        B, n = len(self._g), self._g.shape[1] // 3
        weights = np.zeros((B, 2 * n, 3))
        if forces is not None:
            weights[:, :n] = finite_array("forces", forces, (B, n, 3))
        if velocities is not None:
            weights[:, n:] = finite_array("velocities", velocities, (B, n, 3))
        out, regular = self._run(False, weights)
        return Cotangents(out, self._forces, regular, self.valid)

    @property
    def _forces(self) -> FloatArray:
        """The forces (B, n, 3), zero where not valid."""
        return np.where(self.valid[:, None, None], self._buffers[:, : self._g.shape[1] // 3], 0.0)

    def _run(self, forward: bool, given: FloatArray) -> tuple[FloatArray, BoolArray]:
        B = len(self._g)
        out, regular = np.empty_like(given), np.ones(B, dtype=np.bool_)
        self._in_ranges(
            lambda a, b: derive_range(
                self._G, self._laws, self._mask, self._law == "convex", self._buffers, forward, self.valid,
                given, out, regular, a, b,
            ),
            B, self._threads,
        )  # fmt: skip
        return out, regular

    def _one_sided(self, k: int, rates: FloatArray, out: FloatArray) -> None:
        """Fill the one-sided derivative of problem k, which is at a kink."""
        n = self._g.shape[1] // 3
        here = self._mask[k] if len(self._mask) else np.ones(n, dtype=np.bool_)
        laws = self._laws[k if len(self._laws) > 1 else 0]
        problem = problem_of(self._G[k], self._g[k], laws, here, self._law)
        d = ContactDerivative(
            problem, self._buffers[k, :n][here], self._buffers[k, n : 2 * n][here], kink_tol=10.0 * KINK
        )
        bounds = rates[n:][here]
        found = d.jvp(
            g=rates[:n][here].ravel(), mu=bounds[:, 0], normal_min=bounds[:, 1], normal_max=bounds[:, 2]
        )
        out[:] = 0.0
        out[:n][here], out[n:][here] = found.forces, found.velocities


def problem_of(G: FloatArray, g: FloatArray, laws: FloatArray, here: BoolArray, law: Law) -> ContactProblem:
    """Return one problem of a batch, (3n, 3n), (3n,) and (3, n), with the contacts that are there (n,)."""
    rows = np.repeat(here, 3)
    mu, low, high = laws[:, here]
    held = np.isinf(low)
    return ContactProblem(
        G[np.ix_(rows, rows)], g[rows], mu, np.where(held, 0.0, low), high, law, bilateral=held
    )  # fmt: skip
