"""Motions over given schedules: centroidal ones, and what they save the search of the whole body.

Run: python -m benchmarks.scheduled_motions [--quick] [jump] [jump-up] [backflip]

Prints, for each motion of Go2, Ipopt's iterations and CPU time for the centroidal motion, and for the whole
body from its reference and from the centroidal motion. `--quick` leaves the whole body out.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from surefoot.planning.schedule import ScheduleProblem, optimise
from surefoot.planning.schedule.centroidal import CentroidalProblem, optimise_centroidal
from surefoot.planning.schedule.centroidal_start import centroidal_problem, whole_body_start
from surefoot.planning.schedule.motions import backflip, jump
from surefoot.robot import Robot, load_robot

MU, MORE = 0.6, 0.03
"""Friction, and what `surefoot plan` plans beyond what is asked for [m]."""
LEGS = np.array([0.3, 0.1, 0.2])
"""Box about the places below the hips that a foot of Go2 reaches in a flip [m]."""
LATE = 0.8
"""Share of the time on the rear feet after which the reference of the flip begins to turn."""
MOST = 300
"""Iterations of a search."""


class Row(NamedTuple):
    """One search: motion, what was searched, from where, whether found, iterations, CPU time [s], cost."""

    motion: str
    search: str
    start: str
    found: bool
    iterations: int
    seconds: float
    cost: float


def _as_it_is(problem: ScheduleProblem) -> CentroidalProblem:
    return centroidal_problem(problem)


def _turning_late(problem: ScheduleProblem) -> CentroidalProblem:
    """Return a flip's centroidal problem whose reference turns as the feet are about to leave the ground."""
    asked = centroidal_problem(problem, reach=LEGS)
    down, some = asked.stance.all(axis=1), asked.stance.any(axis=1)
    push, air = np.flatnonzero(~down)[0], np.flatnonzero(~some)
    begin = push + LATE * (air[0] - push)
    share = np.clip((np.arange(asked.knots + 1) - begin) / (air[-1] + 1 - begin), 0.0, 1.0)
    reference = asked.reference.copy()
    reference[:, 3:] = 0.0
    reference[:, 4], reference[:, 6] = np.sin(-np.pi * share), np.cos(np.pi * share)
    return replace(asked, reference=reference)


Made = tuple[Callable[[Robot], ScheduleProblem], Callable[[ScheduleProblem], CentroidalProblem]]
MOTIONS: dict[str, Made] = {
    "jump": (lambda robot: jump(robot, 0.4 + MORE, 0.0, MU), _as_it_is),
    "jump-up": (lambda robot: jump(robot, 0.0, 0.2 + MORE, MU), _as_it_is),
    "backflip": (lambda robot: backflip(robot, MU), _turning_late),
}


def rows(name: str, quick: bool) -> list[Row]:
    """Return the searches of a motion; `quick` leaves out the whole body's."""
    make, reduce = MOTIONS[name]
    problem = make(load_robot("go2"))
    begin = time.process_time()
    motion = optimise_centroidal(reduce(problem), MOST)
    spent = time.process_time() - begin
    out = [Row(name, "centroidal", "reference", motion.found, motion.iterations, spent, motion.cost)]
    for start in () if quick else ("reference", "centroidal"):
        begin = time.process_time()
        variables = whole_body_start(problem, motion) if start == "centroidal" else None
        found = optimise(problem, variables, MOST)
        spent = time.process_time() - begin
        out.append(Row(name, "whole body", start, found.found, found.iterations, spent, found.cost))
    return out


def main(arguments: list[str]) -> list[Row]:
    """Print the table of the motions named, all without names."""
    names = [a for a in arguments if a in MOTIONS] or list(MOTIONS)
    print("| motion | search | from | found | iterations | CPU s | cost |")
    print("| --- | --- | --- | --- | ---: | ---: | ---: |")
    table = []
    for name in names:
        for row in rows(name, "--quick" in arguments):
            found, spent = "yes" if row.found else "no", f"{row.seconds:.1f} | {row.cost:.4f}"
            line = f"| {row.motion} | {row.search} | {row.start} | {found} | {row.iterations} | {spent} |"
            print(line, flush=True)
            table.append(row)
    return table


if __name__ == "__main__":
    main(sys.argv[1:])
