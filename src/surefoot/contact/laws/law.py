"""What a contact law is: how much of De Saxcé's shift stands between velocities and the normal cone."""

from __future__ import annotations

from typing import Self

from surefoot.base.arrays import real_number


class Law(str):
    """A contact law on the velocity level, a value that reads and compares as its name.

    Every law here is one cone complementarity problem, K ∋ λ ⟂ u + θ Γ(u) ∈ K*, with Γ(u) the most power that
    a unit of normal force can take out by friction, along the normal (`sets.ContactKind.shift`). At θ = 1
    friction dissipates the most it can and the contact does not open (Coulomb); at θ = 0 the flow is
    associated, u is normal to K, and a sliding contact opens by (1 - θ) Γ(u) (convex). What is between is
    dilatant friction: a sliding contact opens at a slope of its own, as in soil.

    Parameters
    ----------
    name
        What it is called in messages and files.
    shift
        θ [-], in [0, 1].

    Raises
    ------
    ProblemError
        If θ is not in [0, 1].

    References
    ----------
    .. [1] G. De Saxcé, Z.-Q. Feng, "The bipotential method: a constructive approach to design the complete
       contact law with friction and improved numerical algorithms", Math. Comput. Modelling 28, 1998.
    """

    shift: float

    def __new__(cls, name: str, shift: float) -> Self:
        """Make a law; a str is made here, not in __init__."""
        law = super().__new__(cls, name)
        law.shift = real_number("shift", shift, low=0.0, high=1.0)
        return law

    def shift_at(self, mu: float) -> float:
        """Return θ [-] of a contact of friction coefficient mu [-]; the law's own, unless overridden."""
        return self.shift

    def __getnewargs__(self) -> tuple[str, float]:  # type: ignore[override]
        return str(self), self.shift


COULOMB = Law("coulomb", shift=1.0)
"""K ∋ λ ⟂ u + Γ(u) ∈ K*, exact; no minimum of any energy.

Source: J. J. Moreau, "Unilateral contact and dry friction in finite freedom dynamics", 1988 (maximum
dissipation); De Saxcé and Feng 1998 (the shift); Acary, Cadoux, Lemaréchal, Malick 2011 (existence).
"""


CONVEX = Law("convex", shift=0.0)
"""K ∋ λ ⟂ u ∈ K*: a sliding contact opens by mu ||u_t||, the price of convexity.

Source: M. Anitescu, "Optimization-based simulation of nonsmooth rigid multibody dynamics", Math. Programming
105, 2006.
"""
