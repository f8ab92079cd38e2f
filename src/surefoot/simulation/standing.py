"""Moved: see `surefoot.simulation.run`; this works for one release."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from surefoot.arrays import FloatArray
from surefoot.control.controller import Controller
from surefoot.log import Log
from surefoot.simulation.observers import Progress
from surefoot.simulation.run import run
from surefoot.simulation.scenario import STANDING_FALL, START_DEPTH, Scenario
from surefoot.simulation.world import World


def run_standing(
    world: World,
    controller: Controller,
    q: FloatArray,
    scenario: Scenario,
    progress: Callable[[float], None] | None = None,
    folder: Path | None = None,
) -> Log:
    """Run a stand from a configuration; now `surefoot.simulation.run.run`."""
    warnings.warn("run_standing is now surefoot.run", DeprecationWarning, stacklevel=2)
    scenario = replace(scenario, start=q, depth=START_DEPTH, fall=STANDING_FALL)
    return run(world, controller, scenario, [] if progress is None else [Progress(progress)], folder)
