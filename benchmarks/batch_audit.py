"""Many environments audited at once, beside one audit after another: CPU time, and whether both say the same.

Run: surefoot bench audit --batch [--quick]. Rows of walks and pushed stands of a Go2 in MuJoCo, masses from
0.2 to 5 of its own, every second environment spoilt in one of ten ways; the single audit judges a share of
them.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import numpy as np

import surefoot as sf
from benchmarks.problems.logged_runs import CleanRun
from surefoot.base.arrays import FloatArray

CHANNELS = ("forces", "gaps", "contact_velocities")
DT = 0.002
ROWS = 1000
"""Rows of an environment."""
RUNS = (
    CleanRun(gait="trot", velocity=(0.4, 0.0, 0.0), duration=2.2),
    CleanRun(gait="trot", velocity=(0.2, 0.1, 0.3), duration=2.2, seed=4),
    CleanRun(push=(1.5, 0.8, 0.0), duration=2.2, seed=2),
)
SPOILS = (
    "pull", "friction", "penetration", "distance", "skate", "drive", "frames", "back", "spike", "lost",
)  # fmt: skip
SOFT = ("sinking", "creep", "stopping", "settling")
"""Facts of the world that all share."""


@dataclass(frozen=True)
class BatchPrice:
    """What auditing many environments costs.

    Attributes
    ----------
    environments, rows
        How many, and rows of each.
    seconds, cpu
        Of the whole batch [s]: by the clock on all cores, and of all threads together.
    alone
        CPU of one audit after another, for as many environments [s].
    compared, differ
        Environments judged both ways, and those whose verdict or broken laws differ.
    step
        A call of `sf.StepLaws` for all environments, costs alone and with rows kept [µs of CPU].
    step_kept
    """

    environments: int
    rows: int
    seconds: float
    cpu: float
    alone: float
    compared: int
    differ: int
    step: float
    step_kept: float


def measure(quick: bool) -> BatchPrice:
    """Measure 4,096 environments of 1,000 rows; with `quick` 64 of 250, 8 of them alone too."""
    count, rows, compared = (64, 250, 8) if quick else (4096, ROWS, 200)
    arrays, mass, mu, facts = environments(count, rows)
    few = {name: array[:50, :4] for name, array in arrays.items()}
    sf.audit_batch(few, DT, mu[:4], mass=mass[:4], facts=facts)  # kernels
    wall, cpu = time.perf_counter(), time.process_time()
    report = sf.audit_batch(arrays, DT, mu, mass=mass, facts=facts)
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    chosen = np.linspace(0, count - 1, compared).astype(int).tolist()
    alone, differ = time.process_time(), 0
    for k in chosen:
        one = report.audit(k)
        mine = {name for name, law in report.laws.items() if law.law and law.share[k] > 0.0}
        # numbers that are not finite are the log's own fault, and no law's
        differ += one.verdict != report.verdicts[k] or {*one.laws_broken} - {"finite"} != mine
    alone = (time.process_time() - alone) * count / compared
    steps = [_step_price(arrays, mass, mu, facts, kept) for kept in (0, 20)]
    return BatchPrice(count, rows, wall, cpu, alone, compared, differ, steps[0], steps[1])


def environments(
    count: int, rows: int
) -> tuple[dict[str, FloatArray], FloatArray, FloatArray, dict[str, Any]]:
    """Return arrays (rows, count, ...), masses and friction (count,), and the facts that all share."""
    rng, logs = np.random.default_rng(61), [run.make() for run in RUNS]
    arrays = {name: np.empty((rows, count, *logs[0][name].shape[1:]), np.float32) for name in CHANNELS}
    mass, mu = np.empty(count), np.empty(count)
    for k in range(count):
        log = logs[k % len(logs)]
        first, scale = int(rng.integers(len(log) - rows)), float(rng.uniform(0.2, 5.0))
        part = {name: np.array(log[name][first : first + rows]) for name in CHANNELS}
        part["forces"] *= scale
        if k % 2:
            spoil(part, SPOILS[k // 2 % len(SPOILS)], rng)
        for name in CHANNELS:
            arrays[name][:, k] = part[name]
        mass[k], mu[k] = scale * float(log.fact("mass")), float(np.asarray(log["mu"])[0])
    return arrays, mass, mu, {name: logs[0].facts[name] for name in SOFT}


def spoil(part: dict[str, FloatArray], kind: str, rng: np.random.Generator) -> None:
    """Break a law in some rows of an environment, arrays (T, ...), in place: a way of `SPOILS`."""
    f, gaps, v = (part[name] for name in CHANNELS)
    a, foot = int(rng.integers(10, len(f) // 2)), int(rng.integers(f.shape[1]))
    at = slice(a, a + int(rng.integers(len(f) // 8, len(f) // 3)))
    top = float(f[..., 2].max())
    match kind:
        case "pull":
            f[at, foot, 2] = -0.05 * top
        case "friction":
            f[at, :, :2] *= 8.0
        case "penetration":
            gaps[at, foot] -= 0.02
        case "distance":
            gaps[at] += 0.03
        case "skate":
            v[at, :, 0] = 0.3
        case "drive":
            v[at, :, :2] = 0.3 * f[at, :, :2] / top
        case "frames":
            f[at] = f[at][..., [2, 1, 0]]
        case "back":
            v[at, :, 2] = np.abs(v[at, :, 2]) + 0.2
        case "spike":
            f[a, foot, 2] = 50.0 * top
        case "lost":
            f[at, foot] = np.nan


def _step_price(
    arrays: dict[str, FloatArray], mass: FloatArray, mu: FloatArray, facts: dict[str, Any], kept: int
) -> float:
    """Return the CPU of a step of `sf.StepLaws` [µs]: 40 steps, judged every `kept`; 0 for costs alone."""
    laws = sf.StepLaws(arrays["forces"].shape[2], mu, mass, DT, facts=facts, rows=kept)
    steps = min(40, len(arrays["forces"]))
    start = time.process_time()
    for t in range(steps):
        laws(*(arrays[name][t] for name in CHANNELS))
    return 1e6 * (time.process_time() - start) / steps
