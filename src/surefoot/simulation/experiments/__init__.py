"""The same experiment in every world, held against a closed form."""

from surefoot.simulation.experiments.experiment import (
    Curve,
    Experiment,
    Measurement,
    Outcome,
    carry_out,
    compare,
)
from surefoot.simulation.experiments.table import EXPERIMENTS, experiment_named

__all__ = [
    "EXPERIMENTS",
    "Curve",
    "Experiment",
    "Measurement",
    "Outcome",
    "carry_out",
    "compare",
    "experiment_named",
]
