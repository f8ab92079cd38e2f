"""Moved, see below; these names work for one release."""

from surefoot.moved import moved

__getattr__ = moved(__name__, {"sole_pressures": ("surefoot.audit", "surefoot.audit.sole_pressures")})
