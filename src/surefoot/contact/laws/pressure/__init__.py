"""Pressure-field (hydroelastic) contact of compliant soles and boxes with rigid ground."""

from surefoot.contact.laws.pressure.field import PressureField
from surefoot.contact.laws.pressure.patch import PressurePatch
from surefoot.contact.laws.pressure.solid import CompliantSolid

__all__ = ["CompliantSolid", "PressureField", "PressurePatch"]
