"""The derivative of a step's contact problem: its dense blocks at once, or in one direction at a kink."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.contact import KINK, ContactDerivative, ContactSolution, contact_blocks, measure_range

REGULAR = 1e-9
"""Compliance of redundant contacts where a regular derivative is asked for, over the trace of G."""


class Response:
    """Impulses as a function of what goes into their problem.

    Parameters
    ----------
    solution
        Of the step's contact problem.
    smoothing
        See `ContactDerivative`.

    Raises
    ------
    NoSolution
        If it is not SOLVED.
    """

    def __init__(self, solution: ContactSolution, smoothing: float) -> None:
        solution.raise_if_failed()
        self.regular, p = False, solution.problem
        self.solution, self.smoothing = solution, smoothing
        # forces and velocities, mu and bounds (3, k), as compiled calls take them
        self._buffer = np.concatenate([solution.forces, solution.velocities])
        self._laws = np.array([p.mu, p.normal_min, p.normal_max])

    @cached_property
    def derivative(self) -> ContactDerivative:
        """The derivative of the problem; polished, with its kinks."""
        return self.solution.derivative(self.smoothing)

    @cached_property
    def forces(self) -> FloatArray:
        """The (k, 3) impulses [N s] at which it is taken."""
        return self.derivative.forces if self.smoothing > 0.0 else self.solution.forces

    @cached_property
    def distance(self) -> float:
        """Distance to the nearest change of a mode, see `Kink.distance`."""
        if self.smoothing > 0.0:
            return np.inf
        p = self.solution.problem
        found = np.empty(1)
        measure_range(
            p.G[None], p.g[None], self._laws[None], p.law == "convex", self._buffer[None], found, 0, 1
        )
        return float(found[0])

    @cached_property
    def blocks(self) -> tuple[FloatArray, FloatArray]:
        """The derivative of the impulses by b (3k, 3k) [kg], and by every contact's mu (3k, k) [N s]."""
        p = self.solution.problem
        if self.smoothing == 0.0 and p.contacts:
            out = np.empty((3 * p.contacts, 4 * p.contacts))
            given = self._laws, p.law == "convex", self._buffer
            found = contact_blocks(p.G, *given, out)
            if not found and self.regular:
                found = contact_blocks(p.G + REGULAR * np.trace(p.G) * np.eye(len(p.G)), *given, out)
            if found:
                return out[:, : 3 * p.contacts], out[:, 3 * p.contacts :]
        d = self.derivative
        return d.dforces_dg, d.dforces_dmu

    def linear(self, b: FloatArray, mu: FloatArray) -> FloatArray:
        """Return the rates (3k, c) of the impulses [N s], of b (3k, c) and mu (k, c), in these modes."""
        by_g, by_mu = self.blocks
        return np.asarray(by_g @ b + by_mu @ mu)

    def one_sided(self, b: FloatArray, mu: FloatArray) -> FloatArray:
        """Return the same (3k, c) [N s] for each column of its own, in the modes that it leads to."""
        if not self.distance <= 10.0 * KINK:
            return self.linear(b, mu)
        found = [self.derivative.jvp(g=b[:, j], mu=mu[:, j]).forces.ravel() for j in range(b.shape[1])]
        return np.stack(found, axis=1)
