"""How soon and how well friction is told while a robot goes: docs/reports/estimation.md.

Run: python -m benchmarks.slippery_walks [--quick] [--json]. The tracker of friction sees walks onto
ground that is more slippery than the controller was told.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from rich.table import Table

from benchmarks.printing import options, show, table
from benchmarks.walks import Walk
from surefoot.base.arrays import FloatArray
from surefoot.base.spatial import GRAVITY
from surefoot.records.identification.friction_tracker import FrictionTracker
from surefoot.records.log import Log
from surefoot.worlds.running.run import Push

BELIEVED, PUSH = 0.6, (30.0, 40.0, 0.0)
"""Friction that the controller counts on, and the force of its push on slippery ground [N]."""


def slippery_walk(world: str, mu: float) -> Log:
    """Return the log of a Go2 that trots at 0.6 m/s, and is pushed, on less friction than it was told."""
    push = Push(0.8, PUSH, 0.2)
    walk = Walk(velocity=(0.6, 0.0, 0.0), mu=mu, believed_mu=BELIEVED, world=world, pushes=(push,))
    return walk.log(0, 2.0)


def friction_answers(world: str, mu: float) -> tuple[float, FloatArray, float]:
    """Return the time from first slip to first answer [s], all answers, and the highest lower bound."""
    log, random = slippery_walk(world, mu), np.random.default_rng(0)
    least, dt = 0.05 * log.fact("mass") * GRAVITY, log.fact("dt")
    tracker = FrictionTracker(log["forces"].shape[1], dt, least=least)
    known = []
    for forces, velocities in zip(log["forces"], log["contact_velocities"], strict=True):
        known.append(tracker.update(forces * (1.0 + 0.1 * random.normal(size=forces.shape)), velocities))
    high = np.array([k.high for k in known])
    bounded, slid = np.isfinite(high), np.array([k.sliding for k in known])
    walking = slice(round(0.1 / dt), None)  # the first rows are the robot's landing
    wait = int(np.argmax(bounded[walking].any(axis=1))) - int(np.argmax(slid[walking].any(axis=1)))
    return wait * dt, high[bounded], max(float(k.low.max()) for k in known)


def friction_table(cases: Sequence[tuple[str, float]]) -> Table:
    """Return how soon and how well a slide tells friction."""
    rows = []
    for world, mu in cases:
        wait, answers, low = friction_answers(world, mu)
        ends = f"{answers.min():.3f} to {answers.max():.3f}"
        rows.append((world, f"{mu:g}", f"{1e3 * wait:.0f}", ends, f"{low:.3f}"))
    columns = ("world", "true mu", "ms to answer", "answers (all feet, all times)", "highest low")
    return table(columns, rows, f"friction while it goes, believed {BELIEVED}, forces with 10 % noise")


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the table."""
    given = options(__doc__, "one walk").parse_args(arguments)
    cases = [(world, mu) for world in ("rigid", "mujoco") for mu in (0.15, 0.25)]
    show([friction_table(cases[1:2] if given.quick else cases)], given.json)


if __name__ == "__main__":
    main()
