"""Stances that are hard on arithmetic: points, segments, needles, walls, friction at its limit."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

import surefoot as sf

FAMILIES = (
    "tilted",
    "segment",
    "almost a line",
    "needle",
    "point",
    "almost a point",
    "diagonal pair",
    "friction at its limit",
    "little friction",
    "walls",
    "far away",
    "patches",
)
SCALES = (1e-6, 1e-3, 1.0, 1e3, 1e6)


@dataclass(frozen=True)
class Question:
    """A stance, where its centre of mass is, its mass, and the length that its coordinates are about."""

    family: str
    stance: sf.Stance
    com: np.ndarray
    mass: float
    length: float


def question(rng: np.random.Generator, family: str, scale: float = 1.0) -> Question:
    """Return one random question of a family, all lengths times `scale`."""
    places, normals, mu = _contacts(rng, family)
    places = scale * np.asarray(places, dtype=float)
    contacts: list[sf.PointContact | sf.SoleContact] = []
    for place, normal, friction in zip(places, normals, mu, strict=True):
        normal = np.asarray(normal, dtype=float) / np.linalg.norm(normal)
        if family == "patches":
            length, width = scale * rng.uniform(0.05, 0.25, size=2)
            heading = rng.normal(size=3)
            contacts.append(sf.SoleContact(place, sf.Sole(length, width, friction), normal, heading=heading))
        else:
            contacts.append(sf.PointContact(place, normal, friction))
    weights = rng.dirichlet(np.ones(len(places)))
    com = weights @ places
    if rng.random() < 0.5:
        com = com + scale * rng.normal(size=3) * [0.1, 0.1, 0.0]
    com[2] += scale * rng.uniform(0.2, 0.8)
    mass = float(10.0 ** rng.uniform(-3, 3))
    return Question(family, sf.Stance(contacts), com, mass, scale)


def _contacts(rng, family):
    """Return places of size one, normals and friction."""
    up, count = np.array([0.0, 0.0, 1.0]), int(rng.integers(3, 7))
    mu = rng.uniform(0.1, 1.1, size=count)
    spread = rng.uniform([-0.4, -0.4, -0.15], [0.4, 0.4, 0.15], size=(count, 3))
    tilted = up + np.column_stack([rng.normal(size=(count, 2)) * 0.3, np.zeros(count)])
    if family in ("segment", "almost a line", "needle"):
        along = np.array([*rng.normal(size=2), rng.normal() * 0.2])
        if rng.random() < 0.4:
            along = np.array([[0.0, 1.0, 0.1], [1.0, 0.0, 0.0]][int(rng.integers(2))])
        line = rng.uniform(-0.3, 0.3, size=3) + np.outer(rng.uniform(-0.5, 0.5, size=count), along)
        if family != "segment":
            low = -14.0 if family == "almost a line" else -5.0
            line += rng.normal(size=(count, 3)) * 10.0 ** rng.uniform(low, -2.0)
        level = rng.random() < 0.5
        return line, [up] * count if level else tilted, mu
    if family in ("point", "almost a point"):
        one = np.tile(spread[0], (count, 1))
        if family == "almost a point":
            one = one + rng.normal(size=(count, 3)) * 10.0 ** rng.uniform(-14.0, -3.0)
        return one, tilted * [0.3, 0.3, 1.0], mu
    if family == "diagonal pair":
        rise = rng.uniform(-0.5, 0.5, size=2)
        feet = np.array([[0.19, 0.14], [-0.19, -0.14]]) * rng.choice([-1.0, 1.0], size=2)
        normal = np.array([-rise[0], -rise[1], 1.0])
        return np.column_stack([feet, feet @ rise]), [normal] * 2, np.full(2, rng.uniform(0.4, 1.0))
    if family == "friction at its limit":
        rise = rng.uniform(0.05, 0.6)
        normal = np.array([-rise, 0.0, 1.0])
        places = np.column_stack([spread[:, :2], rise * spread[:, 0]])
        off = rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(-16.0, -2.0)
        return places, [normal] * count, np.full(count, rise * (1.0 + off))
    if family == "little friction":
        level = np.column_stack([spread[:, :2], spread[:, 2] * (rng.random() < 0.5)])
        small = np.where(rng.random(count) < 0.3, 0.0, 10.0 ** rng.uniform(-12.0, -2.0, size=count))
        lean = rng.choice([0.0, 1e-12, 1e-9, 1e-6])
        return level, up + lean * (tilted - up), small
    if family == "walls":
        side = np.where(np.arange(count) % 2 == 0, 1.0, -1.0)
        places = np.column_stack([0.3 * side, spread[:, 1], 2.0 * spread[:, 2]])
        normals = np.column_stack([-side, rng.normal(size=(count, 2)) * rng.choice([0.0, 0.25])])
        return places, normals, mu * 10.0 ** rng.choice([0.0, 0.0, -3.0])
    if family == "far away":
        return spread + rng.normal(size=3) * 10.0 ** rng.uniform(1.0, 4.0), tilted, mu
    if family == "patches":
        return spread[:2], tilted[:2], mu[:2]
    if rng.random() < 0.2:
        mu = mu * 10.0 ** rng.uniform(0.0, 4.0)
    return spread, tilted, mu


def corner_contacts(stance: sf.Stance):
    """Return (position, rotation, mu) of every point and sole corner, worked out here."""
    out = []
    for c in stance:
        R = np.asarray(c.rotation_world_contact)
        half = np.zeros(3)
        if isinstance(c, sf.SoleContact):
            half[:2] = 0.5 * float(c.sole.length or 0.0), 0.5 * float(c.sole.width or 0.0)
        signs = [(0, 0)] if c.dim == 3 else [(1, 1), (1, -1), (-1, -1), (-1, 1)]
        out += [(c.position + R @ (half * [x, y, 0.0]), R, c.mu) for x, y in signs]
    return out


def directions(rng: np.random.Generator, polygon: np.ndarray, count: int) -> np.ndarray:
    """Return unit directions to judge a polygon by: across and along its sides, and at random."""
    angles = list(rng.uniform(0.0, 2.0 * math.pi, size=count))
    for a, b in zip(polygon[:4], np.roll(polygon, -1, axis=0)[:4], strict=True):
        if np.any(a != b):
            turn = math.atan2(b[1] - a[1], b[0] - a[0])
            angles += [turn, turn + math.pi, turn - 0.5 * math.pi, turn + 0.5 * math.pi]
    return np.column_stack([np.cos(angles), np.sin(angles)])
