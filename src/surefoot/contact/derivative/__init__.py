"""Derivatives of a solved contact problem with respect to everything it was given."""
