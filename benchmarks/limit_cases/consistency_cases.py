"""Exact drops and rolls in which one channel is beside the others: momentum, centre of mass, places, gaps."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from benchmarks.limit_cases.law_cases import ball
from benchmarks.limit_cases.made import Made, arrays_of, changed_log
from benchmarks.limit_cases.verdict import Verdict, breaks, keeps
from benchmarks.problems.exact_drops import Drop
from surefoot.records.log import Log

FALLS = Drop(0.5, (0.5, 0.0), 0.0, 0.6, 0.5)
"""A ball of 1 kg that bounces for a second."""
GLIDES = Drop(0.0, (0.1, 0.0), 0.0, 0.0, 0.0)
"""The same on ice, at 0.1 m/s."""
RESTS = Drop(0.0, (0.0, 0.0), 0.0, 0.0, 0.5)
"""The same at rest."""


def consistency_cases() -> Iterator[Verdict]:
    """Yield the cases of channels that are of one motion, and of whole flights."""
    yield from _momenta()
    yield from _places()
    yield from _gaps()
    yield from _flights()


def _momenta() -> Iterator[Verdict]:
    for share, law, why in (
        (5e-3, keeps, "load cells tell a force to half a percent"),
        (0.05, breaks, "a twentieth of the weight is missing"),
    ):
        arrays = arrays_of(log := FALLS.log(1e-3))
        arrays["momentum_rate"][:, 2] *= 1.0 + share
        yield law(f"a rate {100.0 * share:g} % too large", why, changed_log(log, arrays), "momentum")
    for way, law, why in (
        (1e-4, keeps, "motion capture tells a place to a tenth of a millimetre"),
        (2e-3, breaks, "2 mm in a row of 1 ms: 2 m/s that nothing had"),
    ):
        arrays = arrays_of(log := RESTS.log(1e-3))
        arrays["com"][700:, 0] += way
        name = f"a centre of mass that jumps by {1e3 * way:g} mm"
        yield law(name, why, changed_log(log, arrays), "centre of mass")
    for drop, scale, law, why in (
        (FALLS, 1.01, keeps, "scales tell a mass to a percent"),
        (FALLS, 1.1, breaks, "a tenth more momentum than the way shows"),
        (GLIDES, 1.1, breaks, "the same at a tenth of a metre in a second"),
    ):
        arrays = arrays_of(log := drop.log(1e-3))
        arrays["momentum"] *= scale
        speed = "slow" if drop is GLIDES else "fast"
        yield law(f"{speed} momentum times {scale:g}", why, changed_log(log, arrays), "centre of mass")


def _places() -> Iterator[Verdict]:
    for way, law, why in (
        (5e-4, keeps, "kinematics tell a contact point to half a millimetre"),
        (0.01, breaks, "a centimetre is a foot's own radius"),
    ):
        arrays = arrays_of(log := RESTS.log(1e-3))
        arrays["contact_positions"][:, :, 0] += way
        name = f"a contact point {1e3 * way:g} mm beside its force"
        yield law(name, why, changed_log(log, arrays), "pressing")
    for way, law, why in (
        (3e-3, keeps, "play of joints lets a foot's place jump by 3 mm"),
        (0.01, breaks, "a centimetre is more than play"),
    ):
        arrays = arrays_of(log := RESTS.log(1e-3))
        arrays["contact_positions"][700:, :, 1] += way
        name = f"a contact point that jumps by {1e3 * way:g} mm"
        yield law(name, why, changed_log(log, arrays), "contact jump")


def _gaps() -> Iterator[Verdict]:
    for way, law, why in (
        (1e-3, keeps, "a rangefinder tells a gap to a millimetre"),
        (5e-3, breaks, "5 mm is a thick sole"),
    ):
        arrays = arrays_of(log := FALLS.log(1e-3))
        arrays["gaps"][:100] += way
        name = f"a gap {1e3 * way:g} mm beside its place"
        yield law(name, why, changed_log(log, arrays, terrain="flat"), "gap place")
    arrays = arrays_of(log := FALLS.log(1e-3))
    arrays["gaps"][50:260] *= -1.0
    why = "a seventh of the rows has gaps of the other sign: the rest shows the ground"
    facts: dict[str, Any] = {"contact_with": ["floor"]}
    yield breaks("gaps of the other sign for a while", why, changed_log(log, arrays, **facts), "gap place")
    made = Made(400, feet=1, kind="recording", contact_with=["floor"])
    place, normals = np.zeros((400, 1, 3)), np.tile([0.0, 0.0, 1.0], (400, 1, 1))
    made.gaps[200:] = 0.04
    made.forces[200:] = 0.0
    place[200:] = [0.05, 0.0, 0.04]
    made.more |= {"contact_positions": place, "normals": normals}
    why = "a box lifts one corner and rests on another, 6 cm away: the recording's point is the other one"
    yield keeps("a recorded point that is another one", why, made.log(), "gap rate")


def _flights() -> Iterator[Verdict]:
    why = "5.3 cm fallen, 14.1 cm come back, in flights of ten rows and of twenty"
    log = _lively(0.053, 0.01)
    arrays = {name: np.array(a)[:30] for name, a in log.arrays.items()}
    yield breaks("a ball that comes back higher", why, changed_log(log, arrays), "flight")
    why = "the same of a ball whose air takes 3 % of g: a table tennis ball at 1.5 m/s"
    yield breaks("a ball in air that comes back higher", why, _lively(0.3, 1e-3, 0.97), "flight")
    log = Drop.seeded(31).log(5e-4)
    arrays = {name: np.array(a)[1:] for name, a in log.arrays.items()}
    for name in ("forces", "momentum_rate"):
        arrays[name] = np.array(log[name])[:-1]
    why = "logged after each step: of rows that are exact the gaps do not tell whose velocities they have"
    yield keeps("an exact drop, logged after each step", why, changed_log(log, arrays), "restitution")


def _lively(height: float, dt: float, share: float = 1.0) -> Log:
    """Return a ball that comes back 2.66 times as high, its fall and rise slowed down to a share of g."""
    made = ball(1.63, dt, height)
    made.velocities[:, :, 2] *= share
    return made.log()
