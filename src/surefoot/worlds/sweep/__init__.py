"""Domain randomisation: ranges as data, experiments over samples of them, on many workers, safe to kill."""

from surefoot.worlds.sweep.config import SweepConfig as SweepConfig
from surefoot.worlds.sweep.config import read_sweep as read_sweep
from surefoot.worlds.sweep.config import sweep_from_dict as sweep_from_dict
from surefoot.worlds.sweep.driver import SweepResult as SweepResult
from surefoot.worlds.sweep.driver import merge_sweep as merge_sweep
from surefoot.worlds.sweep.driver import run_sweep as run_sweep
from surefoot.worlds.sweep.sample_experiment import EXPERIMENTS as EXPERIMENTS
from surefoot.worlds.sweep.sample_experiment import SweepExperiment as SweepExperiment
from surefoot.worlds.sweep.sample_experiment import number as number
from surefoot.worlds.sweep.space import NumberRange as NumberRange
from surefoot.worlds.sweep.space import Space as Space
from surefoot.worlds.sweep.space import TextRange as TextRange
