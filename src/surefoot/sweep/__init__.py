"""Domain randomisation: ranges as data, experiments over samples of them, on many workers, safe to kill."""

from surefoot.sweep.config import SweepConfig, read_sweep, sweep_from_dict
from surefoot.sweep.driver import SweepResult, run_sweep
from surefoot.sweep.experiment import EXPERIMENTS, Experiment, number
from surefoot.sweep.ranges import Choice, Interval
from surefoot.sweep.space import Sample, Space

__all__ = [
    "EXPERIMENTS",
    "Choice",
    "Experiment",
    "Interval",
    "Sample",
    "Space",
    "SweepConfig",
    "SweepResult",
    "number",
    "read_sweep",
    "run_sweep",
    "sweep_from_dict",
]
