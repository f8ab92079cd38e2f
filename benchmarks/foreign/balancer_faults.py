"""Failures of the balancer."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from benchmarks.foreign.balancer import SIDES
from benchmarks.foreign.fault import Draw, Fault
from benchmarks.foreign.ground import Ground
from benchmarks.foreign.injections import (
    Rng,
    between,
    choice,
    derated_motors,
    push,
    thrown_ball,
    tilt_bias,
    weak_motors,
    wrong_frame,
)  # fmt: skip

MAST = ("pole", "head", "roam")
WHEEL = {side: (f"wheel_{side}", f"tyre_{side}", f"axle_{side}", f"drive_{side}") for side in SIDES}
EVERY = tuple(name for names in WHEEL.values() for name in names)


def weak(rng: Rng) -> Fault:
    """Draw a failure: both wheels' motors."""
    groups = [{f"drive_{side}": WHEEL[side] for side in SIDES}]
    return weak_motors(rng, groups, (0.6, 1.4))


def late(rng: Rng) -> Fault:
    """Draw a failure: measurements are old."""
    return Fault("delayed control", settings={"delay": between(rng, 0.03, 0.06), "kd": between(rng, 12, 20)})


def saturated(rng: Rng) -> Fault:
    """Draw a failure: motors too small, from a time on."""
    return derated_motors((), EVERY, between(rng, 0.02, 0.2), between(rng, 0.1, 0.6))


def slippery(rng: Rng) -> Fault:
    """Draw a failure: ice everywhere, or in the way."""
    if rng.random() < 0.4:
        return Fault("slippery ground", settings={"ground": Ground(mu=between(rng, 0.001, 0.01))})
    ground = Ground(ice=(between(rng, 0.3, 0.5), 3.0), ice_mu=between(rng, 0.0005, 0.004))

    def begins(model: Any, data: Any) -> bool:
        ice = model.geom("ice").id
        return any(ice in (c.geom1, c.geom2) for c in data.contact[: data.ncon])

    settings = {"ground": ground, "speed": between(rng, 0.5, 0.7), "duration": 4.0}
    return Fault("slippery ground", (*EVERY, "ice"), settings=settings, begins=begins)


def pushed(rng: Rng) -> Fault:
    """Draw a failure: a blow on the post, or a ball from the side."""
    if rng.random() < 0.7:
        return push(rng, {"mast": MAST}, (8.0, 25.0), (0.7, 1.8), 0.0)
    return thrown_ball(rng, "mast", MAST, between(rng, 1.5, 3.0), (6.0, 9.0), (0.7, 1.6), (0.0, 0.0, 0.45))


def misjudged(rng: Rng) -> Fault:
    """Draw a failure: a rucksack that nobody knows of."""
    at = choice(rng, (-1, 1)) * between(rng, 0.15, 0.3)
    mass = between(rng, 5.0, 12.0)
    pack = f"<geom name='pack' type='box' size='.05 .08 .08' pos='{at} 0 .3' mass='{mass}'/>"
    words = f"{mass:.2g} kg at x = {at:+.2f} m"
    return Fault("wrong mass", ("mast", *MAST, "pack"), settings={"on_post": pack}, detail=words)


def edge(rng: Rng) -> Fault:
    """Draw a failure: a step or a drop in the way."""
    height = choice(rng, (-1.0, 1.0)) * between(rng, 0.06, 0.12)
    ground = Ground(edge=(between(rng, 0.3, 0.5), height))

    def begins(model: Any, data: Any) -> bool:
        terrace = model.geom("terrace").id
        if any(terrace in (c.geom1, c.geom2) for c in data.contact[: data.ncon]):
            return True
        return height < 0 and min(float(data.geom_xpos[model.geom(f"tyre_{s}").id][2]) for s in SIDES) < 0.09

    settings = {"ground": ground, "speed": between(rng, 0.4, 0.6), "duration": 4.0}
    return Fault("terrain edge", (*EVERY, "terrace", "deck"), settings=settings, begins=begins)


def chattering(rng: Rng) -> Fault:
    """Draw a failure: a gain that the time step does not allow."""
    settings = {"kd": between(rng, 300.0, 1200.0), "limit": 60.0}
    return Fault("chattering gains", EVERY, settings=settings)


def biased(rng: Rng) -> Fault:
    """Draw a failure: pitch is measured with an offset: it runs away, or falls."""
    return tilt_bias(rng, 0, (0.25, 0.5), ("mast", *MAST))


def soft(rng: Rng) -> Fault:
    """Draw a failure: ground that swallows the wheels."""
    ground = Ground(solref=f"{between(rng, 0.15, 0.4)} 1", solimp="0.3 0.8 0.02")
    return Fault("soft contact", (*EVERY, "deck"), settings={"ground": ground})


def impossible(rng: Rng) -> Fault:
    """Draw a failure: a speed that it falls over on its way to."""
    return Fault("impossible command", settings={"speed": between(rng, 6.0, 12.0), "limit": 12.0})


FAULTS: Mapping[str, Draw] = {
    "weak actuator": weak,
    "delayed control": late,
    "saturated actuator": saturated,
    "slippery ground": slippery,
    "push": pushed,
    "wrong mass": misjudged,
    "terrain edge": edge,
    "chattering gains": chattering,
    "sensor bias": biased,
    "wrong contact frame": wrong_frame,
    "soft contact": soft,
    "impossible command": impossible,
}
"""Cause to what draws a failure of it."""
