"""Rows of many environments for the tests: windows of simulated runs, lawful or spoilt by seeded hands."""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks.batch_audit import CHANNELS, SPOILS, spoil
from surefoot.base.arrays import FloatArray
from tests.records.audit.logs import PUSHED, TROT, log_of

ROWS = 240
"""Rows of a window."""


def windows(
    count: int, seed: int, placed: bool = False
) -> tuple[dict[str, FloatArray], FloatArray, FloatArray]:
    """Return (T, N, ...) arrays, (N,) masses and (N,) friction of windows; forces scaled with the mass."""
    rng = np.random.default_rng(seed)
    names = (*CHANNELS, "contact_positions", "normals") if placed else CHANNELS
    parts: dict[str, list[FloatArray]] = {name: [] for name in names}
    masses, frictions = np.empty(count), np.empty(count)
    for k in range(count):
        log = log_of((TROT, PUSHED)[int(rng.integers(2))])
        first = int(rng.integers(len(log) - ROWS))
        scale = float(rng.uniform(0.2, 5.0))
        for name in names:
            part = np.array(log[name][first : first + ROWS])
            parts[name].append(part * scale if name == "forces" else part)
        masses[k], frictions[k] = scale * float(log.fact("mass")), float(np.asarray(log["mu"])[0])
    return {name: np.stack(several, axis=1) for name, several in parts.items()}, masses, frictions


def soft_facts() -> dict[str, Any]:
    """Return what the runs' world says of its softness."""
    log = log_of(TROT)
    return {
        name: log.facts[name] for name in ("sinking", "creep", "stopping", "settling") if name in log.facts
    }


def spoil_one(arrays: dict[str, FloatArray], environment: int, rng: np.random.Generator) -> str:
    """Spoil an environment's rows in place, or leave it, in one of twelve ways; return which."""
    kind = str(rng.choice([*SPOILS, "huge", "nothing"]))
    mine = {name: arrays[name][:, environment] for name in CHANNELS}
    spoil(mine, kind, rng)
    if kind == "huge":
        mine["forces"][int(rng.integers(ROWS)), 0] = 1e200
    return kind
