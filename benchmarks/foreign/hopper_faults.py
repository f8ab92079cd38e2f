"""Failures of the hopper loop."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

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
    thrown_ball,
    tilt_bias,
    weak_motors,
    wrong_frame,
)  # fmt: skip

DRUM = ("drum", "barrel", "float")
FOOT = ("shoe", "rod", "shaft", "stroke")
JOINTS = {
    "tip_drive": ("tip", "gimbal", "ring"),
    "tilt_drive": ("tilt", "tube", "sleeve"),
    "stroke_drive": ("stroke", "rod", "shaft", "shoe"),
}
"""Motor to the other names of its joint and link."""
EVERY = (*JOINTS, *(name for names in JOINTS.values() for name in names))


def weak(rng: Rng) -> Fault:
    """Draw a failure: a motor or both hips'."""
    groups: list[dict[str, tuple[str, ...]]] = [{name: JOINTS[name]} for name in JOINTS]
    groups.append({name: JOINTS[name] for name in ("tip_drive", "tilt_drive")})
    return weak_motors(rng, groups, (0.8, 1.6))


def late(rng: Rng) -> Fault:
    """Draw a failure: measurements are old."""
    return Fault("delayed control", settings={"delay": between(rng, 0.015, 0.06)})


def saturated(rng: Rng) -> Fault:
    """Draw a failure: a telescope or hips without the strength for a hop, from the start or a time on."""
    telescope = rng.random() < 0.5
    key, limit = ("push_limit", between(rng, 50, 110)) if telescope else ("limit", between(rng, 0.6, 3.0))
    motors = ("stroke_drive",) if telescope else ("tip_drive", "tilt_drive")
    places = (*motors, *(name for motor in motors for name in JOINTS[motor]))
    if rng.random() < 0.5:
        return Fault("saturated actuator", places, settings={key: limit}, detail=f"{key} {limit:.3g}")
    return derated_motors(motors, places, limit, between(rng, 0.8, 1.4))


def slippery(rng: Rng) -> Fault:
    """Draw a failure: ice in the way, or everywhere."""
    if rng.random() < 0.4:
        return Fault("slippery ground", settings={"ground": Ground(mu=between(rng, 0.005, 0.05))})
    ground = Ground(ice=(between(rng, 0.15, 0.3), 3.0), ice_mu=between(rng, 0.003, 0.02))
    return Fault(
        "slippery ground", (*FOOT, "ice"), settings={"ground": ground, "speed": between(rng, 0.35, 0.5)},
        begins=lands_on("ice"),
    )  # fmt: skip


def lands_on(geom: str) -> Any:
    """Return whether the shoe touches a geom of the ground."""

    def begins(model: Any, data: Any) -> bool:
        pair = {model.geom(geom).id, model.geom("shoe").id}
        return any({c.geom1, c.geom2} == pair for c in data.contact[: data.ncon])

    return begins


def pushed(rng: Rng) -> Fault:
    """Draw a failure: a force on the drum, or a ball."""
    if rng.random() < 0.7:
        return push(rng, {"drum": DRUM}, (13.0, 26.0), (0.7, 1.7), 0.0)
    return thrown_ball(rng, "drum", DRUM, between(rng, 1.0, 2.0), (4.0, 7.0), (0.7, 1.6), (0.0, 0.0, 0.03))


def laden(rng: Rng) -> Fault:
    """Draw a failure: a sack beside the drum's middle, or mass that it gains."""
    return load(rng, "drum", DRUM, (4.0, 14.0), (0.7, 1.4), (between(rng, -0.12, 0.12), 0.0, 0.14))


