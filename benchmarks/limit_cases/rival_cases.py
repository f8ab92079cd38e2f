"""Two things in one log that compete for its name: what is the cause, and what comes of it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from benchmarks.limit_cases.made import DT, MU, Made
from benchmarks.limit_cases.verdict import Verdict, named


def rival_cases() -> Iterator[Verdict]:
    """Yield the cases of forces alone in which two symptoms speak."""
    skates = Made(1500)
    part = slice(200, 500)
    skates.forces[part, 0, 2] *= np.where((np.arange(300) // 5) % 2, 1.5, 0.0)
    skates.velocities[part, 0, 0] = 0.2
    error = np.zeros(1500)
    error[part] = 0.3 * skates.weight
    skates.more["solver_error"] = error
    why = "two sweeps of PGS leave forces a third of the weight off its law: a foot skates for that"
    yield named("a solver that stops early, and skating", why, skates.log(), "unconverged solver")
    bent = Made(1500)
    bent.gaps[900:1100, 1] = 0.01
    bent.more["pyramid_turn"] = np.zeros((1500, 4))
    slip = np.sqrt(0.5) * np.array([1.0, 1.0])
    bent.velocities[part, 0, :2] = 0.2 * slip
    bent.forces[part, 0, :2] = -MU * np.sqrt(0.5) * slip * bent.forces[part, 0, 2:]
    why = "a slide along a pyramid's edge, which has 71 % of the friction there: that breaks no law"
    yield named("a foot held 1 cm up, and a pyramid's slide", why, bent.log(), "invisible geometry")
    yield named(
        "a soft sole that shears",
        "8 mm of rubber are 4 mm of shear at half the grip: what it gives back is no motor",
        _sole().log(),
        "deep contact",
    )
    yield named(
        "a lively foot that hops",
        "0.3 kg under a quarter of the weight, and a restitution of 1.1: it hops at 100 Hz, ever higher",
        _hopping(1.1).log(),
        "energy gain",
    )


def _sole() -> Made:
    """Return a foot 8 mm deep in its sole, which shears to and fro at 2 Hz and pulls back as a spring."""
    made = Made(2000, sinking=0.01)
    turn = 2.0 * np.pi * 2.0 * made.time
    made.gaps[:, 0] = -8e-3
    made.velocities[:, 0, 0] = 4e-3 * 2.0 * np.pi * 2.0 * np.cos(turn)
    made.forces[:, 0, 0] = -0.5 * MU * np.sin(turn) * made.forces[:, 0, 2]
    return made


def _hopping(restitution: float, mass: float = 0.3, start: float = 0.3) -> Made:
    """Return a stand whose first foot, of its own mass [kg], leaves the ground at a speed [m/s] and hops."""
    made, z, v = Made(1000), 0.0, start
    pressed = 0.25 * made.weight / mass
    for k in range(200, 400):
        free = v - pressed * DT
        new = -restitution * v if z + DT * free < 0.0 else free
        made.forces[k, 0, 2], made.gaps[k, 0], made.velocities[k, 0, 2] = mass * (new - free) / DT, z, new
        v, z = new, z + DT * new
    return made
