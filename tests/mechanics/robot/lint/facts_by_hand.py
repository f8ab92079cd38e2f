"""Facts of robots that no file has to be written for: links, joints and shapes with the numbers of a test."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from surefoot.mechanics.robot.lint.facts import (
    ActuatorFacts,
    JointFacts,
    LinkFacts,
    ModelFacts,
    ShapeFacts,
)
from surefoot.mechanics.robot.lint.rules import RULES
from surefoot.mechanics.robot.lint.subject import Subject


def joint(name: str, kind: str = "revolute", length: float = 0.1, **other: Any) -> JointFacts:
    """Return a joint without a fault, `length` [m] above its parent, but for the fields given."""
    fields: dict[str, Any] = {
        "parent": "trunk", "child": f"{name}_link", "origin": np.array([0.0, 0.0, length]),
        "lower": -1.0, "upper": 1.0, "effort": 10.0, "speed": 5.0, "limited": True,
    }  # fmt: skip
    return JointFacts(name, kind, **(fields | other))


def link(
    name: str, mass: float = 1.0, moments: Sequence[float] = (0.01, 0.01, 0.01), **other: Any
) -> LinkFacts:
    """Return a link of a mass [kg] with principal moments [kg m²]."""
    return LinkFacts(name, mass, inertia=np.diag(moments), **({"inertial": True} | other))


def subject(
    joints: Sequence[JointFacts] = (),
    links: Sequence[LinkFacts] = (),
    *,
    format: str = "urdf",
    shapes: Sequence[ShapeFacts] = (),
    actuators: Sequence[ActuatorFacts] = (),
    legs: Sequence[str] = (),
    **other: Any,
) -> Subject:
    """Return a model of parts, of which some joints move legs."""
    facts = ModelFacts(
        Path(f"dog.{format}"), format, list(links), list(joints), list(shapes), list(actuators)
    )
    out = Subject(facts, **other)
    vars(out)["leg_joints"] = frozenset(legs)
    return out


def offences(rule: str, about: Subject) -> list[tuple[str, str, str, str]]:
    """Return place, value, detail and severity of what a rule finds."""
    (check,) = [one.check for one in RULES if one.name == rule]
    return [tuple(one) for one in check(about)]


def places(rule: str, about: Subject) -> list[str]:
    """Return the places of what a rule finds."""
    return [place for place, *_ in offences(rule, about)]
