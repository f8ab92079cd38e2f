"""Random stances of every kind, seeded: the instances that statics is tested and measured on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.contact.cones import Sole
from surefoot.mechanics.stance import PointContact, SoleContact, Stance
from surefoot.mechanics.stance.contact import Contact
from surefoot.mechanics.statics.statics import friction_needed

KINDS = ("flat", "tilted", "patches", "chimney", "pushed", "edge")
"""Flat ground; tilted normals; patches among points; opposing walls; a push; friction just (not) enough."""


@dataclass(frozen=True)
class StanceCase:
    """One question: a stance, a centre of mass, a mass, a push on the robot, and the kind it is."""

    stance: Stance
    com: FloatArray
    mass: float
    external_wrench: FloatArray
    kind: str


def random_cases(count: int, seed: int = 0, kinds: tuple[str, ...] = KINDS) -> list[StanceCase]:
    """Return `count` cases, the kinds in turn, with 2 to 12 contacts each."""
    rng = np.random.default_rng(seed)
    return [random_case(rng, kinds[k % len(kinds)]) for k in range(count)]


def random_case(rng: np.random.Generator, kind: str, contacts: int | None = None) -> StanceCase:
    """Return one case of a kind; 2 to 12 contacts unless their number is given."""
    count = int(rng.integers(2, 13)) if contacts is None else contacts
    stance = Stance([_contact(rng, kind, k) for k in range(count)])
    low, high = stance.positions.min(axis=0), stance.positions.max(axis=0)
    com = rng.uniform(low - 0.1, high + 0.1)
    com[2] = high[2] + rng.uniform(-0.2, 0.6)
    mass = float(rng.uniform(1.0, 80.0))
    push = np.zeros(6)
    if kind == "pushed":
        push = rng.normal(size=6) * mass * np.array([2.0, 2.0, 2.0, 0.5, 0.5, 0.5])
    if kind == "edge":
        needed = friction_needed(stance, com, mass, push)
        if 0.0 < needed < 5.0:
            off = float(rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(-5.5, -2.0))
            stance = stance.with_friction(needed * (1.0 + off))
    return StanceCase(stance, com, mass, push, kind)


def _contact(rng: np.random.Generator, kind: str, k: int) -> Contact:
    place = rng.uniform([-0.4, -0.4, -0.15], [0.4, 0.4, 0.15])
    normal = np.array([0.0, 0.0, 1.0])
    if kind == "flat":
        place[2] = 0.0
    elif kind == "chimney":
        side = 1.0 if k % 2 else -1.0
        place[0], place[2] = 0.3 * side, rng.uniform(-0.5, 0.5)
        normal = np.array([-side, *rng.normal(size=2) * 0.25])
    else:
        normal[:2] = rng.normal(size=2) * 0.4
    normal /= np.linalg.norm(normal)
    mu = float(rng.uniform(0.1, 1.1))
    if kind == "patches" and rng.random() < 0.6:
        length, width = rng.uniform(0.05, 0.25, size=2)
        return SoleContact(place, Sole(length, width, mu), normal, heading=rng.normal(size=3))
    return PointContact(place, normal, mu)
