"""What questions to a sole cost, and rows for a QP, beside Clarabel in the same run."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.soles.judges import ClarabelSole, random_wrenches
from benchmarks.timing import least_time, one_core
from surefoot.base.arrays import FloatArray
from surefoot.contact.cones import Sole
from surefoot.contact.cones.sole_kernels import hold
from surefoot.mechanics.stance import PointContact, Stance

REPEATS = 5
"""Runs of which the fastest counts: the rest is other work on the machine."""


@dataclass(frozen=True)
class Cost:
    """Processor time of one call, or of one wrench of a batch.

    Attributes
    ----------
    question, who
        What was asked, and of whom.
    seconds
        Processor time [s].
    ratio
        Over that of the question's first line [-].
    """

    question: str
    who: str
    seconds: float
    ratio: float


def races(count: int, seed: int) -> list[Cost]:
    """Time all questions on `count` wrenches of a sole of 22 x 9 cm, on one core."""
    rng = np.random.default_rng(seed)
    sole = Sole(0.22, 0.09, 0.6)
    judge = ClarabelSole(sole.corners, sole.mu)
    few = min(count, 2000)
    near = random_wrenches(rng, judge, sole.mu, 3 * few)[::3]
    mixed = random_wrenches(rng, judge, sole.mu, few)
    many = np.tile(random_wrenches(rng, judge, sole.mu, min(count, 10_000)), (-(-count // 10_000), 1))[:count]
    out = np.empty(len(many), dtype=np.int8)
    given = sole._data

    def batch(wrenches: FloatArray, ask: Callable[[FloatArray], Any]) -> float:
        ask(wrenches[:10])
        return least_time(lambda: ask(wrenches), REPEATS, time.process_time) / len(wrenches)

    def single(wrenches: FloatArray, ask: Callable[[FloatArray], Any]) -> float:
        return batch(wrenches, lambda all_of_them: [ask(w) for w in all_of_them])

    with one_core():
        found = [
            (
                "is it in? a third near the border",
                "surefoot, one wrench a call",
                single(mixed, sole.contains),
            ),
            ("", "surefoot, compiled, a batch", batch(many, lambda w: hold(*given, w, 1e-9, out[: len(w)]))),
            ("", "Clarabel on the corner forces", single(mixed[:500], judge.least)),
            ("is it in? all near the border", "surefoot, one wrench a call", single(near, sole.contains)),
            ("", "surefoot, compiled, a batch", batch(near, lambda w: hold(*given, w, 1e-9, out[: len(w)]))),
            ("", "Clarabel on the corner forces", single(near[:500], judge.least)),
            ("margin and shares", "surefoot, a batch", batch(mixed, sole.use)),
            ("least friction", "surefoot, a batch", batch(mixed, sole.friction_needed)),
            ("nearest wrench", "surefoot, a batch", batch(mixed, sole.project)),
            *_rows(),
        ]
    costs: list[Cost] = []
    first = 1.0
    for question, who, seconds in found:
        first = seconds if question else first
        costs.append(Cost(question, who, seconds, seconds / first))
    return costs


def _rows() -> list[tuple[str, str, float]]:
    """Time the rows of four feet whose frames turn."""
    feet = [[0.2, 0.15, 0], [0.2, -0.15, 0], [-0.2, 0.15, 0], [-0.2, -0.15, 0]]
    stances = [
        Stance([PointContact(p, [np.sin(a), 0.0, np.cos(a)], 0.6, normal_max=300.0) for p in feet])
        for a in np.linspace(0.0, 0.5, 200)
    ]
    rows = stances[0].halfspaces(8, axes="world")
    both = stances[0].two_sided(8, axes="world").sparse()

    def each(call: Callable[[Stance], Any]) -> float:
        for s in stances:
            call(s)
        return least_time(lambda: [call(s) for s in stances], REPEATS, time.process_time) / len(stances)

    kept = stances[0].two_sided(8, axes="world")
    return [
        (
            "rows of four feet, frames turned",
            "update of a dense matrix",
            each(lambda s: rows.update(rows.A, s)),
        ),
        ("", "update of a sparse one, both bounds", each(lambda s: kept.update(both, s))),
        ("", "the rows anew", each(lambda s: s.halfspaces(8, axes="world"))),
    ]
