"""The contact problem: one statement for simulation and control."""

from __future__ import annotations

from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from surefoot.arrays import finite_array, per_contact
from surefoot.cones import FrictionPyramid
from surefoot.errors import ProblemError, unknown_name

Law = Literal["coulomb", "convex"]
Fit = Literal["inner", "outer"]
LAWS: tuple[Law, ...] = ("coulomb", "convex")


class ContactProblem:
    """Find contact forces λ and velocities u = G λ + g that obey the contact laws.

    With K the product of the friction cones cut to the normal bounds, and Γ(u) = (0, 0, mu ||u_t||)
    the De Saxcé shift::

        law="coulomb":   -(u + Γ(u)) is in the normal cone of K at λ   (for K without bounds:
                         K ∋ λ ⟂ u + Γ(u) ∈ K*)
        law="convex":    -u is in the normal cone of K at λ, the optimality condition of
                         min 1/2 λᵀGλ + gᵀλ over K

    Each contact is (tangent, tangent, normal). Impulses and velocities, or forces and accelerations:
    the statement is the same.

    Parameters
    ----------
    G
        (3n, 3n) Delassus operator, symmetric positive semidefinite.
    g
        (3n,) free velocity.
    mu
        Friction coefficient, a number or (n,), finite and >= 0.
    normal_min, normal_max
        Bounds on the normal forces, a number or (n,); normal_max = 0 switches a contact off.
    law
        "coulomb" (exact) or "convex" (cone complementarity: adds a separation velocity mu ||u_t||
        to sliding contacts).

    Raises
    ------
    ProblemError
        If it is not a problem: wrong shapes, NaN, mu < 0, G not symmetric, bounds out of order.

    References
    ----------
    .. [1] V. Acary, F. Cadoux, C. Lemaréchal, J. Malick, "A formulation of the linear discrete Coulomb
       friction problem via convex optimization", ZAMM 91(2), 2011.
    """

    def __init__(
        self,
        G: ArrayLike,
        g: ArrayLike,
        mu: ArrayLike,
        normal_min: ArrayLike = 0.0,
        normal_max: ArrayLike = np.inf,
        law: Law = "coulomb",
        facets: int | None = None,
        fit: Fit = "inner",
    ) -> None:
        if law not in LAWS:
            raise ProblemError(unknown_name("law", law, LAWS))
        self.law: Law = law
        self.g = finite_array("g", g, (None,))
        size = self.g.shape[0]
        if size % 3:
            raise ProblemError(f"g must have three entries per contact, got {size}")
        self.G = finite_array("G", G, (size, size))
        self.contacts = size // 3
        self.mu = per_contact("mu", mu, self.contacts)
        if np.isinf(self.mu).any():
            raise ProblemError("mu must be finite, got inf")
        self.normal_min = per_contact("normal_min", normal_min, self.contacts)
        self.normal_max = per_contact("normal_max", normal_max, self.contacts)
        if facets is not None or fit != "inner":
            FrictionPyramid(0.5, facets if facets is not None else 8, fit)  # its checks are ours
        self.facets, self.fit = facets, fit
        self._check()

    def polyhedral(self, facets: int = 8, fit: Fit = "inner") -> ContactProblem:
        """Return the same problem with pyramids of `facets` sides in place of the exact cones."""
        return ContactProblem(
            self.G, self.g, self.mu, self.normal_min, self.normal_max, self.law, facets, fit
        )

    def _check(self) -> None:
        crossed = self.normal_min > self.normal_max
        if crossed.any():
            k = int(np.argmax(crossed))
            raise ProblemError(
                f"normal_min must be <= normal_max, got {self.normal_min[k]:g} > "
                f"{self.normal_max[k]:g} at contact {k}"
            )
        scale = float(np.abs(self.G).max(initial=0.0))
        gap = np.abs(self.G - self.G.T)
        if gap.max(initial=0.0) > 1e-8 * scale:
            i, j = np.unravel_index(int(np.argmax(gap)), gap.shape)
            raise ProblemError(
                f"G must be symmetric, but G[{i}, {j}] = {self.G[i, j]:g} and G[{j}, {i}] = {self.G[j, i]:g}"
            )

    def __repr__(self) -> str:
        sides = "" if self.facets is None else f", facets={self.facets}, fit={self.fit!r}"
        return f"ContactProblem(contacts={self.contacts}, law={self.law!r}{sides})"

    @cached_property
    def norm(self) -> float:
        """The spectral norm ||G||₂, largest eigenvalue of the symmetric part."""
        if self.contacts == 0:
            return 0.0
        return float(np.abs(np.linalg.eigvalsh(self.G)).max())
