"""Rules on what makes time steps unstable: damping and servo gains against the inertia that they act on."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.mechanics.robot.lint.finding import Offence, Rule
from surefoot.mechanics.robot.lint.subject import Subject

STEP = 1e-3
"""Time step of a walk [s]."""
UNSTABLE = 2.0
"""h d / I from which an explicit step of damping d grows [-]: v' = (1 - h d / I) v."""
SPRING = 4.0
"""h² k / I from which a semi-implicit step of a spring k grows [-]."""
LEAST = 1e-10
"""Inertia that a joint moves below which a world refuses the robot [kg m²]: no step of 1 ms follows it."""


def _inertias(subject: Subject) -> dict[str, float]:
    """Return the inertia that each joint feels when it alone is pushed, its rotor included [kg m²]."""
    robot = subject.robot
    if robot is None or robot.joints == 0:
        return {}
    import pinocchio

    inverse: FloatArray = np.array(pinocchio.computeMinverse(robot.model, robot.data, robot.nominal))
    with np.errstate(divide="ignore", invalid="ignore"):
        felt = 1.0 / np.diag(inverse)
    rotors = {joint.name: joint.armature for joint in subject.facts.joints}
    model = robot.model
    out = {}
    for name, joint in zip(list(model.names)[1:], list(model.joints)[1:], strict=True):
        if joint.nv == 1:
            out[str(name)] = float(felt[joint.idx_v]) + max(rotors.get(str(name), 0.0), 0.0)
    return out


def _explicit(subject: Subject) -> tuple[bool, bool]:
    """Return whether the file's own integrator takes joint damping, and servos' damping, explicitly."""
    if subject.compiled is None:
        return False, False
    mujoco, option = subject.mujoco, subject.compiled.opt
    kinds = mujoco.mjtIntegrator
    euler = int(option.integrator) == int(kinds.mjINT_EULER)
    rk4 = int(option.integrator) == int(kinds.mjINT_RK4)
    undamped = bool(option.disableflags & int(mujoco.mjtDisableBit.mjDSBL_EULERDAMP))
    return rk4 or (euler and undamped), rk4 or euler


def _unstable_damping(subject: Subject) -> Iterator[Offence]:
    felt = _inertias(subject)
    h = STEP if subject.compiled is None else float(subject.compiled.opt.timestep)
    damping_is_explicit, servo_is_explicit = _explicit(subject)
    for joint in subject.facts.joints:
        if joint.damping < 0.0:
            yield Offence(f"joint {joint.name}", f"damping {joint.damping:g}", "it drives the joint", "error")
        inertia = felt.get(joint.name, 0.0)
        share = h * joint.damping / inertia if inertia > 0.0 else 0.0
        if share > UNSTABLE:
            detail = _sentence(h, share, "d", inertia, joint.armature)
            severity = "error" if damping_is_explicit else ""
            yield Offence(f"joint {joint.name}", f"damping {joint.damping:g} N m s", detail, severity)
    for actuator in subject.facts.actuators:
        inertia = felt.get(actuator.joint, 0.0)
        if inertia <= 0.0:
            continue
        share, spring = h * actuator.damping / inertia, h * h * actuator.stiffness / inertia
        severity = "error" if servo_is_explicit else ""
        if share > UNSTABLE:
            detail = _sentence(h, share, "kv", inertia, 0.0)
            yield Offence(f"actuator {actuator.name}", f"kv {actuator.damping:g} N m s", detail, severity)
        elif spring > SPRING:
            detail = f"h² kp / I = {spring:.3g} > {SPRING:g} with h {h:g} s and I {inertia:.3g} kg m²"
            yield Offence(f"actuator {actuator.name}", f"kp {actuator.stiffness:g} N m", detail, severity)


def _sentence(h: float, share: float, gain: str, inertia: float, armature: float) -> str:
    rotor = f" (armature {armature:g})" if armature > 0.0 else ""
    ratio = f"h {gain} / (I + armature) = {share:.3g} > {UNSTABLE:g}"
    return f"{ratio} with h {h:g} s and {inertia:.3g} kg m²{rotor}"


def _armatures(subject: Subject) -> Iterator[Offence]:
    whole = subject.facts.mass * subject.reach**2
    for joint in subject.facts.joints:
        if joint.armature < 0.0:
            yield Offence(f"joint {joint.name}", f"armature {joint.armature:g}", "no rotor has it", "error")
        elif joint.kind == "revolute" and joint.armature > whole > 0.0:
            detail = f"more than the whole robot about it, {whole:.3g} kg m²"
            yield Offence(f"joint {joint.name}", f"armature {joint.armature:g} kg m²", detail)


def _inertialess(subject: Subject) -> Iterator[Offence]:
    for name, inertia in _inertias(subject).items():
        if inertia < LEAST:  # never where a mass is missing: that has a rule of its own, and no number here
            severity = "error" if name in subject.leg_joints else ""
            detail = f"below {LEAST:g} kg m² a simulated world refuses the robot"
            yield Offence(f"joint {name}", f"inertia {inertia:.3g} kg m²", detail, severity)


def _long_steps(subject: Subject) -> Iterator[Offence]:
    compiled: Any = subject.compiled
    if compiled is None:
        return
    step = float(compiled.opt.timestep)
    if step > 0.01:
        yield Offence(
            "option timestep",
            f"{step:g} s",
            "feet strike deeper than they are round; walks here take 0.001 s",
        )
    gravity = np.array(compiled.opt.gravity)
    if not (abs(gravity[0]) + abs(gravity[1]) < 1e-3 and -20.0 < gravity[2] < -1.0):
        value = "(" + ", ".join(f"{x:g}" for x in gravity) + ") m/s²"
        yield Offence("option gravity", value, "verdicts count (0, 0, -9.81)")


STEP_RULES = (
    Rule(
        "step-unstable",
        "damping and gains against inertia, h d / (I + armature)",
        "warning",
        "Lower the gain, add the rotor's armature, or take integrator implicitfast.",
        _unstable_damping,
    ),
    Rule(
        "armature-absurd",
        "armature of joints",
        "warning",
        "Rotor inertia times gear ratio squared.",
        _armatures,
    ),
    Rule(
        "joint-moves-nothing",
        "inertia that each joint feels",
        "warning",
        "Give the links behind it their masses and inertias.",
        _inertialess,
    ),
    Rule("world-unusual", "time step and gravity of an MJCF", "warning", "Set <option>.", _long_steps),
)
"""The family."""
