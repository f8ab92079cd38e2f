"""Whether everybody says the same of a sole's wrenches as Clarabel on the forces of its corners."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from decimal import Decimal
from typing import Any

import numpy as np

from benchmarks.soles.judges import ClarabelSole, least_in_digits, random_sole, random_wrenches
from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.contact.cones import Sole
from surefoot.mechanics.stance import SoleContact, Stance
from surefoot.mechanics.statics.statics import can_stand
from surefoot.mechanics.statics.wrench_cone import StanceCone

NEAR = 1e-7
"""Distance from the border, over the wrench's size, below which Clarabel is not asked but 50 digits."""
EVERY = 20
"""Of so many wrenches one goes to the questions that are asked one wrench at a time."""


@dataclass
class Agreement:
    """How one question about soles compares with the judges, over all soles.

    Attributes
    ----------
    question
        Who was asked.
    wrenches, inside
        How many, and how many of them Clarabel holds.
    differ
        Answers that are not Clarabel's, farther than `NEAR` from the border.
    settled, differ_near
        Wrenches nearer than that, settled in 50 digits, and answers that are not those.
    worst
        Largest distance from the border of an answer that differs, over the wrench's size.
    """

    question: str
    wrenches: int = 0
    inside: int = 0
    differ: int = 0
    settled: int = 0
    differ_near: int = 0
    worst: float = 0.0

    def add(self, told: BoolArray, true: BoolArray, distance: FloatArray) -> None:
        """Count the answers for wrenches whose truth and distance from the border are known."""
        near, wrong = distance < NEAR, told != true
        self.wrenches += len(told)
        self.inside += int(true.sum())
        self.differ += int((wrong & ~near).sum())
        self.settled += int(near.sum())
        self.differ_near += int((wrong & near).sum())
        self.worst = max(self.worst, float(distance[wrong].max(initial=0.0)))


@dataclass(frozen=True)
class Judged:
    """A sole's wrenches and what is true of them.

    Attributes
    ----------
    sole, wrenches
        The sole and its wrenches (n, 6).
    least, size
        (n,) least normal force that each takes, and its own size with moments over the sole's radius [N].
    true, distance
        (n,) whether the sole holds it, and how far it is from the border, over its size [-].
    """

    sole: Sole
    wrenches: FloatArray
    least: FloatArray
    size: FloatArray
    true: BoolArray
    distance: FloatArray


def judged(seed: int, count: int) -> Judged:
    """Return one sole with wrenches, a third drawn near the border, the nearest settled in 50 digits."""
    rng = np.random.default_rng(seed)
    corners, mu = random_sole(rng, seed)
    judge = ClarabelSole(corners, mu)
    wrenches = random_wrenches(rng, judge, mu, count)
    least = np.array([judge.least(w) for w in wrenches])
    size = np.array([np.hypot(w[2], np.linalg.norm(judge.counted(w))) for w in wrenches])
    true, distance = wrenches[:, 2] >= least, np.abs(wrenches[:, 2] - least) / size
    for k in np.flatnonzero(distance < NEAR):
        low, high = least_in_digits(corners, mu, wrenches[k])
        force = Decimal(float(wrenches[k, 2]))
        true[k], least[k] = force >= high, float(low)
        distance[k] = float(min(abs(force - low), abs(force - high))) / size[k]
    return Judged(Sole.of_corners(corners, mu), wrenches, least, size, true, distance)


def _size(sole: Sole, w: FloatArray) -> float:
    """Return a wrench's size [N]: a cone holds w where it holds w / size, and tolerances are newtons."""
    arm = np.array([*sole.centre, 0.0])
    return float(np.hypot(np.linalg.norm(w[:3]), np.linalg.norm(w[3:] - np.cross(arm, w[:3])) / sole.radius))


def _can_stand(sole: Sole) -> Callable[[FloatArray], bool]:
    stance = Stance([SoleContact([0.0, 0.0, 0.0], sole)])
    return lambda w: bool(can_stand(stance, [0, 0, 0], 1e-300, -w))


def _one_by_one(sole: Sole) -> dict[str, Callable[[FloatArray], bool]]:
    cone = StanceCone(Stance([SoleContact([0.0, 0.0, 0.0], sole)]))
    return {
        "`Sole.verdict` of w / size, proof checked": lambda w: sole.verdict(w / _size(sole, w)).holds is True,
        "`can_stand`": _can_stand(sole),
        "`StanceCone.contains`": lambda w: bool(cone.contains(w, 0.0)),
    }


def agreement(soles: int, count: int, seed: int) -> dict[str, Any]:
    """Ask everybody about `count` wrenches of each of so many soles."""
    tallies: dict[str, Agreement] = {}
    pyramids = {fit: {"promised": 0, "held": 0, "wrongly": 0} for fit in ("inner", "outer")}
    error = 0.0
    for number in range(soles):
        case = judged(seed + number, count)
        told = {
            "`Sole.contains`": case.sole.contains(case.wrenches, 0.0),
            "`Sole.margin` >= 0": case.sole.margin(case.wrenches) >= 0.0,
            "`Sole.friction_needed` <= mu": case.sole.friction_needed(case.wrenches) <= case.sole.mu,
        }
        gap = np.abs(case.sole.margin(case.wrenches) - case.wrenches[:, 2] + case.least) / case.size
        error = max(error, float(gap.max()))
        for name, answer in told.items():
            tallies.setdefault(name, Agreement(name)).add(answer, case.true, case.distance)
        some = np.arange(0, count, EVERY)
        for name, ask in _one_by_one(case.sole).items():
            answer = np.array([ask(w) for w in case.wrenches[some]])
            tallies.setdefault(name, Agreement(name)).add(answer, case.true[some], case.distance[some])
        for fit in ("inner", "outer"):
            cone = case.sole.polyhedral(8, fit)
            holds, true = cone.contains(case.wrenches, 0.0), case.true
            pyramids[fit]["promised"] += int(holds.sum())
            pyramids[fit]["held"] += int(true.sum())
            wrongly = holds & ~true if fit == "inner" else true & ~holds
            pyramids[fit]["wrongly"] += int((wrongly & (case.distance > NEAR)).sum())
    return {"answers": [asdict(t) for t in tallies.values()], "pyramids": pyramids, "margin_error": error}
