"""Ten minutes of random commands, pushes and rough ground, minute by minute: docs/reports/walking.md.

Run: python -m benchmarks.long_walk [--quick] [--json]. Go2 with real motors and estimated state, all of its
links may touch. Every 8 s comes another command, up to 0.8 and 0.3 m/s and 0.8 rad/s, for 4 s and then back,
for the ground ends; every 10 s a push of 100 N for 0.1 s from anywhere. The ground is rough by 4 cm.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.printing import options, show, table
from benchmarks.walks import HARD, Walk
from surefoot.motion.walking.walking_body import VelocityCommand
from surefoot.records.audit import summarise_walk
from surefoot.worlds.running.observers import Moment, Observer
from surefoot.worlds.running.scenario import Push
from surefoot.worlds.running.sensors import SensorModel


class Memory(Observer):
    """Notes every minute what memory the process has, without the log's pages on the disk [MB]."""

    def __init__(self) -> None:
        self.seen: list[float] = []

    def step(self, moment: Moment) -> None:
        """See `Observer`."""
        if moment.time > 60.0 * (len(self.seen) + 1) - 0.01:
            self.seen.append(0.004096 * int(Path("/proc/self/statm").read_text().split()[5]))


def main() -> None:
    """Walk, and print a row for each minute."""
    given, memory, random = options(__doc__, "one minute").parse_args(), Memory(), np.random.default_rng(0)
    minutes = 1 if given.quick else 10
    forth = random.uniform(-1.0, 1.0, (75, 1, 3)) * [0.8, 0.3, 0.8]
    commands = VelocityCommand(np.arange(0.0, 600.0, 4.0), np.hstack([forth, -forth]).reshape(-1, 3))
    ways = enumerate(random.uniform(0.0, 2.0 * np.pi, 6 * minutes - 1), 1)
    pushes = tuple(Push(10.0 * k, (100.0 * np.cos(a), 100.0 * np.sin(a), 0.0), 0.1) for k, a in ways)
    walk = Walk("go2", terrain="rough:1,0.04", options=HARD, sensors=SensorModel(), pushes=pushes)
    log = replace(walk, commands=commands).log(0, 60.0 * minutes, memory)
    times = 1e6 * log["controller_time"][: 60_000 * len(memory.seen)].reshape(-1, 60_000)
    rows = np.column_stack([np.percentile(times, (50, 99, 99.9, 100), axis=1).T, memory.seen])
    title = f"{log.fact('outcome')}: {len(log['time'])} steps; {summarise_walk(log).laws_broken or 'lawful'}"
    columns = ("step, median [us]", "99 %", "99.9 %", "longest", "memory [MB]")
    show([table(columns, [[f"{number:.0f}" for number in row] for row in rows], title)], given.json)


if __name__ == "__main__":
    main()
