"""How often the intervals of `surefoot identify LOG.npz` hold the truth: a table of docs/identify-walk.md.

Run: python -m benchmarks.identify_walks [--json]. A draw is a trot of 5 s of Go2 in MuJoCo with
hidden friction, rotors, losses in the joints, latency and payload, seen by ordinary sensors.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from rich.table import Table

from benchmarks.printing import options, show, table
from benchmarks.walks import Walk, known_robot
from surefoot.mechanics.robot.actuators import real_actuators
from surefoot.records.identification.walked_robot import identify_robot
from surefoot.records.log import Log
from surefoot.worlds.running.faults import Faults
from surefoot.worlds.running.sensors import SensorModel

DURATION, DRAWS = 5.0, 12
"""Of a walk [s], and how many."""
FIRST = 100
"""Seed of the first walk: what intervals are made of was chosen on others."""


def hidden_walk(seed: int, duration: float = DURATION) -> tuple[Log, dict[str, float]]:
    """Return the log of a walk, and what is to be found in it."""
    random, motors = np.random.default_rng(seed), real_actuators(known_robot("go2"))
    ranges = {
        "mu": (0.3, 0.9),
        "armature": (0.5, 2.0),
        "joint_damping": (0.3, 2.0),
        "joint_friction": (0.3, 2.5),
    }
    truth = {name: float(random.uniform(*ends)) for name, ends in ranges.items()}
    truth |= {"delay": 1e-3 * int(random.integers(0, 7)), "payload": float(random.uniform(0.0, 4.0))}
    own = replace(
        motors, armature=truth["armature"] * motors.armature, damping=truth["joint_damping"] * motors.damping,
        friction=truth["joint_friction"] * motors.friction,
    )  # fmt: skip
    walk = UntoldWalk(
        velocity=(0.5, 0.0, 0.3), mu=truth["mu"], believed_mu=0.6, sensors=SensorModel(),
        faults=Faults(delay=truth["delay"]), options={"actuators": own, "payload": truth["payload"]},
    )  # fmt: skip
    return walk.log(seed, duration), truth


class UntoldWalk(Walk):
    """A walk whose controller knows of no motors."""

    def motors(self, robot: Any) -> None:
        """Return none."""


def coverage(draws: int) -> Table:
    """Return the table: how many intervals hold the truth, their half-width, and the error's size."""
    rows: dict[str, list[tuple[float, float, float]]] = {}
    for seed in range(FIRST, FIRST + draws):
        log, truth = hidden_walk(seed)
        for name, e in identify_robot(known_robot("go2"), log).parameters.items():
            gaps = (e.value - truth[name], e.low - truth[name], e.high - truth[name])
            rows.setdefault(name, []).append(gaps)
    found = []
    for name, values in rows.items():
        error, low, high = np.array(values).T
        held = int(np.count_nonzero((low <= 0.0) & (high >= 0.0)))
        size = f"{np.sqrt(np.mean(error**2)):.2g}"
        found.append((name, f"{held} of {len(values)}", f"{np.median(high - low) / 2.0:.2g}", size))
    columns = ("parameter", "hold the truth", "half-width (median)", "error (rms)")
    return table(columns, found, f"{draws} walks: 95 % intervals")


def main(arguments: Sequence[str] | None = None) -> None:
    """Walk, identify and print the table."""
    parser = options(__doc__, "two walks")
    given = parser.parse_args(arguments)
    show([coverage(2 if given.quick else DRAWS)], given.json)


if __name__ == "__main__":
    main()
