"""Loads and pulls that a walking robot was not told of: with the wrench observer, and without.

Run: python -m benchmarks.loads [--quick] [--seeds N] [--only TEXT]
[--part payloads|robots|disturbances|cost] [--json]. Trots in MuJoCo at 0.5 m/s. In the ideal world the
state is the true one, motors are ideal and feet alone touch; in the hard one the state is estimated from
ordinary sensors, motors are real and every link may touch.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from rich.console import Console
from rich.table import Table

from benchmarks import walks
from benchmarks.printing import options, show
from benchmarks.printing import table as table_of
from benchmarks.timing import Stopwatch
from surefoot.base.arrays import FloatArray
from surefoot.base.spatial import rotation_from_quaternion
from surefoot.mechanics.robot import Robot
from surefoot.mechanics.terrain import Terrain, read_terrain
from surefoot.motion.control.controller import Controller
from surefoot.motion.walking.walking_controller import WalkingController, WalkSettings
from surefoot.records.audit import WalkSummary, summarise_walk
from surefoot.worlds.mujoco.mujoco_world import MujocoWorld
from surefoot.worlds.running.faults import Faults
from surefoot.worlds.running.run import run
from surefoot.worlds.running.scenario import Ice, Push, Scenario
from surefoot.worlds.running.sensors import SensorModel

LATE = 2.0
"""Time from which the lean of a robot that has settled is told [s]."""
GO2_MASS, GO2_HEIGHT = 16.085, 0.32
"""What other robots' payloads are scaled by [kg], [m]."""
Place = tuple[float, float, float]


@dataclass(frozen=True)
class Walk(walks.Walk):
    """A trot with something that the controller does not know."""

    observed: bool = True

    def controller(self, robot: Robot, terrain: Terrain) -> Controller:
        """Return the walking controller, with the observer or without."""
        settings = WalkSettings(actuators=self.motors(robot), watch_load=self.observed)
        return WalkingController(robot, self.command, terrain=terrain, settings=settings)


def loaded(robot: str, mass: float, place: Place, hard: bool) -> Walk:
    """Return a trot with an unknown point mass [kg] at a place [m], in the hard world or the ideal one."""
    options = {**(walks.HARD if hard else {}), "payload": mass, "payload_position": place}
    return Walk(robot, options=options, sensors=SensorModel() if hard else None)


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
    normals = read_terrain(walk.terrain).normal(log["q"][:, :2])
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
            yield f"{'hard' if hard else 'ideal'}: {at}", loaded("go2", mass, place, hard)


def robots(quick: bool) -> Iterator[tuple[str, Walk]]:
    """Return other robots with Go2's 5 kg at (.1, .08, .08) m, as shares of their masses and heights."""
    for name in ("a1",) if quick else ("anymal_c", "anymal", "a1", "go1", "b1", "solo12", "hyq", "laikago"):
        robot = walks.known_robot(name)
        height = float(robot.com(robot.nominal)[2] - robot.foot_positions(robot.nominal)[:, 2].mean())
        x, y, z = (height / GO2_HEIGHT * part for part in (0.1, 0.08, 0.08))
        mass = 5.0 / GO2_MASS * robot.mass
        title = f"{name}, {mass:.1f} kg at ({x:.2f}, {y:.2f}, {z:.2f})"
        yield title, loaded(name, mass, (x, y, z), not quick)


def disturbances(quick: bool) -> Iterator[tuple[str, Walk]]:
    """Return what else pushes, pulls and misleads; without a payload where none is named."""
    plain = loaded("go2", 0.0, (0.0, 0.0, 0.0), not quick)
    angles = (0,) if quick else range(0, 360, 45)
    for angle in angles:
        turned = math.radians(angle)
        force = 150.0 * math.cos(turned), 150.0 * math.sin(turned), 0.0
        yield f"150 N for 0.1 s at {angle} deg", replace(plain, pushes=(Push(2.5, force, 0.1),))
    if quick:
        return
    yield "150 N down for 0.1 s", replace(plain, pushes=(Push(2.5, (0.0, 0.0, -150.0), 0.1),))
    for side, pull in (("to the left", (0.0, 30.0, 0.0)), ("back", (-30.0, 0.0, 0.0))):
        yield f"a pull of 30 N {side} from 1 s on", replace(plain, pushes=(Push(1.0, pull, 99.0),))
    yield "ice, mu 0.2 from 2 s on", replace(plain, ice=(Ice(2.0, 0.2),))
    yield "commands 5 ms late", replace(plain, faults=Faults(delay=0.005))
    heavy = loaded("go2", 5.0, (0.1, 0.08, 0.08), not quick)
    yield "5 kg, slope of 15 deg", replace(heavy, terrain="slope:15")
    yield "5 kg, ice", replace(heavy, ice=(Ice(2.0, 0.2),))
    yield "5 kg, 150 N to the left", replace(heavy, pushes=(Push(2.5, (0.0, 150.0, 0.0), 0.1),))


PARTS = {"payloads": payloads, "robots": robots, "disturbances": disturbances}


def table(part: str, quick: bool, only: str, seeds: int, duration: float) -> Table:
    """Return what a part comes to, without and with the observer."""
    names = (
        "walk", "observer", "walked", "lawful", "lean [deg]", f"after {LATE:g} s", "velocity off [m/s]",
        "slip [mm]", "found [kg]", "at [m]",
    )  # fmt: skip
    rows = []
    for title, walk in PARTS[part](quick):
        if only not in title:
            continue
        for observed in (False, True):
            r = Row.of(replace(walk, observed=observed), seeds, duration)
            at = "" if np.isnan(r.place).any() else f"({r.place[0]:.3f}, {r.place[1]:.3f})"
            rows.append((
                title, "on" if observed else "off", f"{r.walked}/{r.seeds}", f"{r.lawful}/{r.seeds}",
                f"{r.lean:.2f}", f"{r.lean_late:.2f}", f"{r.missed:.3f}", f"{1e3 * r.slip:.1f}",
                f"{r.mass:.2f}" if observed else "", at,
            ))  # fmt: skip
    return table_of(names, rows, f"{part}: {seeds} seeds of {duration:g} s each, worst of them", left=2)


def cost(quick: bool) -> Table:
    """Return the processor time of a controller's step in a trot, without and with the observer."""
    robot, duration, spent = walks.known_robot("go2"), 0.5 if quick else 4.0, []
    for observed in (False, True):
        walk = Walk(observed=observed)
        watch = Stopwatch(walk.controller(robot, read_terrain(walk.terrain)))
        run(MujocoWorld(robot, payload=2.0), watch, Scenario(duration, walk.mu, seed=0))
        spent.append(watch.cpu)
    rows = [
        (title, *(f"{1e6 * float(how(times)):.1f}" for times in spent))
        for title, how in (("median", np.median), ("mean", np.mean))
    ]
    return table_of(("", "observer off", "on"), rows, "processor time of a controller's step [us]")


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the tables."""
    parser = options(__doc__, "a walk or two of a second", seeds=3, duration=5.0)
    parser.add_argument("--part", choices=(*PARTS, "cost"), action="append")
    given = parser.parse_args(arguments)
    seeds, duration = (1, 1.0) if given.quick else (given.seeds, given.duration)
    tables = (
        cost(given.quick) if part == "cost" else table(part, given.quick, given.only, seeds, duration)
        for part in given.part or (*PARTS, "cost")
    )
    show(tables, given.json, Console(width=150))


if __name__ == "__main__":
    main()
