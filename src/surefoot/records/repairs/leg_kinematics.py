"""Legs that follow: joints for feet at given places while the base is elsewhere."""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.mechanics import Robot

DAMPING = 1e-4
"""Of least squares, beside Jacobians in metres and radians [-]."""
STEPS = 6
"""Gauss-Newton steps of a frame at most."""
CLOSE = 1e-5
"""Distance to a foot's place at which they end [m, rad]."""


def follow_feet(robot: Robot, q: FloatArray, base: FloatArray, shifts: FloatArray) -> FloatArray:
    """Return the configurations (T, nq) with bases and feet shifted, and their joints between their stops.

    Soles keep their orientation. A foot that is out of reach is as near as damped least squares come.

    Parameters
    ----------
    q
        (T, nq) configurations.
    base
        (T, 3) shifts of the base, world axes [m].
    shifts
        (T, n, 3) shifts of the feet, world axes [m].
    """
    import pinocchio

    model, data = robot.model, robot.model.createData()
    frames = [foot.frame for foot in robot.feet]
    columns = np.unique([c for f in frames for c in _columns(robot, f)])
    rows = np.concatenate([np.arange(6) < (6 if len(foot.centres) > 2 else 3) for foot in robot.feet])
    low, high = np.array(model.lowerPositionLimit), np.array(model.upperPositionLimit)
    out = q.copy()
    out[:, :3] += base
    for k in range(len(q)):
        pinocchio.framesForwardKinematics(model, data, q[k])
        aims = [
            pinocchio.SE3(data.oMf[f].rotation, data.oMf[f].translation + s)
            for f, s in zip(frames, shifts[k], strict=True)
        ]
        one = out[k]
        for _ in range(STEPS):
            pinocchio.computeJointJacobians(model, data, one)
            pinocchio.updateFramePlacements(model, data)
            own = [pinocchio.getFrameJacobian(model, data, f, pinocchio.LOCAL) for f in frames]
            J = np.vstack(own)[rows][:, columns]
            e = np.concatenate(
                [pinocchio.log6(data.oMf[f].actInv(aim)).vector for f, aim in zip(frames, aims, strict=True)]
            )[rows]
            if np.abs(e).max() < CLOSE:
                break
            step = np.zeros(model.nv)
            step[columns] = J.T @ np.linalg.solve(J @ J.T + DAMPING * np.eye(len(e)), e)
            one = np.asarray(pinocchio.integrate(model, one, step))
            one[7:] = np.clip(one[7:], np.minimum(low, q[k])[7:], np.maximum(high, q[k])[7:])
        out[k] = one
    return out


def _columns(robot: Robot, frame: int) -> list[int]:
    """Return the velocity columns of the joints between the base and a frame."""
    model = robot.model
    out: list[int] = []
    joint = int(model.frames[frame].parentJoint)
    while joint > 1:
        one = model.joints[joint]
        out += range(int(one.idx_v), int(one.idx_v) + int(one.nv))
        joint = int(model.parents[joint])
    return out
