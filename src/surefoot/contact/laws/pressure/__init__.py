"""Pressure-field (hydroelastic) contact of compliant soles and boxes with rigid ground."""

from surefoot.contact.laws.pressure.field import PressureField, PressurePatch
from surefoot.contact.laws.pressure.pieces import CompliantSolid

__all__ = ["CompliantSolid", "PressureField", "PressurePatch"]
