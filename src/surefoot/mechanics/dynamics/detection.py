"""Contact detection: how far a robot's contact points are from the ground, and what moves them."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, IntArray
from surefoot.base.numerics.points import contact_jacobian
from surefoot.mechanics.dynamics import arithmetic
from surefoot.mechanics.robot import ContactPoints
from surefoot.mechanics.terrain import Terrain
from surefoot.mechanics.terrain.frames import surface_frames


class Contacts(NamedTuple):
    """The p contact points of a robot at a configuration.

    Attributes
    ----------
    gaps
        (p,) distances to the ground [m], negative in penetration.
    positions
        (p, 3) the spheres' points nearest to the ground, world axes [m].
    frames
        (p, 3, 3) rotation_world_contact below every sphere.
    J
        (3p, nv) map from v to the points' velocities, rows in contact axes.
    """

    gaps: FloatArray
    positions: FloatArray
    frames: FloatArray
    J: FloatArray

    def kept(self) -> Contacts:
        """Return the same in arrays of their own."""
        return Contacts(self.gaps.copy(), self.positions.copy(), self.frames.copy(), self.J.copy())

    def velocities(self, v: FloatArray) -> FloatArray:
        """Return the velocities (p, 3) of the points in contact axes for (nv,) v [m/s]."""
        return np.asarray((self.J @ v).reshape(-1, 3))

    def effort(self, forces: FloatArray) -> FloatArray:
        """Return the generalised forces (nv,) [N, N m] of (p, 3) forces in contact axes [N]."""
        return np.asarray(self.J.T @ forces.ravel())

    def near(self, v: FloatArray, free: FloatArray, dt: float, reach: float) -> IntArray:
        """Return the contacts that may touch within the step, see `arithmetic.near_ground`: (k,)."""
        return arithmetic.near_ground(self.J, v, free, self.gaps, dt, reach)

    def swerves(
        self, v: FloatArray, leaving: FloatArray, last: FloatArray, foot: IntArray, least: float
    ) -> tuple[FloatArray, FloatArray] | None:
        """Return velocities (p, 3) [m/s] before impulses and the guess of how they turn, see `arithmetic`."""
        return arithmetic.swerves(self.J, v, leaving, last, foot, self.frames, least)

    def assemble(
        self, L: FloatArray, v: FloatArray, free: FloatArray, gaps: FloatArray, near: IntArray, dt: float,
        pull: float, restitution: FloatArray | None = None, rest_speed: float = np.inf,
    ) -> tuple[Any, Any, FloatArray]:  # fmt: skip
        """Return rows (3k, nv), G [1/kg] and g [m/s] of the near contacts, see `arithmetic.assemble`.

        Without coefficients of restitution (p,) nothing bounces.
        """
        e = np.zeros(gaps.size) if restitution is None else restitution
        return arithmetic.assemble(self.J, L, v, free, gaps, near, dt, e, rest_speed, pull)

    def factor(self, rows: Any) -> Any:
        """Return the rows (3k, nv) whose square G is, as a matrix."""
        return rows

    def apply(self, L: FloatArray, rows: Any, impulses: FloatArray, free: FloatArray) -> FloatArray:
        """Return v⁺ (nv,) [m/s, rad/s] after (k, 3) impulses, see `arithmetic.apply_impulses`."""
        return arithmetic.apply_impulses(L, rows, impulses.ravel(), free)


class Surfaces(NamedTuple):
    """What the surfaces of the p contacts are, where they are not all alike.

    Attributes
    ----------
    friction, restitution
        (p,) of each contact.
    on
        (p,) whether there is anything near; unused slots of pairs are off.
    """

    friction: FloatArray
    restitution: FloatArray
    on: BoolArray


class GroundBelow:
    """The ground below spheres; one per thread, since it keeps its work arrays.

    A sphere on curved ground sees the tangent plane below its centre.

    Parameters
    ----------
    terrain
        What they stand on.
    radii
        (p,) of the spheres [m].

    Attributes
    ----------
    above
        (p,) a plane's distance from the origin plus the spheres' radii [m]; empty over curved ground.
    """

    def __init__(self, terrain: Terrain, radii: FloatArray) -> None:
        self._terrain, self._radii, n = terrain, radii[:, None], len(radii)
        self._frames = np.zeros((n, 3, 3))
        self._plane = terrain.frame([0.0, 0.0])[:, 2] if terrain.planar else None
        self.above = np.zeros(0)
        if terrain.planar:
            self._frames[:] = terrain.frame([0.0, 0.0])
            # a plane's distance from the origin, along its normal
            self.above = radii + float(terrain.height([0.0, 0.0])) * self._frames[:1, 2, 2]

    def below(self, centres: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the gaps (p,) [m] and frames (p, 3, 3) below spheres (p, 3) [m]; the latter a work array."""
        if self._plane is not None:
            return np.asarray(centres @ self._plane - self.above), self._frames
        gaps = np.asarray(self._terrain.gap(centres) - self._radii[:, 0])
        surface_frames(self._terrain.normal(centres[:, :2]), self._frames)
        return gaps, self._frames

    def nearest(self, centres: FloatArray) -> FloatArray:
        """Return the spheres' points (p, 3) nearest to the ground, as of the last `below` [m]."""
        return np.asarray(centres - self._radii * self._frames[:, :, 2])


