"""Contact detection of a whole geometry: feet, what else lies on the ground, solids that touch each other."""

from __future__ import annotations

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
        self._geometry = geometry if pieces is None else geometry.with_ground(pieces)
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
        points = contact_points(model, feet)
        self._ground = TerrainDetection(model, points, terrain)
        self.data = self._ground.data
        self._pairs = PairSearch(self._geometry, MARGIN + 2.0 * FASTEST_APPROACH * dt)
        solids = self._geometry.solids
        self.names += [(solids[b].name, solids[a].name) for a, b in self._pairs.pairs.tolist()]
        surfaces += [
            (solids[b].friction, solids[b].restitution, solids[a].friction, solids[a].restitution)
            for a, b in self._pairs.pairs.tolist()
        ]
        self.group = np.concatenate([points.foot, len(feet) + self._pairs.pair])
        self._surfaces = surfaces
        self._coefficients: tuple[float, float, FloatArray, FloatArray] | None = None
        self._support = joint_support(model)
        n = len(self.group)
        self._points = len(points)
        self._frames, self._J = np.zeros((n, 3, 3)), np.zeros((3 * n, model.nv))

    def at(self, q: FloatArray) -> Contacts:
        """Return the contacts at (nq,) q [m, -, rad], as `TerrainDetection.at` does."""
        ground, p = self._ground.at(q), self._points
        gaps, positions = np.empty(len(self.group)), np.empty((len(self.group), 3))
        gaps[:p], positions[:p], self._frames[:p] = ground.gaps, ground.positions, ground.frames
        self._J[: 3 * p] = ground.J
        pairs = self._pairs
        pairs.update(self.data.oMi)
        gaps[p:], positions[p:] = pairs.gaps, pairs.points
        surface_frames(pairs.normals, self._frames[p:])
        relative_jacobian(
            self.data.J, self._support, pairs.first, pairs.second, pairs.points, self._frames[p:], pairs.on,
            self._J[3 * p :],
        )  # fmt: skip
        return Contacts(gaps, positions, self._frames, self._J)

    def twists(self, q: FloatArray) -> FloatArray:
        """Return the spatial Jacobian (6, nv) at q, see `TerrainDetection.twists`."""
        return self._ground.twists(q)

    def surfaces(self, mu: float, restitution: float) -> Surfaces:
        """Return the coefficients of all contacts on ground of friction `mu` and `restitution`."""
        known = self._coefficients
        if known is None or known[:2] != (mu, restitution):
            mixed = self._geometry.mixed
            feet = len(self._surfaces)
            friction, bounce = np.empty(feet), np.empty(feet)
            for k, (mu_a, e_a, mu_b, e_b) in enumerate(self._surfaces):
                friction[k] = mixed(mu_a, mu_b, mu)
                bounce[k] = min(mixed(e_a, e_b, restitution), 1.0)
            self._coefficients = known = mu, restitution, friction[self.group], bounce[self.group]
        on = np.ones(len(self.group), dtype=np.bool_)
        on[self._points :] = self._pairs.on
        return Surfaces(known[2], known[3], on, self._geometry.propagation)


def _frame(name: str, joint: int) -> Any:
    """Return a frame at a joint."""
    import pinocchio

    return pinocchio.Frame(f"solid:{name}", joint, pinocchio.SE3.Identity(), pinocchio.FrameType.OP_FRAME)
