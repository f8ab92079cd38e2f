"""Failures of the standing humanoid."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from benchmarks.foreign.fault import Draw, Fault
from benchmarks.foreign.ground import Ground
from benchmarks.foreign.humanoid import SIDES
from benchmarks.foreign.injections import (
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

PELVIS, CHEST = ("pelvis", "bowl", "floating"), ("chest", "ribs", "skull", "waist")
PARTS = {
    "hip_roll": ("hip", "knob"),
    "hip_pitch": ("thigh", "femur"),
    "knee": ("shank", "tibia"),
    "ankle_pitch": ("joint", "malleolus"),
    "ankle_roll": ("foot", "sole"),
}
"""Joint of a leg to its link and geom."""
SOLES = tuple(f"{side}_{part}" for side in SIDES for part in ("sole", "foot"))


def names_of(side: str, joint: str) -> tuple[str, ...]:
    """Return the names of a joint of a leg: itself, its motor, link and geom."""
    return (f"{side}_{joint}", f"m_{side}_{joint}", *(f"{side}_{part}" for part in PARTS[joint]))


def leg(side: str) -> tuple[str, ...]:
    """Return all names of a leg."""
    return tuple(name for joint in PARTS for name in names_of(side, joint))


EVERY = (*leg("port"), *leg("star"), "waist", "m_waist", "chest", "pelvis")


def weak(rng: Rng) -> Fault:
    """Draw a failure: a motor of a leg, or two."""
    groups = []
    for side in SIDES:
        for joints in (("knee",), ("ankle_pitch", "knee"), ("hip_pitch",), ("ankle_roll", "hip_roll")):
            groups.append({f"m_{side}_{j}": names_of(side, j) for j in joints})
    return weak_motors(rng, groups, (0.6, 1.4))


def late(rng: Rng) -> Fault:
    """Draw a failure: measurements are old."""
    return Fault("delayed control", settings={"delay": between(rng, 0.015, 0.06)})


def saturated(rng: Rng) -> Fault:
    """Draw a failure: motors too weak for the stand, from the start or a time on."""
    limit = between(rng, 3.0, 12.0)
    if rng.random() < 0.5:
        return Fault("saturated actuator", EVERY, settings={"limit": limit}, detail=f"{limit:.2g} N m")
    return derated_motors((), EVERY, limit, between(rng, 0.6, 1.2))


def steep(rng: Rng) -> Fault:
    """Draw a failure: ground beyond the angle of friction."""
    mu = between(rng, 0.08, 0.2)
    slope = choice(rng, (-1.0, 1.0)) * (np.arctan(mu) + between(rng, 0.03, 0.08))
    ground = Ground(mu=mu, slope=float(slope), thick=bool(rng.random() < 0.5))
    return Fault("slope too steep", settings={"ground": ground, "sway": 0.0, "forward": 0.0})


def pushed(rng: Rng) -> Fault:
    """Draw a failure: a force on pelvis or chest, or a ball."""
    if rng.random() < 0.7:
        return push(rng, {"pelvis": PELVIS, "chest": CHEST}, (20.0, 45.0), (0.6, 1.4), 0.0)
    return thrown_ball(rng, "chest", CHEST, between(rng, 3.0, 5.0), (6.0, 9.0), (0.6, 1.3), (0.0, 0.0, 0.2))


def laden(rng: Rng) -> Fault:
    """Draw a failure: something heavy that the chest or an arm has to carry."""
    body = choice(rng, ("chest", "port_upper_arm", "star_upper_arm"))
    if body == "chest":
        return load(rng, body, CHEST, (60.0, 150.0), (0.6, 1.2), None)
    side = body[:4]
    return load(rng, body, (f"{side}_limb", f"{side}_arm", f"m_{side}_arm"), (20.0, 50.0), (0.6, 1.2), None)


def misjudged(rng: Rng) -> Fault:
    """Draw a failure: knees that push for mass that is not there, or a rucksack that nobody knows of."""
    if rng.random() < 0.4:
        believed = between(rng, 150.0, 400.0)
        words = f"{believed:.3g} kg"
        return Fault("wrong mass", (*PELVIS, *CHEST), settings={"believed_mass": believed}, detail=words)
    mass, at = between(rng, 12.0, 30.0), choice(rng, (-1, 1)) * between(rng, 0.15, 0.22)
    pack = f"<geom name='pack' type='box' size='.05 .1 .1' pos='{at} 0 .2' mass='{mass}'/>"
    words = f"{mass:.2g} kg at x = {at:+.2f} m"
    return Fault("wrong mass", (*PELVIS, *CHEST, "pack"), settings={"on_chest": pack}, detail=words)


def chattering(rng: Rng) -> Fault:
    """Draw a failure: gains that the time step does not allow."""
    if rng.random() < 0.5:
        return Fault("chattering gains", EVERY, settings={"kd": between(rng, 60, 150)})
    return Fault(
        "chattering gains", EVERY, settings={"kp": between(rng, 2e4, 6e4), "kd": between(rng, 20, 50)}
    )


def biased(rng: Rng) -> Fault:
    """Draw a failure: the pelvis' orientation, or the angle of an ankle, knee or hip."""
    if rng.random() < 0.5:
        return tilt_bias(rng, 0, (0.15, 0.4), PELVIS)
    order = [f"{side}_{joint}" for side in SIDES for joint in PARTS]
    joints = {n: (7 + k, names_of(n[:4], n[5:])) for k, n in enumerate(order) if "roll" not in n}
    return joint_bias(rng, joints, (0.2, 0.5))


def soft(rng: Rng) -> Fault:
    """Draw a failure: ground that the soles sink into, or that swings."""
    if rng.random() < 0.6:
        ground = Ground(solref=f"{between(rng, 0.15, 0.4)} 1", solimp="0.3 0.8 0.02")
    else:
        ground = Ground(solref=f"{-between(rng, 200, 900)} {-between(rng, 0.0, 1.0)}", solimp="0.5 0.9 0.01")
    return Fault("soft contact", (*SOLES, "deck"), settings={"ground": ground})


def jammed(rng: Rng) -> Fault:
    """Draw a failure: a leg is led into the other."""
    side = choice(rng, SIDES)
    settings = {"cross": (between(rng, 0.6, 1.2), side)}
    return Fault("self-collision", (*leg("port"), *leg("star")), None, settings, begins=self_contact)


def impossible(rng: Rng) -> Fault:
    """Draw a failure: a lean beyond the feet."""
    return Fault("impossible command", settings={"lean": choice(rng, (-1, 1)) * between(rng, 0.25, 0.5)})


FAULTS: Mapping[str, Draw] = {
    "weak actuator": weak,
    "delayed control": late,
    "saturated actuator": saturated,
    "slope too steep": steep,
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
