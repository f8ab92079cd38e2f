"""Domain randomisation: ranges as data, experiments over samples of them, on many workers, safe to kill."""

from surefoot.sweep.config import SweepConfig, read_sweep, sweep_from_dict
from surefoot.sweep.driver import SweepResult, run_sweep
from surefoot.sweep.experiment import EXPERIMENTS, SweepExperiment, number
from surefoot.sweep.space import NumberRange, Space, TextRange

__all__ = [
    "EXPERIMENTS",
    "NumberRange",
    "Space",
    "SweepConfig",
    "SweepExperiment",
    "SweepResult",
    "TextRange",
    "number",
    "read_sweep",
    "run_sweep",
    "sweep_from_dict",
]