def misjudged(rng: Rng) -> Fault:
    """Draw a failure: an unknown battery, or a push for mass that is not there."""
    if rng.random() < 0.6:
        mass, at = between(rng, 4.0, 8.0), choice(rng, (-1, 1)) * between(rng, 0.18, 0.3)
        battery = f"<geom name='battery' type='box' size='.04 .04 .04' pos='{at} 0 .08' mass='{mass}'/>"
        words = f"{mass:.2g} kg at x = {at:+.2f} m"
        return Fault("wrong mass", (*DRUM, "battery"), settings={"on_drum": battery}, detail=words)
    believed = between(rng, 24.0, 45.0)
    return Fault("wrong mass", DRUM, settings={"believed_mass": believed}, detail=f"{believed:.3g} kg")


def edge(rng: Rng) -> Fault:
    """Draw a failure: a step or a drop in the way."""
    height = choice(rng, (-1.0, 1.0)) * between(rng, 0.08, 0.2)
    ground = Ground(edge=(between(rng, 0.15, 0.3), height))

    def begins(model: Any, data: Any) -> bool:
        low = float(data.geom_xpos[model.geom("shoe").id][2]) < 0.0
        return low or bool(lands_on("terrace")(model, data))

    settings = {"ground": ground, "speed": between(rng, 0.35, 0.5)}
    return Fault("terrain edge", (*FOOT, "terrace", "deck"), settings=settings, begins=begins)


def misplaced(rng: Rng) -> Fault:
    """Draw a failure: the foot is placed beside where it should be, from a time on."""
    at = between(rng, 0.7, 1.4)
    place = tuple(choice(rng, (-1, 1)) * between(rng, *size) for size in ((0.04, 0.14), (0.0, 0.1)))
    settings = {"place": place, "place_from": at}
    begins = NextTouchdown("shoe", at)
    return Fault("foot placement", EVERY, None, settings, begins=begins, detail=f"{place} from {at:.2f} s")


def slow(rng: Rng) -> Fault:
    """Draw a failure: stances so long that the foot is left behind at the speed."""
    settings = {"spring": between(rng, 650, 1100), "thrust": 0.05, "speed": between(rng, 0.6, 1.0)}
    return Fault("slow gait", settings=settings)


def chattering(rng: Rng) -> Fault:
    """Draw a failure: gains of the hips or the telescope that the time step does not allow."""
    if rng.random() < 0.5:
        return Fault("chattering gains", EVERY, settings={"kd": between(rng, 150, 500), "limit": 80.0})
    return Fault(
        "chattering gains", EVERY, settings={"damper": between(rng, 600, 2000), "push_limit": 1500.0}
    )


def biased(rng: Rng) -> Fault:
    """Draw a failure: the drum's orientation, or a hip's angle."""
    if rng.random() < 0.6:
        return tilt_bias(rng, 0, (0.12, 0.3), DRUM)
    return joint_bias(rng, {"tip": (7, JOINTS["tip_drive"]), "tilt": (8, JOINTS["tilt_drive"])}, (0.12, 0.3))


def soft(rng: Rng) -> Fault:
    """Draw a failure: ground that swallows the hops, or throws back more than they brought."""
    if rng.random() < 0.5:
        ground = Ground(solref=f"{between(rng, 0.15, 0.4)} 1", solimp="0.3 0.8 0.02")
    else:
        ground = Ground(solref=f"{-between(rng, 300, 900)} {-between(rng, 0.0, 1.0)}", solimp="0.5 0.9 0.01")
    return Fault("soft contact", (*FOOT, "deck"), settings={"ground": ground})


def impossible(rng: Rng) -> Fault:
    """Draw a failure: a speed that no placement of the foot reaches."""
    return Fault("impossible command", settings={"speed": between(rng, 3.0, 6.0)})


FAULTS: Mapping[str, Draw] = {
    "weak actuator": weak,
    "delayed control": late,
    "saturated actuator": saturated,
    "slippery ground": slippery,
    "push": pushed,
    "payload": laden,
    "wrong mass": misjudged,
    "terrain edge": edge,
    "foot placement": misplaced,
    "slow gait": slow,
    "chattering gains": chattering,
    "sensor bias": biased,
    "wrong contact frame": wrong_frame,
    "soft contact": soft,
    "impossible command": impossible,
}
"""Cause to what draws a failure of it."""
