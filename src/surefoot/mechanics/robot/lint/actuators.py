"""Rules on actuators: those without joints, joints without them, and ranges that give nothing."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

from surefoot.mechanics.robot.lint.finding import Offence, Rule
from surefoot.mechanics.robot.lint.subject import Subject

PLANAR = 3
"""Joints without motors between the world and the first body that stand for a free base, at least [-]."""


def _jointless(subject: Subject) -> Iterator[Offence]:
    names = {joint.name for joint in subject.facts.joints}
    severity = "error" if subject.facts.format == "mjcf" else "warning"
    for actuator in subject.facts.actuators:
        if actuator.on_joint and actuator.joint not in names:
            value = f"joint {actuator.joint or '(none)'}"
            yield Offence(f"actuator {actuator.name}", value, "the file has no such joint", severity)


def _unmoved_joints(subject: Subject) -> Iterator[Offence]:
    facts = subject.facts
    if facts.format != "mjcf" or not facts.actuators:
        return
    driven = {actuator.joint for actuator in facts.actuators}
    unmoved = [joint for joint in facts.joints if joint.moves and joint.name not in driven]
    of_base = [joint for joint in unmoved if joint.parent == "world"]
    if len(of_base) >= PLANAR:
        named = ", ".join(joint.name for joint in of_base)
        severity = "error" if {joint.name for joint in of_base} & set(subject.leg_joints) else ""
        detail = f"{named} stand for a free base, and are none here: the base counts as bolted down"
        yield Offence(
            f"link {of_base[0].child}", f"{len(of_base)} joints without actuators", detail, severity
        )
    for joint in unmoved:
        if joint not in of_base or len(of_base) < PLANAR:
            severity = "error" if joint.name in subject.leg_joints else ""
            yield Offence(
                f"joint {joint.name}", "no actuator", "controllers take it as a motor without limit", severity
            )


def _shared_joints(subject: Subject) -> Iterator[Offence]:
    for joint, count in Counter(a.joint for a in subject.facts.actuators if a.on_joint).items():
        if count > 1 and subject.facts.format == "mjcf":
            yield Offence(f"joint {joint}", f"{count} actuators", "their torques add up")


def _useless(subject: Subject) -> Iterator[Offence]:
    if subject.facts.format != "mjcf":
        return
    for actuator in subject.facts.actuators:
        place = f"actuator {actuator.name}"
        if actuator.on_joint and actuator.gear == 0.0:
            yield Offence(place, "gear 0", "it moves nothing")
        for name, ends in (("forcerange", actuator.force), ("ctrlrange", actuator.command)):
            if ends is not None and not ends[0] < ends[1]:
                yield Offence(place, f"{name} {ends[0]:g} to {ends[1]:g}", "no value is within it")


ACTUATOR_RULES = (
    Rule(
        "actuator-without-joint",
        "joints that actuators name",
        "error",
        "Name a joint of the file.",
        _jointless,
    ),
    Rule(
        "joint-without-actuator",
        "joints of an MJCF that has actuators",
        "warning",
        "Add an actuator, or make the joint a weld; joints in place of a free base are a <freejoint/>.",
        _unmoved_joints,
    ),
    Rule(
        "actuators-share-joint",
        "joints that actuators name",
        "note",
        "Keep one, if they are one motor.",
        _shared_joints,
    ),
    Rule(
        "actuator-useless", "gears and ranges of actuators", "error", "Give it a gear and a range.", _useless
    ),
)
"""The family."""
