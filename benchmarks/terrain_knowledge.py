"""How a Go2 walks on ground that it is not told: stairs, a slope and ice, by what it knows.

Run: python -m benchmarks.terrain_knowledge --quick      (one seed of the two shortest tasks)
     python -m benchmarks.terrain_knowledge --seeds 20 --task ice
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from rich.console import Console
from rich.table import Table

from benchmarks.printing import show
from surefoot.arrays import FloatArray
from surefoot.audit import summarise_walk
from surefoot.control.actuators import actuators_of
from surefoot.control.terrain_knowledge import KNOWLEDGE, believed_ground
from surefoot.control.walkers import walking_controller
from surefoot.control.walking_body import VelocityCommand
from surefoot.robot import load_robot
from surefoot.simulation.height_scan import RangeSensor
from surefoot.simulation.run import IcePatch, Scenario, run
from surefoot.simulation.sensors import SensorModel
from surefoot.simulation.walk_terrain import start_pose
from surefoot.simulation.worlds import make_world
from surefoot.sweep.survival import wilson
from surefoot.terrain import read_terrain

OFF_COURSE = 0.5
"""A walk that ends further beside its line is off course [m]."""


@dataclass(frozen=True)
class Task:
    """A walk.

    Attributes
    ----------
    title, terrain, speed, duration
        For the table, as for ``--terrain``, [m/s], [s].
    mu, assumed, watch
        Friction of the ground, what the controller starts from, and whether it finds out.
    patches
        Of ice.
    """

    title: str
    terrain: str
    speed: float
    duration: float
    mu: float = 0.6
    assumed: float = 0.6
    watch: bool = False
    patches: tuple[IcePatch, ...] = ()


TASKS = {
    "up": Task("ten steps of 12 cm up", "stairs:0.12,0.3", 0.4, 11.0),
    "down": Task("ten steps of 12 cm down", "stairs:-0.12,0.3", 0.4, 11.0),
    "slope": Task("slope of 20 degrees", "slope:20", 0.5, 5.0),
    "ice": Task("mu 0.2, not told", "flat", 0.5, 5.0, mu=0.2, watch=True),
    "ice-unaware": Task("mu 0.2, told 0.6", "flat", 0.5, 5.0, mu=0.2),
    "patch": Task(
        "1.5 m of mu 0.1", "flat", 0.5, 8.0, watch=True, patches=(IcePatch((0.5, -3.0), (2.0, 3.0), 0.1),)
    ),
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
    robot, ground = load_robot("go2"), read_terrain(task.terrain)
    controller = walking_controller(
        robot, VelocityCommand.constant(task.speed), "trot", believed_ground(knowledge, ground),
        task.assumed, actuators_of(robot, actuators), watch_friction=task.watch,
    )  # fmt: skip
    scenario = Scenario(
        task.duration, task.mu, start=start_pose(robot, ground), seed=seed, patches=task.patches,
        sensors=None if truth else SensorModel(heights=knowledge == "exact"),
        scanner=RangeSensor() if knowledge == "map" else None,
    )  # fmt: skip
    world = make_world("mujoco", robot, ground, task.mu, collision="full", actuators=actuators)
    log = run(world, controller, scenario)
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
    out = Table(
        "task", "knowledge", "upright, on course", "95 %", "lawful too", "speed [m/s]", "worst slip [mm]",
        "pitch rate [rad/s]", "heave [m/s²]", title=f"go2, {seeds} seeds, actuators {actuators}",
    )  # fmt: skip
    for name in tasks:
        for known in knowledge:
            runs = [walk(TASKS[name], known, seed, actuators, truth) for seed in range(1, seeds + 1)]
            good = [one for one in runs if one.upright and one.on_course]
            share = wilson(len(good), seeds)
            out.add_row(
                TASKS[name].title, known, f"{len(good)} of {seeds}", f"{share.low:.2f} to {share.high:.2f}",
                str(sum(one.lawful for one in good)),
                *(
                    f"{value:.3g}" if good else "-"
                    for value in (
                        np.median([one.speed for one in good] or [0.0]), max([o.slip for o in good] or [0.0]),
                        np.median([o.pitch_rate for o in good] or [0.0]),
                        np.median([o.heave for o in good] or [0.0]),
                    )
                ),
            )  # fmt: skip
    return out


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="one seed on ice and on the slope")
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--task", choices=sorted(TASKS), action="append")
    parser.add_argument("--knowledge", choices=KNOWLEDGE, action="append")
    parser.add_argument("--actuators", choices=("ideal", "real"), default="ideal")
    parser.add_argument("--truth", action="store_true", help="the controller is told the true state")
    parser.add_argument("--json", action="store_true", help="print the tables as JSON")
    given = parser.parse_args(arguments)
    tasks = given.task or (["ice", "slope"] if given.quick else list(TASKS))
    knowledge = given.knowledge or (["exact"] if given.quick else list(KNOWLEDGE))
    seeds = 1 if given.quick else given.seeds
    found = table(tasks, knowledge, seeds, given.actuators, given.truth)
    show([found], given.json, Console(width=150))


if __name__ == "__main__":
    main()
