"""Runs and summaries as they were called before the log had its own room; for one release."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from surefoot import audit
from surefoot.arrays import FloatArray
from surefoot.control.controller import Controller
from surefoot.log import Log
from surefoot.simulation.observers import Progress
from surefoot.simulation.run import run
from surefoot.simulation.scenario import STANDING_FALL, START_DEPTH, Scenario
from surefoot.simulation.world import World

WalkScenario = Scenario
"""Every scenario has faults now."""


def run_walking(
    world: World,
    controller: Controller,
    q: FloatArray,
    scenario: Scenario,
    progress: Callable[[float], None] | None = None,
    folder: Path | None = None,
) -> Log:
    """Run a walk from (nq,) q [m, -, rad]; now `surefoot.run`."""
    watching = [] if progress is None else [Progress(progress)]
    return run(world, controller, replace(scenario, start=q), watching, folder)


def run_standing(
    world: World, controller: Controller, q: FloatArray, scenario: Scenario, *more: Any, **named: Any
) -> Log:
    """Run a stand from (nq,) q [m, -, rad]; now `surefoot.run`."""
    return run_walking(
        world, controller, q, replace(scenario, depth=START_DEPTH, fall=STANDING_FALL), *more, **named
    )


def summarise(log: Log) -> dict[str, Any]:
    """Return the summary of a stand; now `surefoot.audit.summarise_stand`."""
    return audit.summarise_stand(log).as_dict()


def summarise_walk(log: Log) -> dict[str, Any]:
    """Return the summary of a walk; now `surefoot.audit.summarise_walk`."""
    return audit.summarise_walk(log).as_dict()
