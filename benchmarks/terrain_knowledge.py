"""How a Go2 walks on ground that it is not told: stairs, a slope and ice, by what it knows.

Run: python -m benchmarks.terrain_knowledge --quick      (one seed of the two shortest tasks)
     python -m benchmarks.terrain_knowledge --seeds 20 --task ice
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from benchmarks import walks
from benchmarks.printing import options, show
from benchmarks.printing import table as table_of
from surefoot.base.arrays import FloatArray
from surefoot.mechanics.robot import Robot
from surefoot.mechanics.terrain import Terrain
from surefoot.motion.control.controller import Controller
from surefoot.motion.ground.terrain_knowledge import KNOWLEDGE, controller_ground
from surefoot.motion.walking.walkers import walking_controller
from surefoot.records.audit import summarise_walk
from surefoot.worlds.running.height_scan import RangeSensor
from surefoot.worlds.running.run import IcePatch
from surefoot.worlds.running.sensors import SensorModel
from surefoot.worlds.sweep.survival import wilson

OFF_COURSE = 0.5
"""A walk that ends further beside its line is off course [m]."""


@dataclass(frozen=True)
class Walk(walks.Walk):
    """A trot of Go2 on ground that it is not told all of.

    Attributes
    ----------
    knowledge
        What it knows of the ground, see `KNOWLEDGE`.
    watch
        Whether it finds out the friction.
    """

    gait: str | None = "trot"
    knowledge: str = "exact"
    watch: bool = False

    def controller(self, robot: Robot, terrain: Terrain) -> Controller:
        """Return the walking controller with its belief."""
        return walking_controller(
            robot, self.command, self.gait, controller_ground(self.knowledge, terrain), self.counted_on,
            self.motors(robot), watch_friction=self.watch,
        )  # fmt: skip


@dataclass(frozen=True)
class Task:
    """A walk, what tables call it, and how long it is [s]."""

    title: str
    duration: float
    walk: Walk


def _walk(terrain: str, speed: float, **changed: Any) -> Walk:
    return Walk(velocity=(speed, 0.0, 0.0), terrain=terrain, believed_mu=0.6, **changed)


PATCH = IcePatch((0.5, -3.0), (2.0, 3.0), 0.1)
TASKS = {
    "up": Task("ten steps of 12 cm up", 11.0, _walk("stairs:0.12,0.3", 0.4)),
    "down": Task("ten steps of 12 cm down", 11.0, _walk("stairs:-0.12,0.3", 0.4)),
    "slope": Task("slope of 20 degrees", 5.0, _walk("slope:20", 0.5)),
    "ice": Task("mu 0.2, not told", 5.0, _walk("flat", 0.5, mu=0.2, watch=True)),
    "ice-unaware": Task("mu 0.2, told 0.6", 5.0, _walk("flat", 0.5, mu=0.2)),
    "patch": Task("1.5 m of mu 0.1", 8.0, _walk("flat", 0.5, watch=True, patches=(PATCH,))),
}


@dataclass(frozen=True)
class Outcome:
    """What one walk came to: how it ended, mean speed [m/s], slip [mm], unrest of the body."""

    upright: bool
    on_course: bool
    lawful: bool
    speed: float
    slip: float
    pitch_rate: float
    heave: float


def walk(task: Task, knowledge: str, seed: int, actuators: str = "ideal", truth: bool = False) -> Outcome:
    """Return the outcome of a walk in MuJoCo with full collision geometry."""
    chosen = replace(
        task.walk, knowledge=knowledge, options={"collision": "full", "actuators": actuators},
        sensors=None if truth else SensorModel(heights=knowledge == "exact"),
        scanner=RangeSensor() if knowledge == "map" else None,
    )  # fmt: skip
    log = chosen.log(seed, task.duration)
    summary = summarise_walk(log)
    moving = log["time"] > 1.0
    return Outcome(
        summary.outcome == "walked",
        bool(abs(log["q"][-1, 1]) < OFF_COURSE),
        not summary.laws_broken,
        summary.velocity.forward.measured,
        1e3 * max(foot.slip for foot in summary.feet),
        _rms(log["v"][moving, 4]),
        _rms(np.diff(_smooth(log["q"][moving, 2]), 2) * 1e6),
    )


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values * values))) if values.size else float("nan")


def _smooth(values: FloatArray, width: int = 20) -> FloatArray:
    """Return means over 20 ms, so that impacts of feet do not hide how the body moves; none of less."""
    if len(values) < width:
        return values[:0]
    return np.convolve(values, np.full(width, 1.0 / width), "valid")


def table(tasks: Sequence[str], knowledge: Sequence[str], seeds: int, actuators: str, truth: bool) -> Table:
    """Return the table of all tasks with all kinds of knowledge."""
    names = (
        "task", "knowledge", "upright, on course", "95 %", "lawful too", "speed [m/s]", "worst slip [mm]",
        "pitch rate [rad/s]", "heave [m/s²]",
    )  # fmt: skip
    rows = []
    for name in tasks:
        for known in knowledge:
            runs = [walk(TASKS[name], known, seed, actuators, truth) for seed in range(1, seeds + 1)]
            good = [one for one in runs if one.upright and one.on_course]
            share = wilson(len(good), seeds)
            figures = np.array([(o.speed, o.slip, o.pitch_rate, o.heave) for o in good]).reshape(-1, 4)
            numbers = ["-"] * 4
            if good:
                middle, worst = np.median(figures, axis=0), figures.max(axis=0)
                numbers = [f"{value:.3g}" for value in (middle[0], worst[1], *middle[2:])]
            rows.append((
                TASKS[name].title, known, f"{len(good)} of {seeds}", f"{share.low:.2f} to {share.high:.2f}",
                str(sum(one.lawful for one in good)), *numbers,
            ))  # fmt: skip
    return table_of(names, rows, f"go2, {seeds} seeds, actuators {actuators}", left=2)


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the table."""
    parser = options(__doc__, "one seed on ice and on the slope", seeds=5)
    parser.add_argument("--task", choices=sorted(TASKS), action="append")
    parser.add_argument("--knowledge", choices=KNOWLEDGE, action="append")
    parser.add_argument("--actuators", choices=("ideal", "real"), default="ideal")
    parser.add_argument("--truth", action="store_true", help="the controller is told the true state")
    given = parser.parse_args(arguments)
    tasks = given.task or (["ice", "slope"] if given.quick else list(TASKS))
    knowledge = given.knowledge or (["exact"] if given.quick else list(KNOWLEDGE))
    seeds = 1 if given.quick else given.seeds
    found = table(tasks, knowledge, seeds, given.actuators, given.truth)
    show([found], given.json, Console(width=150))


if __name__ == "__main__":
    main()
