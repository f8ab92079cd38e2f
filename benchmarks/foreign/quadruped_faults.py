"""Failures of the quadruped loop."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from benchmarks.foreign.fault import Draw, Fault
from benchmarks.foreign.ground import Ground
from benchmarks.foreign.injections import (
    NextTouchdown,
    Rng,
    between,
    choice,
    derated_motors,
    joint_bias,
    load,
    push,
    self_contact,
    thrown_ball,
    tilt_bias,
    weak_motors,
    wrong_frame,
)  # fmt: skip
from benchmarks.foreign.quadruped import LEGS

TRUNK = ("crate", "hull", "nose", "loose")
MOTORS = {"spread": "roll", "swing": "swing", "bend": "bend"}


def names_of(leg: str) -> tuple[str, ...]:
    """Return all names of a leg: links, joints, geoms, motors."""
    links = ("yoke", "can", "upper", "bone", "lower", "shin")
    return (
        leg, f"toe_{leg}", *(f"{leg}_{part}" for part in (*links, "roll", "swing", "bend")),
        *(f"{motor}_{leg}" for motor in MOTORS),
    )  # fmt: skip


def toes() -> tuple[str, ...]:
    """Return the names of all toes and the links that end in them."""
    return tuple(name for leg in LEGS for name in (f"toe_{leg}", f"{leg}_lower", f"{leg}_shin"))


def weak(rng: Rng) -> Fault:
    """Draw a failure: one or two motors of a leg."""
    groups = []
    for leg in LEGS:
        links = {"spread": "yoke", "swing": "upper", "bend": "lower"}
        one = {f"{m}_{leg}": (f"{leg}_{j}", f"{leg}_{links[m]}") for m, j in MOTORS.items()}
        groups += [{k: v for k, v in one.items() if not k.startswith(skip)} for skip in ("spread", "bend")]
        groups.append({f"bend_{leg}": one[f"bend_{leg}"]})
    return weak_motors(rng, groups, (0.7, 1.6))


def late(rng: Rng) -> Fault:
    """Draw a failure: measurements of joints and base are old."""
    more = {"kp": between(rng, 110, 160), "kd": between(rng, 3.0, 5.0)}
    return Fault("delayed control", settings={"delay": between(rng, 0.015, 0.06), **more})


def saturated(rng: Rng) -> Fault:
    """Draw a failure: small motors, from the start or by a faster trot; or limits that fall at a time."""
    if rng.random() < 0.5:
        return Fault("saturated actuator", every_joint(), settings={"limit": between(rng, 1.2, 3.0)})
    return derated_motors((), every_joint(), between(rng, 1.0, 2.6), between(rng, 0.8, 1.4))


def every_joint() -> tuple[str, ...]:
    """Return the names of all joints, motors and links."""
    return tuple(name for leg in LEGS for name in names_of(leg))


def steep(rng: Rng) -> Fault:
    """Draw a failure: a plane or a tilted box beyond the angle of friction."""
    mu = between(rng, 0.2, 0.4)
    slope = (np.arctan(mu) + between(rng, 0.04, 0.12)) * choice(rng, (-1.0, 1.0))
    ground = Ground(mu=mu, slope=float(slope), thick=bool(rng.random() < 0.5))
    return Fault("slope too steep", settings={"ground": ground, "trot": False})


def slippery(rng: Rng) -> Fault:
    """Draw a failure: ice in the way of a trot, or everywhere."""
    trot = {"trot": True, "speed": between(rng, 0.35, 0.5)}
    if rng.random() < 0.4:
        ground = Ground(mu=between(rng, 0.01, 0.06))
        return Fault("slippery ground", settings={"ground": ground, **trot, "speed": between(rng, 0.4, 0.6)})
    ground = Ground(ice=(between(rng, 0.35, 0.5), 3.0), ice_mu=between(rng, 0.005, 0.03))
    return Fault(
        "slippery ground", (*toes(), "ice"), settings={"ground": ground, **trot}, begins=touches("ice")
    )


def touches(geom: str, above: float = -1.0) -> Any:
    """Return whether a toe touches a geom of the ground."""

    def begins(model: Any, data: Any) -> bool:
        ground = model.geom(geom).id
        return any(ground in (c.geom1, c.geom2) for c in data.contact[: data.ncon])

    return begins


def pushed(rng: Rng) -> Fault:
    """Draw a failure: a force on the trunk, or a ball."""
    if rng.random() < 0.7:
        return push(rng, {"crate": TRUNK}, (10.0, 22.0), (0.8, 1.8), 0.7)
    return thrown_ball(rng, "crate", TRUNK, between(rng, 1.5, 2.5), (5.0, 8.0), (0.8, 1.6))


def laden(rng: Rng) -> Fault:
    """Draw a failure: a sack on the trunk, or mass that it gains."""
    return load(rng, "crate", TRUNK, (10.0, 24.0), (0.7, 1.5), (between(rng, -0.08, 0.08), 0.0, 0.13))


def edge(rng: Rng) -> Fault:
    """Draw a failure: a drop or a step in the way of a trot."""
    height = choice(rng, (-1.0, 1.0)) * between(rng, 0.09, 0.16)
    ground = Ground(edge=(between(rng, 0.35, 0.5), height))
    settings = {"ground": ground, "trot": True, "speed": between(rng, 0.35, 0.5)}

    def begins(model: Any, data: Any) -> bool:
        if touches("terrace")(model, data):
            return True
        lowest = min(float(data.geom_xpos[model.geom(f"toe_{leg}").id][2]) for leg in LEGS)
        return height < 0 and lowest < 0.0

    return Fault("terrain edge", (*toes(), "terrace", "deck"), settings=settings, begins=begins)


def misplaced(rng: Rng) -> Fault:
    """Draw a failure: touchdowns of a leg or two at a wrong place, or late, from a time on."""
    leg, period = choice(rng, LEGS), between(rng, 0.36, 0.44)
    first = 0.5 if leg in ("nw", "se") else 0.0
    at = (round(between(rng, 0.8, 1.4) / period) + first) * period  # its swing begins
    settings: dict[str, Any] = {"trot": True, "shift_from": at - 1e-6, "period": period}
    legs = [leg] if rng.random() < 0.6 else [leg, leg[0] + ("e" if leg[1] == "w" else "w")]
    places = tuple(n for one in legs for n in names_of(one))
    if rng.random() < 0.65:
        x, y = choice(rng, (-1, 1)) * between(rng, 0.1, 0.17), between(rng, 0.0, 0.08)
        settings["shift"] = {one: (x, -y if one[1] == "w" else y) for one in legs}
        begins = NextTouchdown(f"toe_{leg}", at)
        words = f"{' and '.join(legs)} by {x:+.2f}, {y:.2f} m inwards"
        return Fault("foot placement", places, None, settings, begins=begins, detail=words)
    settings["late"] = {leg: between(rng, 0.25, 0.5)}
    words = f"{leg} late by {settings['late'][leg]:.2f} of {period:.2f} s"
    return Fault("foot placement", names_of(leg), at + 0.5 * period, settings, detail=words)


def slow(rng: Rng) -> Fault:
    """Draw a failure: a period in which the trunk falls over between two diagonals."""
    return Fault(
        "slow gait",
        settings={"trot": True, "period": between(rng, 0.9, 1.6), "speed": between(rng, 0.35, 0.6)},
    )


def chattering(rng: Rng) -> Fault:
    """Draw a failure: gains that the time step does not allow."""
    if rng.random() < 0.5:
        return Fault("chattering gains", every_joint(), settings={"kd": between(rng, 10.0, 25.0)})
    more = {"kp": between(rng, 2500, 6000), "kd": between(rng, 6.0, 12.0), "limit": 60.0}
    return Fault("chattering gains", every_joint(), settings=more)


def biased(rng: Rng) -> Fault:
    """Draw a failure: the trunk's orientation, or one joint's angle."""
    if rng.random() < 0.5:
        fault = tilt_bias(rng, 0, (0.3, 0.5), TRUNK)
        return Fault(**{**vars(fault), "settings": {"trot": False, "level": 1.5}})
    order = [f"{leg}_{joint}" for leg in LEGS for joint in ("roll", "swing", "bend")]
    joints = {n: (7 + k, names_of(n[:2])) for k, n in enumerate(order) if not n.endswith("roll")}
    return joint_bias(rng, joints, (0.5, 0.9))


def soft(rng: Rng) -> Fault:
    """Draw a failure: ground that gives way, that throws back, or that one sinks into."""
    if rng.random() < 0.6:
        ground = Ground(solref=f"{between(rng, 0.15, 0.4)} 1", solimp="0.3 0.8 0.02")
    else:
        ground = Ground(solref=f"{-between(rng, 800, 2500)} {-between(rng, 0.0, 2.0)}", solimp="0.5 0.9 0.01")
    return Fault("soft contact", (*toes(), "deck"), settings={"ground": ground})


def jammed(rng: Rng) -> Fault:
    """Draw a failure: two legs led into each other."""
    end, at = choice(rng, "ns"), between(rng, 0.7, 1.4)
    legs = (f"{end}w", f"{end}e")
    settings = {"inward": {leg: between(rng, 0.6, 0.85) for leg in legs}, "shift_from": at}
    places = tuple(name for leg in legs for name in names_of(leg))
    return Fault("self-collision", places, None, settings, begins=self_contact)


def impossible(rng: Rng) -> Fault:
    """Draw a failure: a speed that no trot of these legs has."""
    return Fault("impossible command", settings={"trot": True, "speed": between(rng, 1.8, 3.0)})


FAULTS: Mapping[str, Draw] = {
    "weak actuator": weak,
    "delayed control": late,
    "saturated actuator": saturated,
    "slope too steep": steep,
    "slippery ground": slippery,
    "push": pushed,
    "payload": laden,
    "terrain edge": edge,
    "foot placement": misplaced,
    "slow gait": slow,
    "chattering gains": chattering,
    "sensor bias": biased,
    "wrong contact frame": wrong_frame,
    "soft contact": soft,
    "self-collision": jammed,
    "impossible command": impossible,
}
"""Cause to what draws a failure of it."""
