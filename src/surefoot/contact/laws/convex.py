"""The convex law, cone complementarity: the optimality condition of min 1/2 λᵀGλ + gᵀλ over K."""

from surefoot.contact.laws.law import Law

CONVEX = Law("convex", shift=0.0)
"""K ∋ λ ⟂ u ∈ K*: a sliding contact opens by mu ||u_t||, the price of convexity.

Source: M. Anitescu, "Optimization-based simulation of nonsmooth rigid multibody dynamics", Math. Programming
105, 2006.
"""
