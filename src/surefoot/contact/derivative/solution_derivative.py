"""The derivative of a solved contact problem: forces and velocities with respect to everything given.

See `ContactDerivative`; the modes are in `derivative_modes`, what happens between them in
`derivative_kinks`, the smoothed law in `derivative_path`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, finite_array
from surefoot.base.errors import ProblemError
from surefoot.contact.derivative.active_system import ActiveSystem, move, polished
from surefoot.contact.derivative.central_path import SmoothSystem, central_path
from surefoot.contact.derivative.kinks import Continuation, choices_of, directional
from surefoot.contact.derivative.rates import Cotangents, Tangents, read_rates
from surefoot.contact.problem.problem import ContactProblem

KINK = 1e-9
"""Default distance from a change of mode within which a contact is a kink."""


@dataclass(frozen=True)
class Kink:
    """A contact that is about to change its mode.

    Attributes
    ----------
    contact
        Its number.
    distance
        How far the change is, as a velocity (a force times w_k) over the problem's s_k; see
        `contact.problem.scales`. Dimensionless.
    modes
        The modes that meet there; the first is the one that `vjp` and dense blocks belong to.
    """

    contact: int
    distance: float
    modes: tuple[str, ...]


class ContactDerivative:
    """Derivatives of forces λ and velocities u = (G + R) λ + g of a solved problem.

    Implicit: the solution is polished to rounding, and only the unknowns that are free in its modes enter a
    linear system (3 for a contact that sticks, 2 for one that slides, none for one that is open).

    Where redundant contacts make that system singular, the derivatives are those along perturbations that
    keep its rank and keep g in its range: velocities and wrenches are determined, single forces are those of
    least norm. What else a perturbation contains is taken off; `redundant` says that it may be.

    At `kinks` there is no derivative, but one in every direction: `jvp` returns that, by finding the modes
    that its direction leads to. `vjp` and the dense blocks belong to `modes`.

    With `smoothing` > 0 it is the derivative at the point where λ_k·(u_k + Γ(u_k)) = smoothing for every
    contact, which has no kinks and in which open contacts carry smoothing / u_n: `forces` and `velocities`
    are that point. Its bias is the difference to the solution: of the order of the smoothing over the
    contact's normal force (velocities) and over its normal velocity (forces), and of the root of smoothing
    over ||G_kk||, or times it, at a kink.

    Parameters
    ----------
    problem, forces, velocities
        A solved problem; use `ContactSolution.derivative`.
    smoothing
        Normal force times normal velocity on the central path [W]; 0 for the law itself.
    kink_tol
        Distance below which a contact is a kink, see `Kink.distance`.

    Attributes
    ----------
    problem
        What was solved.
    forces, velocities
        (n, 3) where the derivative was taken: polished, or on the central path.
    smoothing
        As given.
    kinks
        `Kink`, nearest first; none with smoothing.
    """

    def __init__(
        self,
        problem: ContactProblem,
        forces: FloatArray,
        velocities: FloatArray,
        smoothing: float = 0.0,
        kink_tol: float = KINK,
    ) -> None:
        if problem.g.size != 3 * problem.contacts:
            raise ProblemError("derivatives take contacts of three rows each")
        if problem.facets is not None:
            raise ProblemError("derivatives take exact cones: solve the problem with facets=None")
        self.problem, self.smoothing = problem, smoothing
        self.kinks: tuple[Kink, ...] = ()
        self._choices: list[Continuation] = []
        self._system: ActiveSystem | SmoothSystem
        # to rounding first: a derivative is as wrong as its point is, times the condition
        f, u, contacts, modes = polished(problem, forces, velocities)
        if smoothing > 0.0:
            self._system = central_path(problem, f, smoothing)
            self.forces, self.velocities = self._system.forces, self._system.velocities
            self.modes: tuple[str, ...] = ("smooth",) * problem.contacts
            return
        self.forces, self.velocities = f, u
        self._contacts = contacts
        self._choices = choices_of(problem, contacts, modes, kink_tol)
        self._system = ActiveSystem(problem.G, [c.modes[0] for c in self._choices])
        self.modes = tuple(
            c.modes[0].name(contact) for c, contact in zip(self._choices, contacts, strict=True)
        )
        self.kinks = tuple(
            sorted(
                (
                    Kink(k, c.distance, tuple(dict.fromkeys(m.name(contacts[k]) for m in c.modes)))
                    for k, c in enumerate(self._choices)
                    if c.distance <= kink_tol and len(c.modes) > 1
                ),
                key=lambda kink: kink.distance,
            )
        )

    @property
    def rank(self) -> int:
        """The rank of the active system."""
        return self._system.rank

    @property
    def size(self) -> int:
        """The number of free unknowns."""
        return self._system.size

    @property
    def redundant(self) -> bool:
        """Whether the active system is singular, so that parts of perturbations may be taken off."""
        return self.rank < self.size

    @property
    def condition(self) -> float:
        """The condition of the active system, in the unknowns that it determines."""
        return self._system.condition

    @property
    def velocities_determined(self) -> bool:
        """Whether what the active system leaves open are forces only."""
        return self._system.loose <= 1e-9

    def jvp(
        self,
        G: ArrayLike | None = None,
        g: ArrayLike | None = None,
        mu: ArrayLike | None = None,
        normal_min: ArrayLike | None = None,
        normal_max: ArrayLike | None = None,
        compliance: ArrayLike | None = None,
    ) -> Tangents:
        """Return how forces and velocities move if what was given does.

        Parameters
        ----------
        G
            (3n, 3n) rate of G [1/kg]; its symmetric part counts.
        g
            (3n,) rate of the free velocity [m/s].
        mu, normal_min, normal_max
            Rates, a number or (n,); at infinite bounds they change nothing, and with smoothing neither does a
            normal_min of zero, the apex of its cone.
        compliance
            Rate of R, a number, (n,) or (3n,).

        Raises
        ------
        ProblemError
            If a shape is wrong or an entry is not finite.
        """
        b, rates = read_rates(self.forces, G, g, compliance, (mu, normal_min, normal_max))
        system = self._system
        if isinstance(system, SmoothSystem):
            f, u = (block @ np.concatenate([b, *rates]) for block in system.after)
            return Tangents(f.reshape(-1, 3), u.reshape(-1, 3))
        modes, settled = [c.modes[0] for c in self._choices], True
        if any(len(c.modes) > 1 for c in self._choices):
            modes, settled = directional(self.problem.G, self._contacts, self._choices, b, rates)
            system = ActiveSystem(self.problem.G, modes)
        f, u, removed = move(system, b, rates)
        return Tangents(f.reshape(-1, 3), u.reshape(-1, 3), removed, settled)

    def vjp(self, forces: ArrayLike | None = None, velocities: ArrayLike | None = None) -> Cotangents:
        """Return the gradient of forces·f + velocities·u, for (n, 3) weights.

        Raises
        ------
        ProblemError
            If a shape is wrong or an entry is not finite.
        """
        n = self.problem.contacts
        f, u = (
            np.zeros(3 * n) if value is None else finite_array(name, value, (n, 3)).ravel()
            for name, value in (("forces", forces), ("velocities", velocities))
        )
        by_force, by_velocity = self._system.after
        back = by_force.T @ f + by_velocity.T @ u
        out = np.concatenate([back[: 3 * n].reshape(n, 3), back[3 * n :].reshape(3, n).T])
        return Cotangents(out, self.forces, not self.redundant)

    @cached_property
    def _dense(self) -> dict[str, tuple[FloatArray, FloatArray]]:
        """Forces and velocities (3n, m) by what they are taken after: g, mu, normal_min, normal_max."""
        n = self.problem.contacts
        parts = (np.split(block, [3 * n, 4 * n, 5 * n], axis=1) for block in self._system.after)
        return dict(zip(("g", "mu", "normal_min", "normal_max"), zip(*parts, strict=True), strict=True))

    def __getattr__(self, name: str) -> Any:
        """Return a dense block: `dforces_dg` (3n, 3n), `dvelocities_dmu` (3n, n), and so on; see `BLOCKS`."""
        if name not in BLOCKS:
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        what, _, after = name.removeprefix("d").partition("_d")
        return self._dense[after][("forces", "velocities").index(what)]

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *BLOCKS})

    def __repr__(self) -> str:
        return (
            f"ContactDerivative(modes={self.modes}, kinks={self.kinks}, rank={self.rank} of {self.size}, "
            f"smoothing={self.smoothing:g})"
        )


BLOCKS = tuple(
    f"d{what}_d{after}"
    for what in ("forces", "velocities")
    for after in ("g", "mu", "normal_min", "normal_max")
)
