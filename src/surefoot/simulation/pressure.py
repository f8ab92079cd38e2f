"""Moved: see `surefoot.audit`; these names work for one release."""

from surefoot.moved import moved

__getattr__ = moved(__name__, dict.fromkeys(("SolePressure", "sole_pressures"), "surefoot.audit"))
