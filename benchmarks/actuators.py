"""Go2's trot with real motors: what speeds ask of them, and what late commands do.

Run: python -m benchmarks.actuators [--quick] [--seeds N] [--part speeds|delays|robots] [--json]. MuJoCo, all
links may touch, the state is estimated from ordinary sensors.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from rich.table import Table

from benchmarks import walks
from benchmarks.printing import options, show
from benchmarks.printing import table as table_of
from surefoot.app.cli.walk_options import Wiring
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics.robot import Robot
from surefoot.mechanics.terrain import Terrain
from surefoot.motion.control.controller import Controller
from surefoot.motion.walking.walkers import walking_controller
from surefoot.worlds.running.faults import Faults
from surefoot.worlds.running.sensors import SensorModel

TORQUES, TARGETS = Wiring(latency=0.0), Wiring(targets=True, latency=0.0)
WIRINGS = {
    "torques": TORQUES,
    "torques, delay made up for": replace(TORQUES, latency=None),
    "targets": TARGETS,
    "targets, delay made up for": replace(TARGETS, latency=None),
    "targets, controller at 250 Hz": Wiring(targets=True, every=4),
}


@dataclass(frozen=True)
class Walk(walks.Walk):
    """A trot on level ground whose commands reach the motors in some way."""

    options: Mapping[str, Any] = field(default_factory=lambda: walks.HARD)
    sensors: SensorModel | None = field(default_factory=SensorModel)
    wired: Wiring = TORQUES

    def controller(self, robot: Robot, terrain: Terrain) -> Controller:
        """Return the walking controller and what is around it."""
        walking = walking_controller(
            robot, self.command, self.gait, terrain, self.mu, self.motors(robot), self.wired.dt
        )
        return self.wired.around(walking, robot)


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


def table(title: str, chosen: dict[str, Walk], seeds: int, duration: float) -> Table:
    """Return one row for every walk."""
    rows = [(name, *row(walk, seeds, duration)) for name, walk in chosen.items()]
    return table_of(("walk", *COLUMNS), rows, f"{title}; {duration:g} s, worst of {seeds} seeds")


def speeds() -> dict[str, Walk]:
    """Return trots at rising speeds, with ideal and real motors."""
    return {
        f"{speed:g} m/s, {actuators}, {'targets' if wired.targets else 'torques'}": Walk(
            velocity=(speed, 0.0, 0.0), options={**walks.HARD, "actuators": actuators}, wired=wired
        )
        for speed in (0.5, 1.0, 1.5, 2.0)
        for actuators, wired in (("ideal", TORQUES), ("real", TORQUES), ("real", TARGETS))
    }


def delays() -> dict[str, Walk]:
    """Return trots at 0.5 m/s whose commands come late."""
    return {
        f"{1e3 * delay:g} ms, {name}": Walk(wired=wired, faults=Faults(delay=delay))
        for delay in (0.005, 0.01)
        for name, wired in WIRINGS.items()
    }


def robots() -> dict[str, Walk]:
    """Return trots of other robots at 0.5 sqrt(g h)."""
    out = {}
    for name in walks.QUADRUPEDS:
        speed = 0.5 * math.sqrt(GRAVITY * float(walks.known_robot(name).nominal[2]))
        for label, wired in (("torques", TORQUES), ("targets", TARGETS)):
            velocity = round(speed, 2), 0.0, 0.0
            out[f"{name}, {speed:.2f} m/s, {label}"] = Walk(name, velocity, wired=wired)
    return out


PARTS = {"speeds": speeds, "delays": delays, "robots": robots}


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the tables."""
    parser = options(__doc__, "one short run", seeds=3, duration=6.0)
    parser.add_argument("--part", choices=tuple(PARTS), action="append")
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
