"""The contact points of a robot's feet, as one value: spheres, what carries them, what moves them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, IntArray
from surefoot.mechanics.robot.foot import Foot


@dataclass(frozen=True, eq=False)
class ContactPoints:
    """The p contact spheres of n feet, in the order of the feet; arrays are shared, so write to none.

    Attributes
    ----------
    names
        (p,) "FOOT:k", k counting the spheres of a foot.
    foot
        (p,) index of each sphere's foot.
    centres
        (p, 3) sphere centres in the frame of their foot [m].
    radii
        (p,) [m].
    joints
        (p,) Pinocchio's index of the joint that carries each sphere.
    places
        (p, 3) sphere centres in the frame of that joint [m].
    frames
        (n,) Pinocchio's index of each foot's frame.
    middles
        (n, 3) centre of each foot's contact in the foot's frame [m], see `Foot.centre`.
    foot_radii
        (n,) [m].
    flat
        (n,) which feet have a sole.
    foot_support
        (n, nv) which velocity components move each foot.

    Examples
    --------
    >>> from surefoot.mechanics.robot import load_robot
    >>> points = load_robot("go2").contact_points
    >>> points.names[1], points.foot, points.foot_support[1].sum()
    ('FR_foot:0', array([0, 1, 2, 3]), np.int64(9))
    """

    names: tuple[str, ...]
    foot: IntArray
    centres: FloatArray
    radii: FloatArray
    joints: IntArray
    places: FloatArray
    frames: tuple[int, ...]
    middles: FloatArray
    foot_radii: FloatArray
    flat: BoolArray
    foot_support: BoolArray

    def __len__(self) -> int:
        return len(self.foot)

    @cached_property
    def support(self) -> BoolArray:
        """(p, nv) which velocity components move each point."""
        return np.asarray(self.foot_support[self.foot])


def joint_support(model: Any) -> BoolArray:
    """Return which velocities move what hangs on each joint: (njoints, nv)."""
    out = np.zeros((model.njoints, model.nv), dtype=np.bool_)
    for joint in range(1, model.njoints):
        first = model.joints[joint].idx_v
        out[joint] = out[int(model.parents[joint])]
        out[joint, first : first + model.joints[joint].nv] = True
    return out


def contact_points(model: Any, feet: Sequence[Foot]) -> ContactPoints:
    """Return the contact points of feet on a Pinocchio model."""
    spheres = [(k, foot, centre) for k, foot in enumerate(feet) for centre in foot.centres]
    frames = [model.frames[foot.frame] for foot in feet]
    owner = np.array([k for k, _, _ in spheres], dtype=np.int64)
    radii = np.array([foot.radius for foot in feet], dtype=np.float64)
    joints = np.array([int(frame.parentJoint) for frame in frames], dtype=np.int64)
    return ContactPoints(
        tuple(f"{foot.name}:{j}" for foot in feet for j in range(len(foot.centres))),
        owner,
        np.array([centre for _, _, centre in spheres], dtype=np.float64).reshape(-1, 3),
        radii[owner],
        joints[owner],
        np.array([frames[k].placement.act(c) for k, _, c in spheres], dtype=np.float64).reshape(-1, 3),
        tuple(foot.frame for foot in feet),
        np.array([foot.centre for foot in feet], dtype=np.float64).reshape(-1, 3),
        radii,
        np.array([foot.flat for foot in feet], dtype=np.bool_),
        joint_support(model)[joints],
    )
