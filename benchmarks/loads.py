"""Loads and pulls that a walking robot was not told of: with the wrench observer, and without.

Run: python -m benchmarks.loads [--quick] [--seeds N] [--only TEXT]
[--part payloads|robots|disturbances|cost] [--json]. Trots in MuJoCo at 0.5 m/s. In the ideal world the
state is the true one, motors are ideal and feet alone touch; in the hard one the state is estimated from
ordinary sensors, motors are real and every link may touch.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from rich.console import Console
from rich.table import Table

from benchmarks.printing import show
from surefoot.arrays import FloatArray
from surefoot.audit import WalkSummary, summarise_walk
from surefoot.control.actuators import actuators_of
from surefoot.control.controller import Command, Controller, RobotState
from surefoot.control.load_adaptation import LoadSettings
from surefoot.control.walking import WalkingController, WalkSettings
from surefoot.control.walking_body import VelocityCommand
from surefoot.log import Log
from surefoot.robot import load_robot
from surefoot.simulation.faults import Faults
from surefoot.simulation.mujoco import MujocoWorld
from surefoot.simulation.run import run
from surefoot.simulation.scenario import Ice, Push, Scenario
from surefoot.simulation.sensors import SensorModel
from surefoot.simulation.walk_terrain import start_pose
from surefoot.spatial import rotation_from_quaternion
from surefoot.terrain import FlatTerrain, SlopeTerrain, Terrain

SPEED = 0.5
"""Commanded speed [m/s]."""
LATE = 2.0
"""Time from which the lean of a robot that has settled is told [s]."""
GO2_MASS, GO2_HEIGHT = 16.085, 0.32
"""What other robots' payloads are scaled by [kg], [m]."""
Place = tuple[float, float, float]


@dataclass(frozen=True)
class Walk:
    """A trot with something that the controller does not know."""

    robot: str = "go2"
    mass: float = 0.0
    place: Place = (0.0, 0.0, 0.0)
    hard: bool = False
    observed: bool = True
    pushes: tuple[Push, ...] = ()
    ice: tuple[Ice, ...] = ()
    faults: Faults = field(default_factory=Faults)
    terrain: Terrain = field(default_factory=FlatTerrain)

    def log(self, seed: int, duration: float) -> Log:
        """Return what happened with a seed."""
        robot, motors = load_robot(self.robot), "real" if self.hard else "ideal"
        settings = WalkSettings(
            actuators=actuators_of(robot, motors), load=LoadSettings() if self.observed else None
        )
        command = VelocityCommand.constant(SPEED)
        controller = WalkingController(robot, command, "trot", self.terrain, settings)
        world = MujocoWorld(
            robot, self.terrain, settings.mu, payload=self.mass, payload_position=self.place,
            collision="full" if self.hard else "feet", actuators=motors,
        )  # fmt: skip
        scenario = Scenario(
            duration, settings.mu, self.pushes, self.ice, seed, self.faults,
            start=start_pose(robot, self.terrain), sensors=SensorModel() if self.hard else None,
        )  # fmt: skip
        return run(world, controller, scenario)


@dataclass(frozen=True)
class Row:
    """What the seeds of a walk came to; the worst of them, but for what was found, which is their mean."""

    walked: int
    lawful: int
    seeds: int
    lean: float
    lean_late: float
    missed: float
    slip: float
    mass: float
    place: FloatArray

    @staticmethod
    def of(walk: Walk, seeds: int, duration: float) -> Row:
        """Measure a walk."""
        each = [_figures(walk, seed, duration) for seed in range(seeds)]
        summaries, leans = [s for s, _, _ in each], np.array([[a, b] for _, a, b in each])
        loads = [s.load for s in summaries if s.load is not None]
        places = [load.place for load in loads if load.place is not None]
        missed = [math.hypot(s.velocity.forward.error, s.velocity.left.error) for s in summaries]
        return Row(
            sum(s.success for s in summaries), sum(s.good for s in summaries), seeds,
            float(leans[:, 0].max()), float(leans[:, 1].max()), max(missed),
            max(foot.slip for s in summaries for foot in s.feet),
            float(np.mean([load.mass for load in loads])) if loads else math.nan,
            np.mean(places, axis=0) if places else np.full(3, math.nan),
        )  # fmt: skip


def _figures(walk: Walk, seed: int, duration: float) -> tuple[WalkSummary, float, float]:
    """Return the summary of a walk, its largest lean, and that after `LATE` [deg]."""
    log = walk.log(seed, duration)
    up = rotation_from_quaternion(log["q"][:, 3:7])[:, :, 2]
    normals = walk.terrain.normal(log["q"][:, :2])
    lean = np.degrees(np.arccos(np.clip((up * normals).sum(axis=1), -1.0, 1.0)))
    late = lean[log["time"] >= LATE]
    return summarise_walk(log), float(lean.max()), float(late.max()) if late.size else math.nan


def payloads(quick: bool) -> Iterator[tuple[str, Walk]]:
    """Return Go2's payloads in both worlds."""
    carried: list[tuple[float, Place]] = [(5.0, (0.1, 0.08, 0.08))]
    if not quick:
        carried = [(0.0, (0.0,) * 3), *carried, (5.0, (0.0, 0.08, 0.08)), (10.0, (0.1, 0.08, 0.08))]
    for hard in (False,) if quick else (False, True):
        for mass, place in carried:
            at = f"{mass:g} kg at {place}" if mass else "nothing"
            yield f"{'hard' if hard else 'ideal'}: {at}", Walk(mass=mass, place=place, hard=hard)


