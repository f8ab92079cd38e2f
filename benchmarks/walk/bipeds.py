"""Humanoids that walk, judged by the audit, and how many of the seeds do: `python -m benchmarks.walk.bipeds`.

In the hard world the state is estimated from noisy sensors, motors have rotors, friction and a torque-speed
curve, and all links may touch; in the ideal one there is none of that. A walk counts if the robot went on to
the end and followed the command; it is lawful if the audit finds nothing either. Pushes come at a moment of
the gait that depends on the seed, 0.1 s each.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import nullcontext
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from rich.console import Console

from benchmarks.printing import table
from benchmarks.walks import HARD, Walk
from surefoot.audit import audit_log, summarise_walk
from surefoot.simulation.scenario import Push
from surefoot.simulation.sensors import SensorModel

PUSHED, CYCLE, PUSH_TIME = 3.0, 0.8, 0.1
"""A push comes from this time on, within a cycle of the gait, and lasts so long [s]."""


WALKS = {
    "in place": Walk(velocity=(0.0, 0.0, 0.0)),
    "0.3 m/s": Walk(velocity=(0.3, 0.0, 0.0)),
    "0.6 m/s": Walk(velocity=(0.6, 0.0, 0.0)),
    "0.3 m/s, turning 0.5 rad/s": Walk(velocity=(0.3, 0.0, 0.5)),
    "0.3 m/s, 10 degrees up": Walk(velocity=(0.3, 0.0, 0.0), terrain="slope:10"),
    "0.3 m/s, 10 degrees down": Walk(velocity=(0.3, 0.0, 0.0), terrain="slope:-10"),
    "0.3 m/s, 3 cm rough": Walk(velocity=(0.3, 0.0, 0.0), terrain="rough"),
}
PUSHES = {"forward": (60.0, 0.0), "back": (-60.0, 0.0), "left": (0.0, 60.0), "right": (0.0, -60.0)}
"""On the base: forward, left [N]."""
WALKS |= {
    f"0.3 m/s, 60 N {side}": Walk(velocity=(0.3, 0.0, 0.0), pushes=(Push(PUSHED, (*push, 0.0), PUSH_TIME),))
    for side, push in PUSHES.items()
}


class Outcome(NamedTuple):
    """What a walk came to: its end, whether it counts, is lawful, velocities, tilt [deg], slip [m]."""

    ending: str
    walked: bool
    lawful: bool
    forward: float
    turn: float
    tilt: float
    slip: float


def walk(name: str, what: Walk, hard: bool, seed: int, duration: float) -> Outcome:
    """Return what a walk of a robot came to."""
    moment = PUSHED + CYCLE * float(np.random.default_rng(seed).random())
    chosen = replace(
        what, robot=name, pushes=tuple(replace(push, start=moment) for push in what.pushes),
        terrain=f"rough:{seed},0.03" if what.terrain == "rough" else what.terrain,
        options=HARD if hard else {}, sensors=SensorModel() if hard else None,
    )  # fmt: skip
    log = chosen.log(seed, duration)
    found = summarise_walk(log)
    speed = found.velocity
    return Outcome(
        found.outcome, found.success, audit_log(log).lawful, speed.forward.measured, speed.turn.measured,
        found.tilt_max_deg, max(foot.slip for foot in found.feet),
    )  # fmt: skip


def _cells(found: list[Outcome]) -> Iterator[str]:
    """Yield the cells of a row: the worst of all seeds."""
    count = len(found)
    yield f"{sum(one.walked for one in found)} of {count}"
    yield f"{sum(one.lawful and one.walked for one in found)} of {count}"
    good = [one for one in found if one.walked] or found
    yield f"{min(o.forward for o in good):.3f} to {max(o.forward for o in good):.3f}"
    yield f"{min(o.turn for o in good):.3f} to {max(o.turn for o in good):.3f}"
    yield f"{max(o.tilt for o in good):.1f}"
    yield f"{1e3 * max(o.slip for o in good):.2f}"


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("robots", nargs="*", default=["g1"])
    parser.add_argument("--ideal", action="store_true", help="in the ideal world")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--duration", type=float, default=10.0)
    parser.add_argument("--only", default="", help="walks whose names hold this")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--quick", action="store_true", help="one short walk")
    given = parser.parse_args(arguments)
    walks = {name: what for name, what in WALKS.items() if given.only in name}
    seeds, duration = given.seeds, given.duration
    if given.quick:
        walks, seeds, duration = {"0.3 m/s": WALKS["0.3 m/s"]}, 1, 3.0
    columns = ("walked", "and lawful", "forward [m/s]", "turn [rad/s]", "tilt [deg]", "slip [mm]")
    world = "ideal" if given.ideal else "hard"
    pool: Executor | nullcontext[None] = nullcontext() if given.jobs == 1 else ProcessPoolExecutor(given.jobs)
    with pool as workers:
        for robot in given.robots:
            rows = []
            for name, what in walks.items():
                each = [(robot, what, not given.ideal, seed, duration) for seed in range(1, seeds + 1)]
                found = list((map if workers is None else workers.map)(walk, *zip(*each, strict=True)))
                rows.append((name, *_cells(found)))
                ends = [f"seed {k}: {one.ending}" for k, one in enumerate(found, 1) if not one.walked]
                print(name, *_cells(found), *ends, sep=" | ", flush=True)
            title = f"{robot} in the {world} world, {duration:g} s, {seeds} seeds"
            Console(width=140).print(table(("walk", *columns), rows, title))


if __name__ == "__main__":
    main()
