"""Contact detection of a whole geometry: feet, what else lies on the ground, solids that touch each other."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.numerics.points import relative_jacobian
from surefoot.mechanics.collision import Geometry, PairSearch, ground_solids
from surefoot.mechanics.dynamics.detection import Contacts, Surfaces, TerrainDetection, add_frame
from surefoot.mechanics.robot import Foot, Robot
from surefoot.mechanics.robot.contact_points import contact_points, joint_support
from surefoot.mechanics.terrain import Terrain
from surefoot.mechanics.terrain.frames import surface_frames

MARGIN, FASTEST_APPROACH = 0.02, 30.0
"""Solids are looked at from this distance [m], and what they come closer in two steps at this speed [m/s]."""
SAMPLES = 5
"""Places along a capsule that see curved ground; a plane touches its ends."""


class PairDetection:
    """Finds all contacts of a geometry; used in the place of `TerrainDetection`.

    The contacts are the robot's feet, then the other solids' knots on the ground, then the slots of all
    pairs. On ground that is made of boxes solids other than feet touch those, edges and vertical faces too.

    Parameters
    ----------
    model
        A Pinocchio Model of one's own.
    robot
        Whose feet come first.
    geometry
        What touches.
    terrain
        What it stands on.
    dt
        Length of a step [s].

    Attributes
    ----------
    data
        Pinocchio's.
    points, pairs
        The spheres that touch the ground, and the search for pairs.
    group
        (p,) index of what the contacts belong to: a foot, a solid, a pair.
    names
        Names of the two sides of each group; the ground's is "ground".
    """

    def __init__(self, model: Any, robot: Robot, geometry: Geometry, terrain: Terrain, dt: float) -> None:
        pieces = ground_solids(terrain)
        self._geometry = replace(geometry, solids=geometry.solids + (pieces or ()))
        feet = list(robot.feet)
        self.names = [(foot.name, "ground") for foot in feet]
        self._sides = [(-1, -1) for _ in feet]
        for k, solid in enumerate(geometry.solids if pieces is None else ()):
            if solid.joint == 0 or not solid.on_ground:
                continue
            frame = add_frame(model, f"solid:{solid.name}", solid.joint, np.zeros(3))
            knots = solid.shape.knots(2 if terrain.planar else SAMPLES) @ solid.rotation.T + solid.position
            feet.append(Foot(solid.name, frame, knots, solid.shape.radius))
            self.names.append((solid.name, "ground"))
            self._sides.append((k, -1))
        self.points = contact_points(model, feet)
        self.pairs = PairSearch(self._geometry, MARGIN + 2.0 * FASTEST_APPROACH * dt)
        self._known, self._mixed = (np.nan, np.nan), np.zeros((2, 0))
        self._surfaces = np.zeros((2, 0))
        self._grow()
        self._look(model, terrain)

    def _look(self, model: Any, terrain: Terrain) -> None:
        """Make what finds the ground, and work arrays."""
        self._ground = TerrainDetection(model, self.points, terrain)
        self.data, self._support = self._ground.data, joint_support(model)
        self._J = np.zeros((0, model.nv))

    def _grow(self) -> None:
        """Name the sides of pairs that came near, and their surfaces; other contacts stay where they are."""
        solids, points = self._geometry.solids, self.points
        for a, b in self.pairs.pairs[len(self.names) - len(points.frames) :].tolist():
            self.names.append((solids[b].name, solids[a].name))
            self._sides.append((b, a))
        self.group = np.concatenate([points.foot, len(points.frames) + self.pairs.pair])
        self._frames = np.zeros((len(self.group), 3, 3))

    def at(self, q: FloatArray) -> Contacts:
        """Return the contacts at (nq,) q [m, -, rad], as `TerrainDetection.at` does."""
        ground, p = self._ground.at(q), len(self.points)
        pairs = self.pairs
        pairs.update(self.data.oMi)
        gaps, positions, frames = self._together(ground.gaps, ground.positions, ground.frames)
        if len(self._J) != 3 * len(gaps):
            self._J = np.zeros((3 * len(gaps), self._J.shape[1]))
        self._J[: 3 * p] = ground.J
        relative_jacobian(
            self.data.J, self._support, pairs.first, pairs.second, pairs.points, frames[p:], pairs.on,
            self._J[3 * p :],
        )  # fmt: skip
        return Contacts(gaps, positions, frames, self._J)

    def _together(
        self, gaps: FloatArray, positions: FloatArray, frames: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return gaps, positions and frames of contacts with the ground, and of pairs behind them."""
        pairs = self.pairs
        if len(self.group) != len(self.points) + len(pairs.gaps):
            self._grow()
        self._frames[: len(self.points)] = frames
        surface_frames(pairs.normals, self._frames[len(self.points) :])
        return np.concatenate([gaps, pairs.gaps]), np.concatenate([positions, pairs.points]), self._frames

    def twists(self, q: FloatArray) -> FloatArray:
        """Return the spatial Jacobian (6, nv) at q, see `TerrainDetection.twists`."""
        return self._ground.twists(q)

    def mixed(self, geometry: Geometry, mu: float, restitution: float, first: int = 0) -> FloatArray:
        """Return friction and restitution (2, groups), of a geometry like its own with other surfaces.

        Of the groups from `first` on.
        """
        own = [(s.friction, s.restitution) for s in geometry.solids]
        own += [(None, None)] * (len(self._geometry.solids) - len(own) + 1)  # of the ground: the last one
        out = np.array([
            [geometry.mixed(own[a][k], own[b][k], ground) for a, b in self._sides[first:]]
            for k, ground in enumerate((mu, restitution))
        ]).reshape(2, -1)  # fmt: skip
        out[1] = np.minimum(out[1], 1.0)
        return out

    def surfaces(self, mu: float, restitution: float) -> Surfaces:
        """Return the coefficients of all contacts on ground of friction `mu` and `restitution`."""
        if self._known != (mu, restitution):
            self._known, self._mixed, self._surfaces = (mu, restitution), np.zeros((2, 0)), np.zeros((2, 0))
        if self._surfaces.shape[1] != len(self.group):  # of many solids pairs come by and by
            fresh = self.mixed(self._geometry, mu, restitution, self._mixed.shape[1])
            self._mixed = np.concatenate([self._mixed, fresh], axis=1)
            self._surfaces = self._mixed[:, self.group]
        on = np.ones(len(self.group), dtype=np.bool_)
        on[len(self.points) :] = self.pairs.on
        return Surfaces(self._surfaces[0], self._surfaces[1], on)
