"""Rows of many environments for the tests: windows of simulated runs, lawful or spoilt by seeded hands."""

from __future__ import annotations

from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray
from tests.records.audit.logs import PUSHED, TROT, log_of

CHANNELS = ("forces", "gaps", "contact_velocities")
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


def spoil(arrays: dict[str, FloatArray], environment: int, rng: np.random.Generator) -> str:
    """Spoil an environment's rows in place, in one of ten ways; return which."""
    f, gaps, v = (arrays[name][:, environment] for name in CHANNELS)
    rows, foot = slice(int(rng.integers(20, 100)), int(rng.integers(120, ROWS - 5))), int(rng.integers(4))
    kinds = {
        "pull": lambda: f[rows, foot].__setitem__((slice(None), 2), -0.05 * f[..., 2].max()),
        "friction": lambda: f[rows].__setitem__((..., slice(0, 2)), 4.0 * f[rows][..., :2] + 1.0),
        "penetration": lambda: gaps.__setitem__((rows, foot), gaps[rows, foot] - 0.02),
        "distance": lambda: gaps.__setitem__(rows, gaps[rows] + 0.03),
        "skate": lambda: v[rows].__setitem__((..., 0), 0.3),
        "drive": lambda: v[rows].__setitem__((..., slice(0, 2)), 0.01 * f[rows][..., :2]),
        "frames": lambda: f[rows].__setitem__((..., [0, 2]), f[rows][..., [2, 0]]),
        "spike": lambda: f[rows.start].__setitem__((foot, 2), 50.0 * f[..., 2].max()),
        "back": lambda: v[rows].__setitem__((..., 2), np.abs(v[rows][..., 2]) + 0.2),
        "nothing": lambda: None,
        "lost": lambda: f[rows, foot].__setitem__(slice(None), np.nan),
        "huge": lambda: f[rows.start].__setitem__(foot, 1e200),
    }
    kind = str(rng.choice([*kinds]))
    kinds[kind]()
    return kind
