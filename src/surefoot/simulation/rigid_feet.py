"""The contact spheres of a robot's feet: frames of a model of the rigid world's own, over its ground."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from surefoot.arrays import BoolArray, FloatArray, IntArray
from surefoot.numerics.points import contact_jacobian
from surefoot.robot import Robot
from surefoot.simulation import rigid_step
from surefoot.stance import SlopeTerrain, Terrain


@dataclass(frozen=True)
class Spheres:
    """Contact spheres, in the order of the robot's feet.

    Attributes
    ----------
    foot
        (p,) index of each sphere's foot.
    frame
        Its frame in the model.
    radius
        (p,) [m].
    support
        (p, nv) which velocity components move it.
    """

    foot: IntArray
    frame: list[int]
    radius: FloatArray
    support: BoolArray


def add_spheres(model: Any, robot: Robot) -> Spheres:
    """Add a frame to the model for each contact sphere of the robot's feet."""
    import pinocchio

    spheres = [(k, foot, centre) for k, foot in enumerate(robot.feet) for centre in foot.centres]
    frames, support = [], np.zeros((len(spheres), model.nv), dtype=np.bool_)
    for row, (_, foot, centre) in enumerate(spheres):
        frame = model.frames[foot.frame]
        joint = int(frame.parentJoint)
        place = frame.placement * pinocchio.SE3(np.eye(3), centre)
        sphere = pinocchio.Frame(
            f"{foot.name}:sphere{row}", joint, foot.frame, place, pinocchio.FrameType.OP_FRAME
        )
        frames.append(int(model.addFrame(sphere)))
        while joint > 0:
            first = model.joints[joint].idx_v
            support[row, first : first + model.joints[joint].nv] = True
            joint = int(model.parents[joint])
    owner = np.array([k for k, _, _ in spheres], dtype=np.int64)
    return Spheres(owner, frames, np.array([foot.radius for _, foot, _ in spheres]), support)


class FeetOnGround:
    """Gaps, points and Jacobian of contact spheres over a terrain; one per world, for its arrays.

    Parameters
    ----------
    spheres
        From `add_spheres`.
    terrain
        What they stand on.
    model, data
        Pinocchio's, with the spheres' frames.

    Attributes
    ----------
    frames
        (p, 3, 3) rotation_world_contact below every sphere.
    J
        (3p, nv) map from v to the points' velocities in contact frames.
    """

    def __init__(self, spheres: Spheres, terrain: Terrain, model: Any, data: Any) -> None:
        import pinocchio

        self._spheres, self._terrain, self._model, self._data = spheres, terrain, model, data
        self._jacobians, self._update = pinocchio.computeJointJacobians, pinocchio.updateFramePlacements
        n = len(spheres.foot)
        self.frames, self.J = np.zeros((n, 3, 3)), np.zeros((3 * n, model.nv))
        self._plane = terrain.frame([0.0, 0.0]) if isinstance(terrain, SlopeTerrain) else None
        if self._plane is not None:
            self.frames[:] = self._plane
        self._centres, self._own = np.zeros((n, 3)), np.arange(n)

    def gaps(self, q: FloatArray) -> FloatArray:
        """Return the distances (p,) of the spheres to the ground [m] at (nq,) q; the frames follow."""
        self._jacobians(self._model, self._data, q)
        self._update(self._model, self._data)
        places, radii = self._data.oMf, self._spheres.radius
        self._centres = centres = np.array([places[k].translation for k in self._spheres.frame]).reshape(
            -1, 3
        )
        if self._plane is not None:
            return np.asarray(centres @ self._plane[:, 2] - radii)
        gaps = self._terrain.gap(centres) - radii
        rigid_step.surface_frames(self._terrain.normal(centres[:, :2]), self.frames)
        return np.asarray(gaps)

    def points(self) -> FloatArray:
        """Return the spheres' lowest points (p, 3) [m] at the q of the last `gaps`; J follows."""
        points = self._centres - self._spheres.radius[:, None] * self.frames[:, :, 2]
        contact_jacobian(self._data.J, self._spheres.support, self._own, points, self.frames, self.J)
        return np.asarray(points)
