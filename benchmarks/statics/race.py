"""Statics against SciPy's HiGHS, Clarabel and cddlib: whether they agree, and how fast each is."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any

import numpy as np

from benchmarks.problems.stances import StanceCase, random_case
from benchmarks.statics import rivals
from benchmarks.timing import Timing, one_core, time_calls
from surefoot.base.spatial import GRAVITY
from surefoot.contact.cones import Sole
from surefoot.contact.cones.representation import convert
from surefoot.mechanics.stance import PointContact, SoleContact, Stance
from surefoot.mechanics.stance.stance_batch import StanceBatch
from surefoot.mechanics.statics.com_region import com_region
from surefoot.mechanics.statics.statics import can_stand
from surefoot.mechanics.statics.statics_batch import can_stand_batch, com_region_batch
from surefoot.mechanics.statics.wrench_cone import wrench_cone

MANY_FEET = (4, 16, 64, 256)
"""Contacts of the stances whose normal forces are bounded."""
CANDIDATES, TURNS = 1000, 5
"""Stances that are asked at once, and how often."""

BAND = 1e-7
"""Verdicts may differ where the margin is below this share of the load."""


@dataclass
class Agreement:
    """How often verdicts agree with an independent solver.

    Attributes
    ----------
    rival
        Who was asked, and with which cones.
    cases, possible
        How many questions, and how many of them have forces.
    agreed, in_band, disagreed
        Same verdict; different ones with the rival's margin within `BAND` of zero; different ones
        outside the band.
    verified
        How many of our verdicts proved themselves (`Verdict.verify`).
    worst_margin
        Largest difference between the margins, as a share of the load, where both are finite.
    """

    rival: str
    cases: int = 0
    possible: int = 0
    agreed: int = 0
    in_band: int = 0
    disagreed: int = 0
    verified: int = 0
    worst_margin: float = 0.0


def agreement(cases: Sequence[StanceCase], facets: int | None = None) -> Agreement:
    """Compare verdicts with Clarabel (exact cones) or HiGHS (pyramids of so many facets)."""
    result = Agreement("Clarabel, exact cones" if facets is None else f"HiGHS, {facets} facets")
    for case in cases:
        verdict = can_stand(case.stance, case.com, case.mass, case.external_wrench, facets)
        scale = float(np.linalg.norm(verdict.load))
        solve = rivals.clarabel_margin(case) if facets is None else rivals.highs_margin(case, facets)
        theirs = solve() / scale
        result.cases += 1
        result.possible += verdict.feasible
        result.verified += verdict.verify()
        if (not math.isnan(theirs) and theirs >= 0.0) == verdict.feasible:
            result.agreed += 1
        elif abs(theirs) <= BAND:
            result.in_band += 1
        else:
            result.disagreed += 1
        ours = verdict.margin / scale
        if abs(ours) < rivals.CAP and not math.isnan(theirs):
            result.worst_margin = max(result.worst_margin, abs(ours - theirs))
    return result


@dataclass(frozen=True)
class Race:
    """One question timed: who, how long, and how that compares with the first of the same question."""

    question: str
    who: str
    timing: Timing
    ratio: float


def races(count: int = 200, seed: int = 1) -> list[Race]:
    """Time every question on the same instances, one core, matrices of the rivals built beforehand."""
    rng = np.random.default_rng(seed)
    few = max(10, count // 10)
    feet = [_four_feet(rng) for _ in range(count)]
    wide = [case for case in feet if com_region(case.stance, case.mass).area > 1e-3][:few]
    soles = [_two_soles(rng) for _ in range(few)]
    flat = [random_case(rng, "flat", contacts=4) for _ in range(few)]
    possible = sum(can_stand(c.stance, c.com, c.mass).feasible for c in feet)
    out: list[Race] = []
    with one_core():
        out += _race(f"can it stand, 4 points ({possible} of {count} can)", _stand_racers(feet))
        out += _race("can it stand, 4 points: what is new in each call", _novelty_racers(feet))
        for contacts in MANY_FEET:
            question = f"can it stand, {contacts} points, normal forces bounded"
            out += _race(question, [("surefoot, exact cones", _ask, _bounded(rng, contacts))])
        out += _race("CoM region to 1 mm, 4 points", _region_racers(wide))
        out += _batch_races(wide)
        out += _race("CoM region to 1 mm, 2 patches", _region_racers(soles))
        out += _race("wrench cone, 4 points on rough ground, 8 facets", _cone_racers(wide))
        out += _race("wrench cone, 4 points on flat ground, 8 facets", _cone_racers(flat))
    return out


_Racers = list[tuple[str, Callable[[Any], Any], list[Any]]]


def _race(question: str, racers: _Racers) -> list[Race]:
    times = [(who, time_calls(call, items, warm_up=len(items))) for who, call, items in racers]
    first = times[0][1].median
    return [Race(question, who, timing, timing.median / first) for who, timing in times]


def _stand_racers(cases: list[StanceCase]) -> _Racers:
    return [
        ("surefoot, exact cones, a stance asked before", _ask, cases),
        (
            "surefoot, 8 facets",
            lambda c: can_stand(c.stance, c.com, c.mass, c.external_wrench, facets=8),
            cases,
        ),
        ("Clarabel, exact cones", _call, [rivals.clarabel_margin(c) for c in cases]),
        ("SciPy HiGHS, 8 facets", _call, [rivals.highs_feasible(c) for c in cases]),
    ]


def _call(solve: Callable[[], Any]) -> Any:
    return solve()


def _ask(case: StanceCase) -> Any:
    return can_stand(case.stance, case.com, case.mass, case.external_wrench)


def _novelty_racers(cases: list[StanceCase]) -> _Racers:
    """Return the question to the same stance again, to a new one of old contacts, and with all built anew."""

    def fresh(case: StanceCase) -> Any:
        return can_stand(Stance(case.stance.contacts), case.com, case.mass, case.external_wrench)

    def built(data: tuple[StanceCase, list[tuple[Any, Any, float]]]) -> Any:
        case, feet = data
        stance = Stance([PointContact(position, normal, mu) for position, normal, mu in feet])
        return can_stand(stance, case.com, case.mass, case.external_wrench)

    data = [(case, [(c.position, c.normal, c.mu) for c in case.stance]) for case in cases]
    return [
        ("surefoot, a stance asked before", _ask, cases),
        ("surefoot, a fresh stance of the same contacts", fresh, cases),
        ("surefoot, contacts and stance built too", built, data),
    ]


def _bounded(rng: np.random.Generator, contacts: int) -> list[StanceCase]:
    """Return stances of many points, each with bounds, that could carry three times the weight."""
    mass, out = 20.0, []
    for _ in range(3):
        most = 3.0 * mass * GRAVITY / contacts
        feet = [
            PointContact([*place, 0.0], mu=0.6, normal_min=0.01 * most, normal_max=most)
            for place in rng.uniform(-0.5, 0.5, (contacts, 2))
        ]
        com = np.array([*rng.uniform(-0.05, 0.05, 2), 0.4])
        out.append(StanceCase(Stance(feet), com, mass, np.zeros(6), "bounded"))
    return out


def _batch_races(cases: list[StanceCase]) -> list[Race]:
    """Return both questions to `CANDIDATES` stances at once: times of one of them."""
    chosen = [cases[k % len(cases)] for k in range(CANDIDATES)]
    places = np.array([c.stance.positions for c in chosen])
    normals = np.array([c.stance.rotations[:, :, 2] for c in chosen])
    mu = np.array([c.stance.mu for c in chosen])
    com, mass = np.array([c.com for c in chosen]), np.array([c.mass for c in chosen])

    def stand(_: int) -> Any:
        return can_stand_batch(StanceBatch(places, normals, mu), com, mass)

    def regions(_: int) -> Any:
        return com_region_batch(StanceBatch(places, normals, mu), mass, tol=1e-3)

    out = []
    for question, call in (("can they stand", stand), ("CoM regions to 1 mm", regions)):
        t = time_calls(call, range(TURNS), warm_up=1)
        each = Timing(t.median / CANDIDATES, t.p99 / CANDIDATES, t.worst / CANDIDATES, t.calls)
        out.append(Race(f"{question}, 4 points, {CANDIDATES} stances at once", "surefoot, each", each, 1.0))
    return out


def _region_racers(cases: list[StanceCase]) -> _Racers:
    return [
        ("surefoot, exact cones, certified gap", lambda c: com_region(c.stance, c.mass, tol=1e-3), cases),
        ("SciPy HiGHS, 32 LPs of 8 facets", _call, [rivals.highs_region(c.stance, c.mass) for c in cases]),
    ]


def _cone_racers(cases: list[StanceCase]) -> _Racers:
    rays = [wrench_cone(c.stance, c.com, facets=8).rays for c in cases]
    cddlib: _Racers = []
    if find_spec("cdd") is not None:  # its wheel is missing for many Pythons
        cddlib = [("cddlib, rays to half-spaces", _call, [rivals.cddlib_rows(r) for r in rays])]
    return [
        ("surefoot, rays to half-spaces, SciPy's Qhull", lambda r: convert(r)[0], rays),
        *cddlib,
        ("surefoot, the whole cone from a stance", lambda c: wrench_cone(c.stance, c.com, facets=8), cases),
    ]


def _four_feet(rng: np.random.Generator) -> StanceCase:
    """Return a quadruped's stance on rough ground, its weight somewhere about the middle."""
    case = random_case(rng, "tilted", contacts=4)
    feet = []
    for contact, (x, y) in zip(
        case.stance, ((0.2, 0.15), (0.2, -0.15), (-0.2, 0.15), (-0.2, -0.15)), strict=True
    ):
        place = np.array([x, y, 0.0]) + rng.normal(size=3) * [0.03, 0.03, 0.05]
        feet.append(PointContact(place, contact.normal, max(0.3, contact.mu)))
    com = np.array([*rng.normal(size=2) * [0.12, 0.09], 0.3])
    return StanceCase(Stance(feet), com, case.mass, np.zeros(6), "tilted")


def _two_soles(rng: np.random.Generator) -> StanceCase:
    """Return a humanoid's stance: two soles on ground that tilts under each."""
    feet = []
    for side in (1.0, -1.0):
        normal = np.array([*rng.normal(size=2) * 0.2, 1.0])
        place = np.array([rng.uniform(-0.1, 0.1), 0.1 * side, rng.uniform(0.0, 0.1)])
        sole = Sole(0.2, 0.1, rng.uniform(0.4, 0.9))
        feet.append(SoleContact(place, sole, normal / np.linalg.norm(normal)))
    return StanceCase(Stance(feet), np.array([0.0, 0.0, 0.8]), 35.0, np.zeros(6), "patches")
