"""Go2's trot with real motors: what speeds ask of them, and what late commands do.

Run: python -m benchmarks.actuators [--quick] [--seeds N] [--part speeds|delays|robots] [--json]. MuJoCo, all
links may touch, the state is estimated from ordinary sensors.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from rich.table import Table

from benchmarks.printing import show
from surefoot.audit import WalkSummary, summarise_walk
from surefoot.cli.command_options import Wiring
from surefoot.control.actuators import actuators_of
from surefoot.control.walking import WalkingController, WalkSettings
from surefoot.control.walking_body import VelocityCommand
from surefoot.robot import load_robot
from surefoot.simulation.faults import Faults
from surefoot.simulation.run import Scenario, run
from surefoot.simulation.sensors import SensorModel
from surefoot.simulation.walk_terrain import start_pose
from surefoot.simulation.worlds import make_world
from surefoot.spatial import GRAVITY
from surefoot.terrain import FlatTerrain

TORQUES, TARGETS = Wiring(latency=0.0), Wiring(targets=True, latency=0.0)
WIRINGS = {
    "torques": TORQUES,
    "torques, delay made up for": replace(TORQUES, latency=None),
    "targets": TARGETS,
    "targets, delay made up for": replace(TARGETS, latency=None),
    "targets, controller at 250 Hz": Wiring(targets=True, every=4),
}
ROBOTS = ("anymal_c", "a1", "go1", "b1", "solo12", "hyq", "laikago")


@dataclass(frozen=True)
class Walk:
    """A trot on level ground; delays in seconds."""

    robot: str = "go2"
    speed: float = 0.5
    actuators: str = "real"
    wired: Wiring = TORQUES
    delay: float = 0.0

    def summary(self, seed: int, duration: float) -> WalkSummary:
        """Return what the walk with a seed came to."""
        robot, ground = load_robot(self.robot), FlatTerrain()
        command = VelocityCommand.constant(self.speed, 0.0, 0.0)
        settings = WalkSettings(actuators=actuators_of(robot, self.actuators))
        walking = WalkingController(robot, command, "trot", ground, settings, self.wired.dt)
        scenario = Scenario(
            duration, settings.mu, seed=seed, start=start_pose(robot, ground), sensors=SensorModel(),
            faults=Faults(delay=self.delay),
        )  # fmt: skip
        world = make_world("mujoco", robot, ground, settings.mu, actuators=self.actuators, collision="full")
        return summarise_walk(run(world, self.wired.around(walking, robot), scenario))


COLUMNS = (
    "walked", "laws and limits kept", "velocity [m/s]", "slip [mm]", "fastest joint [%]",
    "beyond its speed [%]", "torque cut off [%]", "links touched",
)  # fmt: skip


def row(walk: Walk, seeds: int, duration: float) -> Iterator[str]:
    """Yield the figures of a walk, the worst of its seeds."""
    found = [walk.summary(seed, duration) for seed in range(seeds)]
    motors = [s.motors for s in found if s.motors is not None]
    velocities = [s.velocity.forward.measured for s in found]
    yield f"{sum(s.success for s in found)} of {seeds}"
    yield f"{sum(s.good for s in found)} of {seeds}"
    yield f"{min(velocities):.3f} to {max(velocities):.3f}"
    yield f"{1e3 * max(foot.slip for s in found for foot in s.feet):.2f}"
    yield f"{100 * max(m.speed_use_max for m in motors):.0f}"
    yield f"{100 * max(m.over_speed_share for m in motors):.2g}"
    yield f"{100 * max(m.beyond_curve_share for m in motors):.2g}"
    touched = [any(line.startswith("touched") for line in s.limits_broken or []) for s in found]
    yield f"{sum(touched)} of {seeds}"


def table(title: str, walks: dict[str, Walk], seeds: int, duration: float) -> Table:
    """Return one row for every walk."""
    out = Table(title=f"{title}; {duration:g} s, worst of {seeds} seeds")
    for column in ("walk", *COLUMNS):
        out.add_column(column, justify="left" if column == "walk" else "right")
    for name, walk in walks.items():
        out.add_row(name, *row(walk, seeds, duration))
    return out


def speeds() -> dict[str, Walk]:
    """Return trots at rising speeds, with ideal and real motors."""
    return {
        f"{speed:g} m/s, {actuators}, {'targets' if wired.targets else 'torques'}": Walk(
            speed=speed, actuators=actuators, wired=wired
        )
        for speed in (0.5, 1.0, 1.5, 2.0)
        for actuators, wired in (("ideal", TORQUES), ("real", TORQUES), ("real", TARGETS))
    }


def delays() -> dict[str, Walk]:
    """Return trots at 0.5 m/s whose commands come late."""
    return {
        f"{1e3 * delay:g} ms, {name}": Walk(wired=wired, delay=delay)
        for delay in (0.005, 0.01)
        for name, wired in WIRINGS.items()
    }


def robots() -> dict[str, Walk]:
    """Return trots of other robots at 0.5 sqrt(g h)."""
    out = {}
    for name in ROBOTS:
        robot = load_robot(name)
        speed = 0.5 * math.sqrt(GRAVITY * float(robot.nominal[2]))
        for label, wired in (("torques", TORQUES), ("targets", TARGETS)):
            out[f"{name}, {speed:.2f} m/s, {label}"] = Walk(robot=name, speed=round(speed, 2), wired=wired)
    return out


PARTS = {"speeds": speeds, "delays": delays, "robots": robots}


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="one short run")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--duration", type=float, default=6.0)
    parser.add_argument("--only", default="", help="walks whose names hold this")
    parser.add_argument("--part", choices=tuple(PARTS), action="append")
    parser.add_argument("--json", action="store_true", help="print the tables as JSON")
    given = parser.parse_args(arguments)
    if given.quick:
        quick = table("quick", {"0.5 m/s, real, targets": Walk(wired=TARGETS)}, 1, 1.0)
        show([quick], given.json)
        return
    chosen = {
        part: {name: walk for name, walk in PARTS[part]().items() if given.only in name}
        for part in given.part or PARTS
    }
    show((table(part, walks, given.seeds, given.duration) for part, walks in chosen.items()), given.json)


if __name__ == "__main__":
    main()
