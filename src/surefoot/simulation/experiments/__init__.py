"""The same experiment in every world, held against a closed form."""

from surefoot.simulation.experiments.experiment import (
    Curve,
    Measurement,
    WorldExperiment,
    WorldsOutcome,
    carry_out,
    compare,
)
from surefoot.simulation.experiments.table import EXPERIMENTS, experiment_named

__all__ = [
    "EXPERIMENTS",
    "Curve",
    "Measurement",
    "WorldExperiment",
    "WorldsOutcome",
    "carry_out",
    "compare",
    "experiment_named",
]
