"""Feet on ground of known friction: what an audit tells of it."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from benchmarks.limit_cases.made import Made
from benchmarks.limit_cases.verdict import Verdict, audited
from surefoot.records.audit import AuditReport
from surefoot.records.log import Log

NEAR = 0.07
"""Share within which friction should be told: coins of one kind on one table differ by as much."""
Part = tuple[float, float, float]
"""Duration [s], friction used, speed over the ground [m/s]."""


def friction_cases() -> Iterator[Verdict]:
    """Yield the cases of friction over time."""
    noise = "force cells of 2 %"
    one = ((1.0, 0.2, 0.0), (0.3, 0.6, 0.2), (0.7, 0.3, 0.0))
    yield _told("a slide of 0.3 s", noise, one, ((0.6, 0.6),))
    ice = ((1.0, 0.6, 0.2), (1.0, 0.2, 0.2))
    yield _told("from tiles to ice", noise, ice, ((0.6, 0.6), (0.2, 0.2)))
    rough = ((1.0, 0.2, 0.2), (1.0, 0.6, 0.0))
    yield _told("from ice to tiles", noise, rough, ((0.2, 0.2), (0.6, np.inf)))
    short = ((0.5, 0.6, 0.0), (0.006, 0.2, 0.3), (0.5, 0.6, 0.0))
    yield _told("a touchdown", "a regularised foot is stopped within 6 ms", short, ((0.6, np.inf),))
    brief = ((0.5, 0.6, 0.2), (0.007, 1.5, 0.0), (0.5, 0.6, 0.2))
    yield _told("a blow", "a foot that hits an edge for 7 ms", brief, ((0.6, 0.6),))
    rare = ((0.97, 0.1, 0.0), (0.03, 0.55, 0.0))
    yield _told("a brake", "a foot that brakes for 30 ms of a second", rare, ((0.55, np.inf),))
    spike = ((1.0, 0.5, 0.0), (0.001, 2.0, 0.0), (1.0, 0.5, 0.0))
    yield _told("a spike", "one row in two thousand with a bit flipped", spike, ((0.5, np.inf),), noise=0.0)
    slides = ((1.0, 0.6, 0.2), *((0.03, 0.2, 0.2), (0.05, 0.1, 0.0)) * 8)
    yield _told(
        "short slides on ice", "feet slide for 30 ms before they hold", slides, ((0.6, 0.6), (0.2, 0.2))
    )
    light = _made(((1.0, 0.4, 0.0),), 0.0)
    part = slice(300, 600)
    rng = np.random.default_rng(8)
    light.forces[part, 0, 2] = 5e-3 * light.weight
    light.forces[part, 0, 0] = -5e-3 * light.weight * rng.uniform(0.0, 2.0, 300)
    why = "a cell with an offset of half a percent of the weight: what it reads across is as large"
    right = partial(_right, ((0.4, np.inf),))
    yield audited("a foot in the air whose cell is off", why, light.log(), right)


def _told(
    name: str, why: str, parts: tuple[Part, ...], wanted: tuple[tuple[float, float], ...], noise: float = 0.02
) -> Verdict:
    return audited(name, why, _log(parts, noise), partial(_right, wanted))


def _right(wanted: tuple[tuple[float, float], ...], report: AuditReport) -> bool:
    """Return whether an audit tells so many intervals with these bounds, each to `NEAR`."""
    if len(report.friction) != len(wanted):
        return False
    for one, (low, high) in zip(report.friction, wanted, strict=True):
        if abs(one.low - low) > NEAR * low or not (one.high == high or abs(one.high - high) <= NEAR * high):
            return False
    return True


def _log(parts: tuple[Part, ...], noise: float) -> Log:
    return _made(parts, noise).log()


def _made(parts: tuple[Part, ...], noise: float) -> Made:
    """Return one foot that carries a quarter of its robot."""
    used = np.concatenate([np.full(round(1e3 * t), mu) for t, mu, _ in parts])
    speed = np.concatenate([np.full(round(1e3 * t), v) for t, _, v in parts])
    made = Made(len(used), mu=2.5, feet=1)
    made.forces[:, 0, 2] *= 0.25
    used = used * (1.0 + noise * np.random.default_rng(5).uniform(-1.0, 1.0, len(used)))
    made.forces[:, 0, 0] = -used * made.forces[:, 0, 2]
    made.velocities[:, 0, 0] = speed
    return made
