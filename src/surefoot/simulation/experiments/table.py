"""All experiments by name."""

from __future__ import annotations

from surefoot.errors import check_name
from surefoot.simulation.experiments.bodies import BODIES
from surefoot.simulation.experiments.experiment import WorldExperiment
from surefoot.simulation.experiments.robots import ROBOTS

EXPERIMENTS: dict[str, WorldExperiment] = {e.name: e for e in (*BODIES, *ROBOTS)}
"""Name to experiment, in the order in which they are shown."""


def experiment_named(name: str) -> WorldExperiment:
    """Return an experiment.

    Raises
    ------
    ProblemError
        If there is none of that name; the message lists them.
    """
    check_name("experiment", name, EXPERIMENTS)
    return EXPERIMENTS[name]
