"""Clean runs of several robots in several worlds, to be audited as they are and with faults in them.

Each is a second or so of a robot that stands, is pushed, or walks, on flat ground, slopes and stairs, in the
rigid world and in MuJoCo; the seed moves its start. No law is broken in any of them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from surefoot.mechanics.robot import Robot, load_robot, place
from surefoot.mechanics.terrain.terrain_names import read_terrain
from surefoot.motion.control.controller import Controller
from surefoot.motion.standing.standing_controller import StandingController
from surefoot.motion.standing.standing_plan import StandingPlan
from surefoot.motion.walking.walking_body import VelocityCommand
from surefoot.motion.walking.walking_controller import WalkingController, WalkSettings
from surefoot.records.log import Log
from surefoot.worlds.interface.world_names import make_world
from surefoot.worlds.running.run import Push, Scenario, run
from surefoot.worlds.running.scenario import STANDING_FALL, START_DEPTH


@dataclass(frozen=True)
class CleanRun:
    """What is simulated.

    Attributes
    ----------
    robot, world, terrain
        Names, see `load_robot`, `make_world` and `surefoot.mechanics.terrain.terrain_names`.
    gait
        Of a walk; empty to stand.
    velocity
        Commanded: forward, left [m/s], yaw rate [rad/s].
    push
        Force on the base, world axes [N per kg of the robot], for 0.1 s in the middle of the run.
    mu
        Friction of the ground.
    duration
        [s].
    seed
        Of the start.
    """

    robot: str = "go2"
    world: str = "mujoco"
    terrain: str = "flat"
    gait: str = ""
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    push: tuple[float, float, float] = (0.0, 0.0, 0.0)
    mu: float = 0.6
    duration: float = 1.0
    seed: int = 0

    @property
    def name(self) -> str:
        """Short and unique."""
        what = self.gait or "stand"
        pushed = "-pushed" if any(self.push) else ""
        speed = "".join(f"{x:+g}" for x in self.velocity) if self.gait else ""
        ground = self.terrain.replace(":", "").replace(",", "x")
        return f"{self.robot}-{self.world}-{what}{speed}{pushed}-{ground}-{self.mu:g}-{self.seed}"

    def make(self) -> Log:
        """Simulate it."""
        robot, terrain = _robot(self.robot), read_terrain(self.terrain)
        controller: Controller
        standing: dict[str, Any] = {}
        if self.gait:
            command = VelocityCommand.constant(*self.velocity)
            controller = WalkingController(robot, command, self.gait, terrain, WalkSettings(mu=self.mu))
        else:
            q = place(robot, terrain)
            controller = StandingController(robot, StandingPlan(robot, terrain, q, ()), terrain, q, self.mu)
            standing = {"start": q, "depth": START_DEPTH, "fall": STANDING_FALL}
        force = tuple(float(x) * robot.mass for x in self.push)
        pushes = (Push(0.5 * self.duration, force, 0.1),) if any(self.push) else ()  # type: ignore[arg-type]
        scenario = Scenario(self.duration, self.mu, pushes, seed=self.seed, **standing)
        return run(make_world(self.world, robot, terrain, self.mu), controller, scenario)


@cache
def _robot(name: str) -> Robot:
    return load_robot(name)


def clean_runs(count: int = 100, worlds: Sequence[str] = ("mujoco", "rigid")) -> list[CleanRun]:
    """Return `count` clean runs, the most different first; each has a seed of its own.

    Parameters
    ----------
    count
        Runs.
    worlds
        Names of `make_world`.
    """
    kinds = list(_kinds(worlds))
    return [_seeded(kinds[k % len(kinds)], k // len(kinds), k) for k in range(count)]


def _kinds(worlds: Sequence[str]) -> Iterator[CleanRun]:
    """Yield what runs are of, before seeds."""
    trot, turn = (0.4, 0.0, 0.0), (0.2, 0.1, 0.5)
    for world in worlds:
        yield CleanRun("go2", world, gait="trot", velocity=trot, duration=1.5)
        yield CleanRun("go2", world)
        yield CleanRun("go2", world, push=(1.5, 0.8, 0.0))
        yield CleanRun("go2", world, "slope:15", mu=0.8)
        yield CleanRun("go2", world, "slope:10", "trot", (0.3, 0.0, 0.0), duration=1.5)
        yield CleanRun("go2", world, "stairs:0.06,0.3", "trot", (0.4, 0.0, 0.0), duration=2.5)
        yield CleanRun("go2", world, gait="walk", velocity=turn, duration=1.5)
        yield CleanRun("a1", world, gait="trot", velocity=turn, duration=1.5)
        yield CleanRun("anymal", world, push=(-1.0, 0.5, 0.0))
        yield CleanRun("go2", world, gait="trot", velocity=trot, push=(0.0, 3.0, 0.0), duration=1.5)


def _seeded(kind: CleanRun, turn: int, seed: int) -> CleanRun:
    """Return a kind with a seed and, from the second turn on, other numbers."""
    rng = np.random.default_rng([seed, 15])
    scale = 1.0 if turn == 0 else float(rng.uniform(0.6, 1.2))
    velocity = tuple(round(scale * x, 3) for x in kind.velocity)
    push = tuple(round(scale * x, 3) for x in kind.push)
    return replace(kind, velocity=velocity, push=push, seed=seed)  # type: ignore[arg-type]
