"""What a robot's file says, before anything has built a robot of it: links, joints, shapes, actuators.

The lint reads these facts, so that a file that no engine would load can still be judged. Both readers,
`urdf_facts` and `mjcf_facts`, fill them; a number that the file leaves out is NaN.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import FloatArray

MOVING = ("revolute", "continuous", "prismatic")
"""Kinds of joints that the robot moves by itself."""
_WORDS = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+")
_SIDES = {
    **dict.fromkeys(("left", "l", "right", "r"), "*"),
    **{f"{side}{end}": f"{end}*" for side in "lr" for end in "fhbr"},
    **{f"{end}{side}": f"{end}*" for side in "lr" for end in "fhb"},
    "rl": "r*", "rr": "r*",
}  # fmt: skip
"""Words of names that say left or right, and what both sides share."""
_ENDS = {"f*": "*", "h*": "*", "b*": "*", "r*": "*", "front": "*", "rear": "*", "hind": "*", "back": "*"}


class Fault(NamedTuple):
    """Something wrong that a reader met: the rule that it breaks, where, and the value."""

    rule: str
    place: str
    value: str
    detail: str = ""


@dataclass
class LinkFacts:
    """A link: mass [kg], centre of mass (3,) [m] and inertia (3, 3) about it, in the link's axes [kg m²].

    `inertial` is false where the file gives none, and `derived` true where its mass comes from shapes.
    """

    name: str
    mass: float = 0.0
    com: FloatArray = field(default_factory=lambda: np.zeros(3))
    inertia: FloatArray = field(default_factory=lambda: np.zeros((3, 3)))
    inertial: bool = False


@dataclass
class ShapeFacts:
    """A shape of a link: kind, sizes [m], and of a mesh its file as written and where that was found."""

    link: str
    kind: str
    size: tuple[float, ...]
    collides: bool
    text: str = ""
    file: Path | None = None


@dataclass
class JointFacts:
    """A joint between two links, in SI units; `limited` tells whether the file gives a range."""

    name: str
    kind: str
    parent: str
    child: str
    origin: FloatArray = field(default_factory=lambda: np.zeros(3))
    axis: FloatArray = field(default_factory=lambda: np.array([1.0, 0.0, 0.0]))
    lower: float = math.nan
    upper: float = math.nan
    effort: float = math.nan
    speed: float = math.nan
    damping: float = 0.0
    armature: float = 0.0
    mimics: str = ""
    limited: bool = False

    @property
    def moves(self) -> bool:
        """Whether it is a hinge or a slide."""
        return self.kind in MOVING


@dataclass
class ActuatorFacts:
    """An actuator: the joint it is said to move, gear, and its ranges of force and command."""

    name: str
    joint: str
    gear: float = 1.0
    force: tuple[float, float] | None = None
    command: tuple[float, float] | None = None
    on_joint: bool = True
    stiffness: float = 0.0
    damping: float = 0.0


@dataclass
class ModelFacts:
    """All of a file.

    Attributes
    ----------
    path, format
        The file, and "urdf" or "mjcf".
    links, joints, shapes, actuators
        Its parts, in its order.
    faults
        What its reader could not make sense of.
    """

    path: Path
    format: str
    links: list[LinkFacts] = field(default_factory=list)
    joints: list[JointFacts] = field(default_factory=list)
    shapes: list[ShapeFacts] = field(default_factory=list)
    actuators: list[ActuatorFacts] = field(default_factory=list)
    faults: list[Fault] = field(default_factory=list)

    @property
    def mass(self) -> float:
        """Sum of the masses that are finite and positive [kg]."""
        return sum(link.mass for link in self.links if link.mass > 0.0 and math.isfinite(link.mass))

    @property
    def root(self) -> str:
        """The first link that is no joint's child; empty where there is none."""
        children = {joint.child for joint in self.joints}
        return next((link.name for link in self.links if link.name not in children), "")

    def groups(self) -> list[list[LinkFacts]]:
        """Return the links by rigid body: those that fixed joints weld are one, its root first."""
        up = {joint.child: joint.parent for joint in self.joints if joint.kind == "fixed"}
        by_root: dict[str, list[LinkFacts]] = {}
        for link in self.links:
            name, steps = link.name, 0
            while name in up and steps <= len(up):
                name, steps = up[name], steps + 1
            by_root.setdefault(name, []).append(link)
        heads = by_root.items()
        return [
            [link for k in (True, False) for link in group if (link.name == root) is k]
            for root, group in heads
        ]

    def below(self, name: str) -> Iterator[str]:
        """Yield a link and all links that hang on it, each once, also in a file with loops."""
        children: dict[str, list[str]] = {}
        for joint in self.joints:
            children.setdefault(joint.parent, []).append(joint.child)
        waiting, known = [name], set[str]()
        while waiting:
            link = waiting.pop()
            if link not in known:
                known.add(link)
                yield link
                waiting += children.get(link, [])


def side_twin(name: str) -> str | None:
    """Return what the names of a left and a right part share, None for a name without a side.

    >>> side_twin("left_hip_pitch_joint") == side_twin("right_hip_pitch_joint"), side_twin("base")
    (True, None)
    """
    words = [word.lower() for word in _WORDS.findall(name)]
    shared = [_SIDES.get(word, word) for word in words]
    return None if shared == words else "_".join(shared)


def limb_twin(name: str) -> str | None:
    """Return what the names of such parts of all limbs share: front and rear as well, and numbered ones.

    >>> limb_twin("FL_calf") == limb_twin("RR_calf")
    True
    """
    words = [word.lower() for word in _WORDS.findall(name)]
    shared = [_ENDS.get(_SIDES.get(word, word), _SIDES.get(word, word)) for word in words]
    return None if shared == words else "_".join(shared)
