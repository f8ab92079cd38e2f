"""Coulomb's law: unilateral contact, the friction cone, and friction that dissipates the most it can."""

from surefoot.contact.laws.law import Law

COULOMB = Law("coulomb", shift=1.0)
"""K ∋ λ ⟂ u + Γ(u) ∈ K*, exact; no minimum of any energy.

Source: J. J. Moreau, "Unilateral contact and dry friction in finite freedom dynamics", 1988 (maximum
dissipation); De Saxcé and Feng 1998 (the shift); Acary, Cadoux, Lemaréchal, Malick 2011 (existence).
"""
