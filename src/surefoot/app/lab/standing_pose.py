"""The robot of the page *stand*: a configuration with feet and centre of mass where they were dragged."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from surefoot.app.lab.body import RobotBody
from surefoot.app.lab.drawing import Mesh, Shape
from surefoot.app.lab.stand import StandState
from surefoot.base.arrays import FloatArray
from surefoot.base.spatial import rotation_from_normal
from surefoot.mechanics import Robot

ITERATIONS = 15
"""Gauss-Newton steps for a configuration."""
NEAR = 0.02
"""Largest distance of a foot or of the centre of mass at which the robot is drawn [m]; sticks beyond it."""
STAY = 0.03
"""Weight of a turn of the base or of a joint from the nominal pose, beside a distance [m/rad]."""
OPACITY = 0.4
"""Of the robot, so that the ball of the centre of mass is seen inside it."""


class StandingPose:
    """Finds and draws the pose of a robot on a stance that is dragged.

    Parameters
    ----------
    robot
        With a free base, else nothing is drawn.
    """

    def __init__(self, robot: Robot) -> None:
        self.robot, self._body = robot, RobotBody(robot)
        self._data, points = robot.model.createData(), robot.contact_points
        places = robot.stance(robot.nominal).positions
        middle = np.array([*places[:, :2].mean(axis=0), float(places[:, 2].mean())])
        self._start = np.array(robot.nominal)
        if robot.floating:
            self._start[:3] -= middle
        self._joints, self._locals = points.joints.tolist(), points.places
        self._feet = points.foot.astype(int)
        self._offsets = self._centres(self._start) - (places - middle)[self._feet]

    def shapes(self, state: StandState) -> dict[str, Shape]:
        """Return the robot's links on a stance; none where it does not reach."""
        q = self.configuration(state)
        drawn = {} if q is None else self._body.shapes(q)
        return {n: replace(one, opacity=OPACITY) for n, one in drawn.items() if isinstance(one, Mesh)}

    def configuration(self, state: StandState) -> FloatArray | None:
        """Return the (nq,) configuration that is nearest to the nominal one; None where there is none."""
        import pinocchio

        model = self.robot.model
        if not self.robot.floating or not state.on.any():
            return None
        frame = rotation_from_normal(state.normal)
        goals = state.on_ground(state.feet)[self._feet] + self._offsets @ frame.T
        used = np.flatnonzero(state.on[self._feet]).tolist()
        stay = np.full(model.nv, STAY)
        stay[:3] = 0.0
        q = self._start
        for _ in range(ITERATIONS):
            centres, rows = self._centres(q), [self._jacobian(k) for k in used]
            slope = np.vstack([*rows, pinocchio.jacobianCenterOfMass(model, self._data, q)])
            off = np.concatenate([(goals - centres)[used].ravel(), state.com - self._data.com[0]])
            back = pinocchio.difference(model, q, self._start)
            step = np.linalg.lstsq(np.vstack([slope, np.diag(stay)]), np.r_[off, stay * back], rcond=None)[0]
            q = pinocchio.integrate(model, q, np.clip(step, -0.5, 0.5))
            q[7:] = np.clip(q[7:], model.lowerPositionLimit[7:], model.upperPositionLimit[7:])
        missed = np.linalg.norm((goals - self._centres(q))[used], axis=1).max()
        com = np.linalg.norm(state.com - pinocchio.centerOfMass(model, self._data, q))
        return np.asarray(q) if max(missed, com) <= NEAR else None

    def _centres(self, q: FloatArray) -> FloatArray:
        """Return the (p, 3) centres of the contact spheres at a configuration [m]."""
        import pinocchio

        pinocchio.computeJointJacobians(self.robot.model, self._data, q)
        pairs = zip(self._joints, self._locals, strict=True)
        return np.array([self._data.oMi[joint].act(place) for joint, place in pairs])

    def _jacobian(self, point: int) -> FloatArray:
        """Return the (3, nv) Jacobian of a sphere's centre, at the configuration of the last `_centres`."""
        import pinocchio

        joint = self._joints[point]
        whole = pinocchio.getJointJacobian(
            self.robot.model, self._data, joint, pinocchio.ReferenceFrame.LOCAL_WORLD_ALIGNED
        )
        arm = self._data.oMi[joint].rotation @ self._locals[point]
        return np.asarray(whole[:3] - np.cross(arm, whole[3:], axisb=0, axisc=0))
