"""The legs under a centroidal motion: a start for the whole body's search."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.planning.schedule.problem import ScheduleProblem
from surefoot.planning.schedule.search import way_speeds
from surefoot.planning.transcription.guess import Guess
from surefoot.robot.legs import Legs
from surefoot.spatial import rotation_from_quaternion

if TYPE_CHECKING:
    from surefoot.planning.schedule.centroidal import CentroidalMotion


def whole_body_guess(problem: ScheduleProblem, motion: CentroidalMotion) -> Guess:
    """Return a motion of the whole body to start `optimise` from.

    The base is where the centre of mass says, the feet that stand are taken to their footholds by inverse
    kinematics, and the joints of feet in the air go from one stance to the next. Torques are those of inverse
    dynamics under the forces.

    Parameters
    ----------
    problem
        Of the whole body.
    motion
        Of `optimise_centroidal`.
    """
    import pinocchio

    robot, model, N = problem.robot, problem.robot.model, problem.knots
    data, joints, legs = model.createData(), robot.joints, Legs(robot)
    normal = np.asarray(problem.terrain.frame([0.0, 0.0]))[:, 2]
    pinocchio.centerOfMass(model, data, problem.q)
    lever = rotation_from_quaternion(problem.q[3:7]).T @ (np.array(data.com[0]) - problem.q[:3])
    q = problem.reference.copy()
    q[0] = problem.q
    known = np.zeros((N + 1, joints), dtype=bool)
    known[0] = known[-1] = True
    for k in range(1, N + 1):
        knot = min(k, N - 1)  # the foot stands to the end of a knot
        q[k, 3:7] = motion.quaternion[k] / np.linalg.norm(motion.quaternion[k])
        q[k, :3] = motion.com[k] - rotation_from_quaternion(q[k, 3:7]) @ lever
        q[k, 7:] = q[k - 1, 7:]
        stands = motion.stance[knot]
        R, feet = rotation_from_quaternion(q[k, 3:7]), legs.feet(q[k, 7:])
        centres = motion.footholds[knot] + robot.contact_points.foot_radii[:, None] * normal
        feet[stands] = (centres - q[k, :3])[stands] @ R
        q[k, 7:] = legs.reach(feet, q[k, 7:])
        for foot in np.flatnonzero(stands):
            known[k] |= robot.contact_points.foot_support[foot][robot.base_dof :]
    for j in range(joints):
        at = np.flatnonzero(known[:, j])
        q[:, 7 + j] = np.interp(np.arange(N + 1), at, q[at, 7 + j])
    return _with_forces(problem, motion, data, q, way_speeds(problem, q))


def _with_forces(
    problem: ScheduleProblem, motion: CentroidalMotion, data: Any, q: FloatArray, v: FloatArray
) -> Guess:
    """Return states (N + 1, nq), (N + 1, nv) with a motion's forces, and the torques that go with them."""
    import pinocchio

    robot, model, N = problem.robot, problem.robot.model, problem.knots
    points = robot.contact_points
    share = 1.0 / np.bincount(points.foot)[points.foot]
    frame = np.asarray(problem.terrain.frame([0.0, 0.0]))
    torques, impulses = np.empty((N, robot.joints)), np.empty((N, len(points), 3))
    for k in range(N):
        world = motion.forces[k, points.foot] * share[:, None]
        torque = np.array(pinocchio.rnea(model, data, q[k], v[k], (v[k + 1] - v[k]) / problem.dt))
        pinocchio.computeJointJacobians(model, data, q[k])
        for i, foot in enumerate(points.foot):
            torque -= _jacobian(problem, data, foot).T @ world[i]
        torques[k] = torque[robot.base_dof :]
        impulses[k] = world @ frame * problem.dt
    return Guess(q, v, np.clip(torques, -problem.torque_limits, problem.torque_limits), impulses)


def _jacobian(problem: ScheduleProblem, data: Any, foot: int) -> FloatArray:
    """Return the Jacobian (3, nv) of a foot's frame, world axes."""
    import pinocchio

    robot, axes = problem.robot, pinocchio.ReferenceFrame.LOCAL_WORLD_ALIGNED
    frame = robot.contact_points.frames[foot]
    return np.asarray(pinocchio.getFrameJacobian(robot.model, data, frame, axes)[:3])


def soles(problem: ScheduleProblem, data: Any, q: FloatArray) -> FloatArray:
    """Return where the feet touch the ground below them: (n, 3) [m]."""
    import pinocchio

    points = problem.robot.contact_points
    pinocchio.framesForwardKinematics(problem.robot.model, data, q)
    normal = np.asarray(problem.terrain.frame([0.0, 0.0]))[:, 2]
    return np.array(
        [
            data.oMf[frame].act(middle) - radius * normal
            for frame, middle, radius in zip(points.frames, points.middles, points.foot_radii, strict=True)
        ]
    )
