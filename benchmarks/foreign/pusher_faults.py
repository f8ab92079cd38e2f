"""Failures of the arm that pushes a box."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from benchmarks.foreign.fault import Draw, Fault
from benchmarks.foreign.ground import Ground
from benchmarks.foreign.injections import (
    Rng,
    between,
    choice,
    derated_motors,
    joint_bias,
    load,
    push,
    self_contact,
    weak_motors,
    wrong_frame,
)  # fmt: skip
from benchmarks.foreign.pusher import HALF, TABLE

LINKS = {
    "pan": ("post", "turret"),
    "lift": ("boom", "beam"),
    "fold": ("forearm", "rod"),
    "drop": ("hand", "stem", "pad"),
}
"""Joint to the names of its link."""
BOX = ("parcel", "carton", "parcel_free")
HAND = ("drop", *LINKS["drop"])
EVERY = (*LINKS, *(f"servo_{n}" for n in LINKS), *(name for names in LINKS.values() for name in names))
ARM, PARCEL = {"watched": "post"}, {"watched": "parcel"}


def weak(rng: Rng) -> Fault:
    """Draw a failure: a servo that gives way, or two."""
    groups: list[dict[str, tuple[str, ...]]] = [{f"servo_{n}": (n, *LINKS[n])} for n in ("lift", "fold")]
    groups.append({f"servo_{n}": (n, *LINKS[n]) for n in ("lift", "fold")})
    return with_settings(weak_motors(rng, groups, (0.6, 1.4)), ARM)


def with_settings(fault: Fault, settings: Mapping[str, Any]) -> Fault:
    """Return a fault with more settings."""
    return Fault(**{**vars(fault), "settings": {**fault.settings, **settings}})


def saturated(rng: Rng) -> Fault:
    """Draw a failure: servos too weak for a heavy box, or for the arm."""
    if rng.random() < 0.5:
        heavy = {"box_mass": between(rng, 6.0, 9.0), "limit": between(rng, 6.5, 9.5)}
        return Fault("saturated actuator", EVERY, settings={**heavy, **ARM})
    return with_settings(derated_motors((), EVERY, between(rng, 2.0, 6.0), between(rng, 0.6, 1.4)), ARM)


def steep(rng: Rng) -> Fault:
    """Draw a failure: a table on which the box does not stay."""
    mu = between(rng, 0.15, 0.35)
    slope = np.arctan(mu) + between(rng, 0.04, 0.12)
    return Fault(
        "slope too steep", settings={"ground": Ground(mu=mu, slope=float(slope), solref=TABLE), **PARCEL}
    )


def slippery(rng: Rng) -> Fault:
    """Draw a failure: the box glides on when the hand brakes."""
    settings = {
        "ground": Ground(mu=between(rng, 0.005, 0.03), solref=TABLE),
        "arrive": between(rng, 0.7, 1.0),
    }
    return Fault("slippery ground", settings={**settings, **PARCEL})


def pushed(rng: Rng) -> Fault:
    """Draw a failure: somebody knocks against the box or the forearm."""
    if rng.random() < 0.7:
        return with_settings(push(rng, {"parcel": BOX}, (1.0, 3.0), (0.6, 1.6), 0.6), PARCEL)
    names = {"forearm": ("fold", "rod", "servo_fold"), "hand": ("stem", "pad", "drop", "servo_drop")}
    return with_settings(push(rng, names, (15.0, 40.0), (1.0, 1.8), 0.8), ARM)


def laden(rng: Rng) -> Fault:
    """Draw a failure: something heavy on the box, or on the forearm."""
    if rng.random() < 0.5:
        fault = load(rng, "parcel", BOX, (25.0, 50.0), (0.5, 1.2), (0.0, 0.0, HALF + 0.08))
        return with_settings(fault, {**PARCEL, "limit": 25.0})
    fault = load(rng, "forearm", ("rod", "fold", "servo_fold"), (6.0, 14.0), (0.6, 1.4), None)
    return with_settings(fault, ARM)


def misjudged(rng: Rng) -> Fault:
    """Draw a failure: the hand holds another mass than is compensated."""
    if rng.random() < 0.5:
        return Fault(
            "wrong mass", EVERY, settings={"tool": between(rng, 2.5, 5.0), **ARM, "kp": 180.0, "kv": 14.0}
        )
    return Fault("wrong mass", EVERY, settings={"believed_tool": between(rng, 2.5, 5.0), **ARM, "kp": 180.0})


def chattering(rng: Rng) -> Fault:
    """Draw a failure: a servo so stiff, and so little damped, that it rings."""
    return Fault(
        "chattering gains", EVERY, settings={"kp": between(rng, 2e4, 2e5), "kv": 0.0, "limit": 200.0, **ARM}
    )


def biased(rng: Rng) -> Fault:
    """Draw a failure: a joint whose zero is elsewhere, so that its servo leads it there."""
    order = ("pan", "lift", "fold")
    name = choice(rng, order)
    size = choice(rng, (-1.0, 1.0)) * between(rng, 0.12, 0.3)
    fault = joint_bias(rng, {name: (0, ())}, (0.0, 0.0))
    k, at = list(LINKS).index(name), fault.onset

    def turn(model: Any, data: Any) -> None:
        if at is None or data.time >= at:
            data.ctrl[k] -= size

    places = (name, f"servo_{name}", *LINKS[name])
    return Fault("sensor bias", places, at, dict(ARM), on_step=turn, detail=f"{name} {size:+.2f} rad off")


def soft(rng: Rng) -> Fault:
    """Draw a failure: a table that gives way under the box, or throws it."""
    if rng.random() < 0.6:
        ground = Ground(mu=0.4, solref=f"{between(rng, 0.15, 0.4)} 1", solimp="0.3 0.8 0.02")
    else:
        ground = Ground(mu=0.4, solref=f"{-between(rng, 200, 900)} 0", solimp="0.5 0.9 0.01")
    return Fault("soft contact", (*BOX, "deck"), settings={"ground": ground, **PARCEL})


def hits_itself(model: Any, data: Any) -> bool:
    """Return whether two links touch, or one the pillar that carries them."""
    pillar = model.geom("pillar").id
    return self_contact(model, data) or any(pillar in (c.geom1, c.geom2) for c in data.contact[: data.ncon])


def jammed(rng: Rng) -> Fault:
    """Draw a failure: the hand is drawn into the post."""
    at = between(rng, 0.6, 1.3)
    return Fault("self-collision", (*EVERY, "pillar"), None, {"fold_in": at, **ARM}, begins=hits_itself)


def impossible(rng: Rng) -> Fault:
    """Draw a failure: a goal beyond the arm's reach."""
    return Fault("impossible command", settings={"goal": between(rng, 0.85, 1.1), **ARM})


FAULTS: Mapping[str, Draw] = {
    "weak actuator": weak,
    "saturated actuator": saturated,
    "slope too steep": steep,
    "slippery ground": slippery,
    "push": pushed,
    "payload": laden,
    "wrong mass": misjudged,
    "chattering gains": chattering,
    "sensor bias": biased,
    "wrong contact frame": wrong_frame,
    "soft contact": soft,
    "self-collision": jammed,
    "impossible command": impossible,
}
"""Cause to what draws a failure of it."""
