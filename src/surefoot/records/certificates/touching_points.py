"""The points of a robot that may touch the ground: ends of its collision shapes, as spheres on its joints."""

from __future__ import annotations

from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, IntArray, per_contact
from surefoot.base.errors import ProblemError
from surefoot.mechanics import Robot, Solid, robot_geometry


@dataclass(frozen=True, eq=False)
class TouchingPoints:
    """The p spheres whose hulls are a robot's collision shapes; feet first.

    Attributes
    ----------
    names
        (p,) link or foot of each, with a number.
    links
        (p,) link or foot of each.
    foot
        (p,) index of its foot, -1 for other parts.
    joints
        (p,) Pinocchio's index of the joint that carries it.
    places
        (p, 3) centres in the frame of that joint [m].
    radii
        (p,) [m].
    mu
        (p,) friction of what sticks [-].
    """

    names: tuple[str, ...]
    links: tuple[str, ...]
    foot: IntArray
    joints: IntArray
    places: FloatArray
    radii: FloatArray
    mu: FloatArray

    def __len__(self) -> int:
        return len(self.joints)


_KNOWN: WeakKeyDictionary[Robot, tuple[Solid, ...]] = WeakKeyDictionary()
"""Shapes of robots that were asked about: fitting them to meshes takes longer than a short motion."""


def _solids(robot: Robot) -> tuple[Solid, ...]:
    """Return the shapes of a robot that may touch the ground beside its feet."""
    if robot not in _KNOWN:
        every = robot_geometry(robot).solids
        _KNOWN[robot] = tuple(solid for solid in every if solid.on_ground and solid.joint > 0)
    return _KNOWN[robot]


def touching_points(robot: Robot, mu: ArrayLike) -> TouchingPoints:
    """Return the points of a robot that may touch the ground.

    Soles and point feet by their own spheres, hands, knees and trunk by the knots of the shapes of
    `robot_geometry`.

    Parameters
    ----------
    robot
        Any with a floating base.
    mu
        Friction of what sticks, a number or one a foot, (n,) [-]; other parts have the largest.

    Raises
    ------
    ProblemError
        For friction that is negative, not finite, or not one a foot.
    """
    feet = robot.contact_points
    friction = per_contact("mu", mu, max(len(robot.feet), 1))
    if not np.isfinite(friction).all():
        raise ProblemError("mu must be finite")
    largest = float(friction.max(initial=0.0))
    links = [name.rsplit(":", 1)[0] for name in feet.names]
    joints, places, radii = [feet.joints], [feet.places], [feet.radii]
    for solid in _solids(robot):
        knots = solid.shape.knots() @ solid.rotation.T + solid.position
        links += [solid.name] * len(knots)
        joints.append(np.full(len(knots), solid.joint))
        places.append(knots)
        radii.append(np.full(len(knots), solid.shape.radius))
    rest = len(links) - len(feet)
    counted: dict[str, int] = {}
    names = []
    for link in links:
        names.append(f"{link}:{counted.setdefault(link, 0)}")
        counted[link] += 1
    return TouchingPoints(
        tuple(names),
        tuple(links),
        np.concatenate([feet.foot, np.full(rest, -1)]).astype(np.int64),
        np.concatenate(joints).astype(np.int64),
        np.ascontiguousarray(np.concatenate(places), dtype=np.float64).reshape(-1, 3),
        np.concatenate(radii).astype(np.float64),
        np.concatenate([friction[feet.foot] if len(feet) else np.empty(0), np.full(rest, largest)]),
    )
