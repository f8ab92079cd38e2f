"""Four quadrupeds, eight jumps and a flip: whether plans are SOLVED, and their executions land lawfully."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from typing import Any

from benchmarks.execution.trials import Row, measure
from surefoot.mechanics.robot import load_robot
from surefoot.motion.planning import Plan
from surefoot.motion.planning.planner import plan

ROBOTS = ("go2", "a1", "solo12", "anymal_c")
CELLS: dict[str, tuple[str, float | None, dict[str, float]]] = {
    **{f"jump {way:g}": ("jump", way, {}) for way in (0.2, 0.3, 0.4, 0.5, 0.6)},
    "jump-up 0.2": ("jump-up", 0.2, {}),
    "sideways 0.3": ("jump", 0.3, {"direction": 0.5 * math.pi}),
    "turn 90": ("jump", 0.0, {"turn": 0.5 * math.pi}),
    "backflip": ("backflip", None, {}),
}
"""By name: task, number, and what else is asked for; the backflip is Go2's alone."""


@dataclass(frozen=True)
class Cell:
    """A robot and a task: the plan's status, CPU time [s] and forecast, and its runs where it is SOLVED."""

    robot: str
    task: str
    status: str
    seconds: float
    forecast: str
    runs: Row | None


def cells() -> list[tuple[str, str]]:
    """Return the robots and tasks of the matrix."""
    return [(robot, name) for robot in ROBOTS for name in CELLS if name != "backflip" or robot == "go2"]


def planned(robot: str, name: str) -> tuple[Plan, float]:
    """Return a cell's plan and the CPU time of its search [s]."""
    task, amount, asked = CELLS[name]
    begun, extra = time.process_time(), dict[str, Any](asked)
    return plan(load_robot(robot), task, amount, **extra), time.process_time() - begun


def measured(robot: str, name: str, seeds: int) -> Cell:
    """Return a cell; plans that are not SOLVED are not executed."""
    made, seconds = planned(robot, name)
    status = made.status.value
    runs = measure(made, name, seeds, ("box",))[0] if status == "solved" and seeds else None
    return Cell(robot, name, status, seconds, str(made.facts["goal"]), runs)
