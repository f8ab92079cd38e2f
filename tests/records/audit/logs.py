"""Clean runs for the tests of the audit, each simulated once per session."""

from __future__ import annotations

from functools import cache

import numpy as np

from benchmarks.problems.logged_runs import CleanRun
from surefoot.base.spatial import GRAVITY
from surefoot.records.audit import LawFigures, log_laws
from surefoot.records.log import Log

TROT = CleanRun(gait="trot", velocity=(0.4, 0.0, 0.0), duration=1.2)
STAND = CleanRun(world="rigid", duration=0.6, seed=1)
PUSHED = CleanRun(push=(1.5, 0.8, 0.0), duration=0.8, seed=2)
SLOPE = CleanRun(
    world="rigid", terrain="slope:10", gait="trot", velocity=(0.3, 0.0, 0.0), duration=1.2, seed=3
)
RUNS = (TROT, STAND, PUSHED, SLOPE)


@cache
def log_of(run: CleanRun) -> Log:
    """Return the log of a run; write to none."""
    return run.make()


def changed(
    log: Log, facts: dict[str, object] | None = None, keep: tuple[str, ...] = (), **arrays: object
) -> Log:
    """Return a log with some arrays and facts replaced, and only the channels of `keep` if any are given."""
    everything = {name: np.array(array) for name, array in log.arrays.items()} | arrays
    chosen = {k: a for k, a in everything.items() if not keep or k in (*keep, "time")}
    return Log(chosen, {**log.facts, **(facts or {})}, channels=log.channels)


def check_laws(
    forces: object, gaps: object, velocities: object, mu: object, weight: float, dt: float = 1e-3
) -> LawFigures:
    """Return the laws of a motion as numbers; friction is one number, one per time or one per contact."""
    f, friction = np.asarray(forces, dtype=np.float64), np.asarray(mu, dtype=np.float64)
    own = np.broadcast_to(friction[:, None] if friction.ndim == 1 else friction, f.shape[:2])
    arrays = {"forces": f, "gaps": gaps, "contact_velocities": velocities, "contact_friction": own}
    return log_laws(Log({"time": dt * np.arange(len(f)), **arrays}, {"mass": weight / GRAVITY, "dt": dt}))
