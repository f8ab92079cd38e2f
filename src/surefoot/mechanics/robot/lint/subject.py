"""What the rules of the lint look at: the file's facts, and what was built of them, as far as it could be."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from statistics import median
from typing import Any, TypeVar

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.mechanics.robot.lint.facts import JointFacts, LinkFacts, ModelFacts

OUTLIER = 30.0
"""Length over the median of a robot's joint offsets that is a slip of units [-]."""
Part = TypeVar("Part", LinkFacts, JointFacts)


@dataclass(eq=False)
class Subject:
    """A robot's model under the lint.

    Attributes
    ----------
    facts
        What its file says.
    robot
        The loaded Robot; None where it does not load.
    refusal
        Why it does not load; empty where it does.
    ends
        Frames at the ends of its limbs, for who has yet to name feet.
    described
        Whether its feet's shapes come from the catalogue, not from its file.
    compiled, mujoco
        MuJoCo's model of an MJCF file and the module; None for a URDF file.
    sinking
        How deep it sinks where it stands, see `softness.find_sinking`; None where that is not known.
    """

    facts: ModelFacts
    robot: Any = None
    refusal: str = ""
    ends: Sequence[str] = ()
    described: bool = False
    compiled: Any = None
    mujoco: Any = field(default=None, repr=False)
    sinking: Any = None

    @cached_property
    def leg_joints(self) -> frozenset[str]:
        """Names of the joints that move a foot; none without feet."""
        if self.robot is None or not self.robot.feet:
            return frozenset()
        moved = self.robot.contact_points.foot_support.any(axis=0)
        model = self.robot.model
        return frozenset(
            str(name)
            for name, joint in zip(list(model.names)[1:], list(model.joints)[1:], strict=True)
            if joint.nv == 1 and moved[joint.idx_v]
        )

    @cached_property
    def reach(self) -> float:
        """Length of the longest chain of joint offsets [m], the outermost link's centre of mass included.

        A length that is `OUTLIER` times the usual one counts as the usual one: a slip must not hide others.
        """
        above = {joint.child: joint for joint in self.facts.joints}
        lengths = [size for joint in self.facts.joints if (size := _length(joint.origin)) > 0.0]
        lengths = lengths or [size for link in self.facts.links if (size := _length(link.com)) > 0.0]
        usual = median(lengths) if lengths else 0.0
        ends = {link.name: self._bounded_length(link.com, usual) for link in self.facts.links}
        return max((self._way(name, above, usual) + end for name, end in ends.items()), default=0.0)

    def _way(self, name: str, above: dict[str, JointFacts], usual: float) -> float:
        total, met = 0.0, set[str]()
        while name in above and name not in met:
            met.add(name)
            total += self._bounded_length(above[name].origin, usual)
            name = above[name].parent
        return total

    def _bounded_length(self, vector: FloatArray, usual: float) -> float:
        own = _length(vector)
        return usual if own > OUTLIER * usual else own

    def extent(self, link: str) -> float:
        """Return how far a link's own parts lie from its origin [m]: centre of mass and joints on it."""
        own = [joint for joint in self.facts.joints if joint.parent == link]
        further = [_length(joint.origin) for joint in own]
        return max([*further, self.shape_reach.get(link, 0.0)], default=0.0)

    @cached_property
    def shape_reach(self) -> dict[str, float]:
        """Largest size of the shapes of each link that has any but meshes [m]."""
        out: dict[str, float] = {}
        for shape in self.facts.shapes:
            if shape.kind != "mesh" and np.isfinite(shape.size).all():
                out[shape.link] = max(out.get(shape.link, 0.0), *shape.size)
        return out


def kin_of(
    parts: Sequence[Part], key: Callable[[str], str | None], value: Callable[[Part], float]
) -> Iterator[tuple[Part, float, list[Part]]]:
    """Yield each part that has kin with the median of its kin's values, and its kin.

    Of two the outlier cannot be told by themselves: both are yielded, each measured by the other.
    """
    groups: dict[str, list[Part]] = {}
    for part in parts:
        name = key(part.name)
        if name is not None:
            groups.setdefault(name, []).append(part)
    for group in groups.values():
        for part in group:
            others = [other for other in group if other is not part]
            if others:
                yield part, median(value(other) for other in others), others


def _length(vector: FloatArray) -> float:
    return float(np.linalg.norm(vector)) if np.isfinite(vector).all() else 0.0
