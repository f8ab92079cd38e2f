"""Moved, see below; these names work for one release."""

from surefoot.moved import moved

__getattr__ = moved(
    __name__,
    {
        "run_walking": ("surefoot.simulation.old", "surefoot.run"),
        "WalkScenario": ("surefoot.simulation.scenario", "surefoot.Scenario"),
    },
)
