"""Rigid-body dynamics as CasADi expressions, for planners that hand them to an optimiser."""
