"""Hinges that give: what hangs on a hinge turns a little about the two axes across it, too.

A pin in its bearing and the parts that carry it bend: the moment across a hinge turns what hangs on it by so
many radians a newton metre, its compliance, against a spring and a damper (Kelvin and Voigt). An impact is
over before they give way, so that the ground meets one link with little of the others behind it, where a
rigid hinge would have it meet them all.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.spatial import rotation_from_normal
from surefoot.records.identification.thrown_body_tree import FallingBody

RELAXES = 1e-3
"""Damping of a hinge that gives, over its stiffness [s]: throws hardly tell it."""


class BentBody(NamedTuple):
    """A tree whose joints give, and (7 + joints,) the coordinates of it that a rigid one has."""

    tree: FallingBody
    columns: IntArray

    def joints(self, link: int) -> range:
        """Return the joints of the tree that a link of the rigid one hangs on, from its parent on."""
        first = np.append(self.columns[7:], 6 + self.tree.masses.size) - 6
        return range(int(first[link - 1]), int(first[link]))

    def widen(self, starts: FloatArray) -> FloatArray:
        """Return states (B, nq + nv) of the rigid tree as such of this one, straight and at rest across."""
        nq, wide = self.columns.size, 6 + self.tree.masses.size
        rates = wide + np.append(np.arange(6), self.columns[7:] - 1)
        out = np.zeros((len(starts), 2 * wide - 1))
        out[:, self.columns], out[:, rates] = starts[:, :nq], starts[:, nq:]
        return out


def bend(tree: FallingBody, compliance: FloatArray) -> BentBody:
    """Return a tree with two more hinges behind each joint that gives.

    They follow it, and the links between carry nothing.

    Parameters
    ----------
    tree
        n links, whose joints no spring holds.
    compliance
        (n,) of what each link hangs on [rad/(N m)]; 0 for what is rigid.
    """
    gives = compliance > 0.0
    if not gives.any():
        return BentBody(tree, np.arange(6 + tree.masses.size))
    copies = np.where(gives, 3, 1)
    own, last = np.repeat(np.arange(len(copies)), copies), np.cumsum(copies) - 1
    first = last - copies + 1
    joint, link = np.zeros(len(own), dtype=bool), np.zeros(len(own), dtype=bool)
    joint[first], link[last] = True, True
    parents = np.arange(-1, len(own) - 1)
    parents[first[1:]] = last[tree.parents[1:]]
    axes, stiffness, damping = tree.axes[own], np.zeros(len(own)), np.where(joint, tree.damping[own], 0.0)
    for i in np.flatnonzero(gives):
        more = slice(first[i] + 1, last[i] + 1)
        axes[more] = rotation_from_normal(tree.axes[i]).T[1::-1]
        stiffness[more], damping[more] = 1.0 / compliance[i], RELAXES / compliance[i]
    bent = FallingBody(
        parents, np.where(joint[:, None, None], tree.turns[own], np.eye(3)),
        np.where(joint[:, None], tree.places[own], 0.0), axes, tree.sliding[own] & joint,
        np.where(link, tree.masses[own], 0.0), np.where(link[:, None], tree.centres[own], 0.0),
        np.where(link[:, None, None], tree.inertias[own], 0.0), np.where(joint, tree.friction[own], 0.0),
        damping, stiffness, last[tree.links], tree.points, tree.radii,
    )  # fmt: skip
    return BentBody(bent, np.append(np.arange(7), 6 + first[1:]))
