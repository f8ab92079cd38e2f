"""The same experiment in every world, held against a closed form."""

from __future__ import annotations

from surefoot.worlds.experiments.body_experiments import BODIES
from surefoot.worlds.experiments.experiment import WorldExperiment
from surefoot.worlds.experiments.experiment import carry_out as carry_out

EXPERIMENTS: dict[str, WorldExperiment] = {e.name: e for e in BODIES}
"""Name to experiment, in the order in which they are shown."""