class TerrainDetection(GroundBelow):
    """Finds the contacts of a robot on a terrain; one per thread, since it keeps its work arrays.

    Parameters
    ----------
    model
        A Pinocchio Model of one's own: it gets a frame for each contact point.
    points
        The robot's contact points.
    terrain
        What they stand on.

    Attributes
    ----------
    points
        As given.
    spheres
        Frames of the contact points in the model.
    data
        Pinocchio's.
    group
        (p,) index of the foot that each contact belongs to.
    names
        Names of the two sides of each foot's contacts; the ground's is "ground".
    """

    def __init__(self, model: Any, points: ContactPoints, terrain: Terrain) -> None:
        import pinocchio

        super().__init__(terrain, points.radii)
        self._model, self.points = model, points
        named = zip(points.names, points.joints.tolist(), points.places, strict=True)
        self.spheres = [add_frame(model, f"sphere:{name}", joint, place) for name, joint, place in named]
        self.data = model.createData()
        self._jacobians, self._placed = pinocchio.computeJointJacobians, pinocchio.updateFramePlacement
        self.group, n = points.foot, len(points)
        feet = dict(zip(points.foot.tolist(), points.names, strict=True))
        self.names = [(name.rpartition(":")[0], "ground") for _, name in sorted(feet.items())]
        self._support, self._own = points.support, np.arange(n)
        self._centres, self._J = np.zeros((n, 3)), np.zeros((3 * n, model.nv))

    def at(self, q: FloatArray) -> Contacts:
        """Return the contacts at (nq,) q [m, -, rad]; `frames`, `J` are work arrays until the next call."""
        model, data = self._model, self.data
        self._jacobians(model, data, q)
        centres = self._centres
        for k, sphere in enumerate(self.spheres):
            centres[k] = self._placed(model, data, sphere).translation
        gaps, _ = self.below(centres)
        positions = self.nearest(centres)
        contact_jacobian(data.J, self._support, self._own, positions, self._frames, self._J)
        return Contacts(gaps, positions, self._frames, self._J)

    def surfaces(self, mu: float, restitution: float) -> Surfaces | None:
        """Return nothing: all contacts are with the ground, whose surface is the same everywhere."""
        del mu, restitution
        return None

    def twists(self, q: FloatArray) -> FloatArray:
        """Return the spatial Jacobian (6, nv) [m, -] at q: every velocity's twist, world origin and axes."""
        return np.array(self._jacobians(self._model, self.data, q))


def add_frame(model: Any, name: str, joint: int, place: FloatArray) -> int:
    """Add a frame to a Pinocchio Model, at a (3,) place in a joint's axes [m]; return its number."""
    import pinocchio

    placed = pinocchio.SE3(np.eye(3), place)
    return int(model.addFrame(pinocchio.Frame(name, joint, placed, pinocchio.FrameType.OP_FRAME)))
