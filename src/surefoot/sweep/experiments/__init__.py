"""What a sweep runs for each sample: one experiment per file, one line each in the table."""

from surefoot.sweep.experiments.experiment import Experiment
from surefoot.sweep.experiments.table import EXPERIMENTS, make_experiment

__all__ = ["EXPERIMENTS", "Experiment", "make_experiment"]
