"""Contact detection of a whole geometry: feet, what else lies on the ground, solids that touch each other."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.collision import Geometry, PairSearch, ground_solids
from surefoot.numerics.points import relative_jacobian
from surefoot.robot import Foot, Robot
from surefoot.robot.contact_points import contact_points, joint_support
from surefoot.stepping.detection import Contacts, Surfaces, TerrainDetection
from surefoot.terrain import Terrain
from surefoot.terrain.frames import surface_frames

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
    group
        (p,) index of what the contacts belong to: a foot, a solid, a pair.
    names
        Names of the two sides of each group; the ground's is "ground".
    """

    def __init__(self, model: Any, robot: Robot, geometry: Geometry, terrain: Terrain, dt: float) -> None:
        pieces = ground_solids(terrain)
        self._geometry = replace(geometry, solids=geometry.solids + (pieces or ()))
        feet = list(robot.feet)
        surfaces: list[tuple[float | None, ...]] = [(None,) * 4 for _ in feet]
        self.names = [(foot.name, "ground") for foot in feet]
        for solid in geometry.solids if pieces is None else ():
            if solid.joint == 0 or not solid.on_ground:
                continue
            frame = model.addFrame(_frame(solid.name, solid.joint))
            knots = solid.shape.knots(2 if terrain.planar else SAMPLES) @ solid.rotation.T + solid.position
            feet.append(Foot(solid.name, int(frame), knots, solid.shape.radius))
            self.names.append((solid.name, "ground"))
            surfaces.append((solid.friction, solid.restitution, None, None))
        self._knots = contact_points(model, feet)
        self._points = len(self._knots)
        self._pairs = PairSearch(self._geometry, MARGIN + 2.0 * FASTEST_APPROACH * dt)
        self._surfaces, self._known = surfaces, (np.nan, np.nan)
        self._mixed = np.zeros((2, 0))
        self._grow()
        self._look(model, terrain)

    def _look(self, model: Any, terrain: Terrain) -> None:
        """Make what finds the ground, and work arrays."""
        self._ground = TerrainDetection(model, self._knots, terrain)
        self.data, self._support = self._ground.data, joint_support(model)
        self._J = np.zeros((0, model.nv))

    def _grow(self) -> None:
        """Name the sides of pairs that came near, and their surfaces; other contacts stay where they are."""
        solids, points = self._geometry.solids, self._knots
        for a, b in self._pairs.pairs[len(self.names) - len(points.frames) :].tolist():
            one, two = solids[b], solids[a]
            self.names.append((one.name, two.name))
            self._surfaces.append((one.friction, one.restitution, two.friction, two.restitution))
        self.group = np.concatenate([points.foot, len(points.frames) + self._pairs.pair])
        self._frames = np.zeros((len(self.group), 3, 3))

    def at(self, q: FloatArray) -> Contacts:
        """Return the contacts at (nq,) q [m, -, rad], as `TerrainDetection.at` does."""
        ground, p = self._ground.at(q), self._points
        pairs = self._pairs
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
        pairs = self._pairs
        if len(self.group) != self._points + len(pairs.gaps):
            self._grow()
        self._frames[: self._points] = frames
        surface_frames(pairs.normals, self._frames[self._points :])
        return np.concatenate([gaps, pairs.gaps]), np.concatenate([positions, pairs.points]), self._frames

    def twists(self, q: FloatArray) -> FloatArray:
        """Return the spatial Jacobian (6, nv) at q, see `TerrainDetection.twists`."""
        return self._ground.twists(q)

    def surfaces(self, mu: float, restitution: float) -> Surfaces:
        """Return the coefficients of all contacts on ground of friction `mu` and `restitution`."""
        if self._known != (mu, restitution):
            self._known, self._mixed = (mu, restitution), np.zeros((2, 0))
        mixed, fresh = self._geometry.mixed, self._surfaces[self._mixed.shape[1] :]
        if fresh:
            friction = [mixed(mu_a, mu_b, mu) for mu_a, _, mu_b, _ in fresh]
            bounce = [min(mixed(e_a, e_b, restitution), 1.0) for _, e_a, _, e_b in fresh]
            self._mixed = np.hstack([self._mixed, [friction, bounce]])
        on = np.ones(len(self.group), dtype=np.bool_)
        on[self._points :] = self._pairs.on
        friction, bounce = self._mixed[:, self.group]
        return Surfaces(friction, bounce, on)


def _frame(name: str, joint: int) -> Any:
    """Return a frame at a joint."""
    import pinocchio

    return pinocchio.Frame(f"solid:{name}", joint, pinocchio.SE3.Identity(), pinocchio.FrameType.OP_FRAME)
