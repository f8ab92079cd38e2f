"""Moved: see `surefoot.simulation.run`; these names work for one release."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from surefoot.arrays import FloatArray
from surefoot.control.controller import Controller
from surefoot.log import Log
from surefoot.moved import moved
from surefoot.simulation.observers import Progress
from surefoot.simulation.run import run
from surefoot.simulation.scenario import Scenario
from surefoot.simulation.world import World

__getattr__ = moved(__name__, {"WalkScenario": "surefoot.simulation.scenario:Scenario"})


def run_walking(
    world: World,
    controller: Controller,
    q: FloatArray,
    scenario: Scenario,
    progress: Callable[[float], None] | None = None,
    folder: Path | None = None,
) -> Log:
    """Run a walk from a configuration; now `surefoot.simulation.run.run`."""
    warnings.warn("run_walking is now surefoot.run", DeprecationWarning, stacklevel=2)
    watching = [] if progress is None else [Progress(progress)]
    return run(world, controller, replace(scenario, start=q), watching, folder)
