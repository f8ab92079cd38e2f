"""Motions over given schedules: centroidal ones, and what they save the search of the whole body.

Run: python -m benchmarks.scheduled_motions [--quick] [--json] [jump] [jump-up] [backflip]

Prints, for each motion of Go2, Ipopt's iterations and CPU time for the centroidal motion, and for the whole
body from its reference and from the centroidal motion: until it stops, and until the motion keeps to all
constraints at a cost within `NEAR` of its last one, since the last digits may take as long again or more.
`--quick` leaves the whole body out, `--json` prints the rows as JSON.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from typing import NamedTuple

from surefoot.planning.schedule import ScheduleProblem, optimise
from surefoot.planning.schedule.centroidal import optimise_centroidal
from surefoot.planning.schedule.limbs import whole_body_guess
from surefoot.planning.schedule.motions import backflip, jump
from surefoot.planning.schedule.search import ACCEPTED
from surefoot.robot import Robot, load_robot

MU, MORE = 0.6, 0.03
"""Friction, and what `surefoot plan` plans beyond what is asked for [m]."""
MOST = 200
"""Iterations of a search."""
NEAR = 1e-3
"""Share of the last cost within which a motion is as good as done."""


class Row(NamedTuple):
    """One search: what, from where, whether found, iterations until near and in all, CPU time [s], cost."""

    motion: str
    search: str
    start: str
    found: bool
    near: int
    iterations: int
    seconds: float
    cost: float


class _Heard:
    """Keeps the costs and violations of a search's iterations."""

    def __init__(self) -> None:
        self.seen: list[tuple[float, float]] = []

    def __call__(self, number: int, cost: float, violation: float) -> None:
        self.seen.append((cost, violation))

    def near(self) -> int:
        """Return after how many iterations the motion stays as good as done."""
        last = self.seen[-1][0]
        good = [abs(cost - last) <= NEAR * last and off <= ACCEPTED for cost, off in self.seen]
        return max((k + 1 for k, fine in enumerate(good) if not fine), default=0)


MOTIONS: dict[str, Callable[[Robot], ScheduleProblem]] = {
    "jump": lambda robot: jump(robot, 0.4 + MORE, 0.0, MU),
    "jump-up": lambda robot: jump(robot, 0.0, 0.2 + MORE, MU),
    "backflip": lambda robot: backflip(robot, MU),
}


def rows(name: str, quick: bool) -> list[Row]:
    """Return the searches of a motion; `quick` leaves out the whole body's."""
    problem = MOTIONS[name](load_robot("go2"))
    begin = time.process_time()
    heard = _Heard()
    motion = optimise_centroidal(problem, MOST, heard)
    spent = time.process_time() - begin
    said = motion.found, heard.near(), motion.iterate.iterations, spent, motion.iterate.cost
    out = [Row(name, "centroidal", "reference", *said)]
    for start in () if quick else ("reference", "centroidal"):
        begin = time.process_time()
        guess = whole_body_guess(problem, motion) if start == "centroidal" else None
        heard = _Heard()
        found = optimise(problem, guess, MOST, heard)
        spent = time.process_time() - begin
        said = found.found, heard.near(), found.iterate.iterations, spent, found.iterate.cost
        out.append(Row(name, "whole body", start, *said))
    return out


def main(arguments: list[str]) -> list[Row]:
    """Print the table of the motions named, all without names."""
    names = [a for a in arguments if a in MOTIONS] or list(MOTIONS)
    if "--json" in arguments:
        table = [row for motion in names for row in rows(motion, "--quick" in arguments)]
        print(json.dumps([row._asdict() for row in table]))
        return table
    print("| motion | search | from | found | iterations until near | in all | CPU s | cost |")
    print("| --- | --- | --- | --- | ---: | ---: | ---: | ---: |")
    table = []
    for motion in names:
        for row in rows(motion, "--quick" in arguments):
            found, spent = "yes" if row.found else "no", f"{row.seconds:.1f} | {row.cost:.4f}"
            name, counts = f"{row.motion} | {row.search} | {row.start}", f"{row.near} | {row.iterations}"
            print(f"| {name} | {found} | {counts} | {spent} |", flush=True)
            table.append(row)
    return table


if __name__ == "__main__":
    main(sys.argv[1:])