def robots(quick: bool) -> Iterator[tuple[str, Walk]]:
    """Return other robots with Go2's 5 kg at (.1, .08, .08) m, as shares of their masses and heights."""
    for name in ("a1",) if quick else ("anymal_c", "anymal", "a1", "go1", "b1", "solo12", "hyq", "laikago"):
        robot = load_robot(name)
        height = float(robot.com(robot.nominal)[2] - robot.foot_positions(robot.nominal)[:, 2].mean())
        x, y, z = (height / GO2_HEIGHT * part for part in (0.1, 0.08, 0.08))
        mass = 5.0 / GO2_MASS * robot.mass
        told = f"{name}, {mass:.1f} kg at ({x:.2f}, {y:.2f}, {z:.2f})"
        yield told, Walk(name, mass, (x, y, z), hard=not quick)


def disturbances(quick: bool) -> Iterator[tuple[str, Walk]]:
    """Return what else pushes, pulls and misleads; without a payload where none is named."""
    plain = Walk(hard=not quick)
    angles = (0,) if quick else range(0, 360, 45)
    for angle in angles:
        turned = math.radians(angle)
        force = 150.0 * math.cos(turned), 150.0 * math.sin(turned), 0.0
        yield f"150 N for 0.1 s at {angle} deg", replace(plain, pushes=(Push(2.5, force, 0.1),))
    if quick:
        return
    yield "150 N down for 0.1 s", replace(plain, pushes=(Push(2.5, (0.0, 0.0, -150.0), 0.1),))
    yield (
        "a pull of 30 N to the left from 1 s on",
        replace(plain, pushes=(Push(1.0, (0.0, 30.0, 0.0), 99.0),)),
    )
    yield "a pull of 30 N back from 1 s on", replace(plain, pushes=(Push(1.0, (-30.0, 0.0, 0.0), 99.0),))
    yield "ice, mu 0.2 from 2 s on", replace(plain, ice=(Ice(2.0, 0.2),))
    yield "commands 5 ms late", replace(plain, faults=Faults(delay=0.005))
    loaded = replace(plain, mass=5.0, place=(0.1, 0.08, 0.08))
    yield "5 kg, slope of 15 deg", replace(loaded, terrain=SlopeTerrain(15.0))
    yield "5 kg, ice", replace(loaded, ice=(Ice(2.0, 0.2),))
    yield "5 kg, 150 N to the left", replace(loaded, pushes=(Push(2.5, (0.0, 150.0, 0.0), 0.1),))


PARTS = {"payloads": payloads, "robots": robots, "disturbances": disturbances}


def table(part: str, quick: bool, only: str, seeds: int, duration: float) -> Table:
    """Return what a part comes to, without and with the observer."""
    shown = Table(title=f"{part}: {seeds} seeds of {duration:g} s each, worst of them")
    for name in (
        "walk", "observer", "walked", "lawful", "lean [deg]", f"after {LATE:g} s", "velocity off [m/s]",
        "slip [mm]", "found [kg]", "at [m]",
    ):  # fmt: skip
        shown.add_column(name, justify="left" if name in ("walk", "observer") else "right")
    for title, walk in PARTS[part](quick):
        if only not in title:
            continue
        for observed in (False, True):
            r = Row.of(replace(walk, observed=observed), seeds, duration)
            at = "" if np.isnan(r.place).any() else f"({r.place[0]:.3f}, {r.place[1]:.3f})"
            shown.add_row(
                title, "on" if observed else "off", f"{r.walked}/{r.seeds}", f"{r.lawful}/{r.seeds}",
                f"{r.lean:.2f}", f"{r.lean_late:.2f}", f"{r.missed:.3f}", f"{1e3 * r.slip:.1f}",
                f"{r.mass:.2f}" if observed else "", at,
            )  # fmt: skip
    return shown


class Stopwatch(Controller):
    """A controller whose steps are timed [s]."""

    def __init__(self, controller: Controller) -> None:
        self.controller, self.spent = controller, list[float]()
        self.channels, self.facts = controller.channels, controller.facts

    def warm_up(self, state: RobotState) -> None:
        """Compile or load all that a step calls."""
        self.controller.warm_up(state)

    def step(self, state: RobotState) -> Command:
        """Return the controller's command."""
        begin = time.process_time()
        command = self.controller.step(state)
        self.spent.append(time.process_time() - begin)
        return command


def cost(quick: bool) -> Table:
    """Return the processor time of a controller's step in a trot, without and with the observer."""
    robot, duration = load_robot("go2"), 0.5 if quick else 4.0
    medians, means = [], []
    for load in (None, LoadSettings()):
        settings = WalkSettings(load=load)
        watch = Stopwatch(WalkingController(robot, VelocityCommand.constant(SPEED), settings=settings))
        run(MujocoWorld(robot, payload=2.0), watch, Scenario(duration, settings.mu, seed=0))
        medians.append(1e6 * float(np.median(watch.spent)))
        means.append(1e6 * float(np.mean(watch.spent)))
    shown = Table("", "observer off", "on", title="processor time of a controller's step [us]")
    for title, times in (("median", medians), ("mean", means)):
        shown.add_row(title, *(f"{time:.1f}" for time in times))
    return shown


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="a walk or two of a second")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--duration", type=float, default=5.0)
    parser.add_argument("--only", default="", help="walks whose names hold this")
    parser.add_argument("--part", choices=(*PARTS, "cost"), action="append")
    parser.add_argument("--json", action="store_true", help="print the tables as JSON")
    given = parser.parse_args(arguments)
    seeds, duration = (1, 1.0) if given.quick else (given.seeds, given.duration)
    tables = (
        cost(given.quick) if part == "cost" else table(part, given.quick, given.only, seeds, duration)
        for part in given.part or (*PARTS, "cost")
    )
    show(tables, given.json, Console(width=150))


if __name__ == "__main__":
    main()
