"""Failures of the hexapod."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from benchmarks.foreign.fault import Draw, Fault
from benchmarks.foreign.ground import Ground
from benchmarks.foreign.hexapod import KINDS, LEGS
from benchmarks.foreign.injections import (
    NextTouchdown,
    Rng,
    between,
    choice,
    derated_motors,
    load,
    push,
    tilt_bias,
    weak_motors,
    wrong_frame,
)  # fmt: skip

PLATE = ("disc", "adrift")


def names_of(leg: str) -> tuple[str, ...]:
    """Return all names of a leg: links, joints, geoms, servos."""
    parts = ("coxa", "hub", "femur", "bar", "tibia", "rod", "button", *KINDS, *(f"s_{k}" for k in KINDS))
    return tuple(f"{part}_{leg}" for part in parts)


EVERY = tuple(name for leg in LEGS for name in names_of(leg))
FEET = tuple(f"{part}_{leg}" for leg in LEGS for part in ("button", "tibia", "rod"))


def weak(rng: Rng) -> Fault:
    """Draw a failure: servos of the legs of one side give way."""
    groups = []
    for two in ("abc", "def"):
        names = {f"s_{k}_{leg}": (f"{k}_{leg}", *names_of(leg)) for leg in two for k in ("raise", "knee")}
        groups.append(names)
    return weak_motors(rng, groups, (0.6, 1.4))


def saturated(rng: Rng) -> Fault:
    """Draw a failure: servos too small for the plate, from the start or a time on."""
    if rng.random() < 0.5:
        return Fault("saturated actuator", EVERY, settings={"limit": between(rng, 0.3, 0.7)})
    return derated_motors((), EVERY, between(rng, 0.25, 0.6), between(rng, 0.6, 1.4))


def slippery(rng: Rng) -> Fault:
    """Draw a failure: ice everywhere, or in the way."""
    if rng.random() < 0.5:
        ground = Ground(mu=between(rng, 0.002, 0.01))
        return Fault("slippery ground", settings={"ground": ground, "speed": between(rng, 0.25, 0.4)})
    ground = Ground(ice=(between(rng, 0.3, 0.4), 3.0), ice_mu=between(rng, 0.001, 0.006))
    settings = {"ground": ground, "speed": between(rng, 0.25, 0.35), "duration": 5.0}

    def begins(model: Any, data: Any) -> bool:
        ice = model.geom("ice").id
        return any(ice in (c.geom1, c.geom2) for c in data.contact[: data.ncon])

    return Fault("slippery ground", (*FEET, "ice"), settings=settings, begins=begins)


def steep(rng: Rng) -> Fault:
    """Draw a failure: ground beyond the angle of friction."""
    mu = between(rng, 0.15, 0.35)
    slope = float((np.arctan(mu) + between(rng, 0.04, 0.12)) * choice(rng, (-1.0, 1.0)))
    return Fault("slope too steep", settings={"ground": Ground(mu=mu, slope=slope)})


def pushed(rng: Rng) -> Fault:
    """Draw a failure: a blow that turns it over."""
    return push(rng, {"plate": PLATE}, (9.0, 20.0), (0.7, 1.6), 0.7)


def laden(rng: Rng) -> Fault:
    """Draw a failure: a sack on the plate, or mass that it gains."""
    return load(rng, "plate", PLATE, (25.0, 50.0), (0.7, 1.4), (between(rng, -0.03, 0.03), 0.0, 0.09))


def edge(rng: Rng) -> Fault:
    """Draw a failure: a step or a drop in the way."""
    height = choice(rng, (-1.0, 1.0)) * between(rng, 0.07, 0.11)
    ground = Ground(edge=(between(rng, 0.3, 0.4), height))
    settings = {"ground": ground, "speed": between(rng, 0.2, 0.3), "duration": 5.0}

    def begins(model: Any, data: Any) -> bool:
        terrace = model.geom("terrace").id
        if any(terrace in (c.geom1, c.geom2) for c in data.contact[: data.ncon]):
            return True
        lowest = min(float(data.geom_xpos[model.geom(f"button_{leg}").id][2]) for leg in LEGS)
        return height < 0 and lowest < 0.0

    return Fault("terrain edge", (*FEET, "terrace", "deck"), settings=settings, begins=begins)


def misplaced(rng: Rng) -> Fault:
    """Draw a failure: the legs of a side set down under the plate, from a time on."""
    three, at = choice(rng, ("abc", "def")), between(rng, 1.3, 1.7)
    aside = (-1.0 if three == "abc" else 1.0) * between(rng, 0.16, 0.22)
    settings = {"shift": dict.fromkeys(three, (0.0, aside)), "shift_from": at}
    places = tuple(name for leg in three for name in names_of(leg))
    first = [NextTouchdown(f"button_{leg}", at) for leg in three]

    def begins(model: Any, data: Any) -> bool:
        down = [one(model, data) for one in first]  # each has to see every step
        return any(down)

    return Fault("foot placement", places, None, settings, begins=begins, detail=f"{three} from {at:.2f} s")


def chattering(rng: Rng) -> Fault:
    """Draw a failure: servos so stiff, and so little damped, that they ring."""
    settings = {"kp": between(rng, 2e3, 8e3), "kv": 0.0, "limit": between(rng, 15.0, 30.0)}
    return Fault("chattering gains", EVERY, settings=settings)


def biased(rng: Rng) -> Fault:
    """Draw a failure: the plate's orientation is measured with an offset, which levelling follows."""
    return tilt_bias(rng, 0, (0.2, 0.5), ("plate", *PLATE))


def soft(rng: Rng) -> Fault:
    """Draw a failure: ground that swallows the feet, or swings."""
    if rng.random() < 0.6:
        ground = Ground(solref=f"{between(rng, 0.2, 0.5)} 1", solimp="0.2 0.7 0.03")
    else:
        ground = Ground(solref=f"{-between(rng, 100, 400)} {-between(rng, 0.0, 1.0)}", solimp="0.5 0.9 0.01")
    return Fault("soft contact", (*FEET, "deck"), settings={"ground": ground})


def impossible(rng: Rng) -> Fault:
    """Draw a failure: a speed that no walk of these legs has."""
    return Fault("impossible command", settings={"speed": between(rng, 1.5, 3.0)})


FAULTS: Mapping[str, Draw] = {
    "weak actuator": weak,
    "saturated actuator": saturated,
    "slope too steep": steep,
    "slippery ground": slippery,
    "push": pushed,
    "payload": laden,
    "terrain edge": edge,
    "foot placement": misplaced,
    "chattering gains": chattering,
    "sensor bias": biased,
    "wrong contact frame": wrong_frame,
    "soft contact": soft,
    "impossible command": impossible,
}
"""Cause to what draws a failure of it."""
