"""Moved, see below; these names work for one release."""

from surefoot.deprecation import moved

__getattr__ = moved(__name__, dict.fromkeys(("run_walking", "WalkScenario"), "surefoot.simulation.old"))
