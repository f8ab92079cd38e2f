"""From a whole-body problem to its centroidal one, and from a centroidal motion back to a start."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.planning.direct.blocks import pack
from surefoot.planning.direct.problem import Window
from surefoot.planning.schedule.centroidal import (
    CentroidalMotion,
    CentroidalProblem,
)
from surefoot.planning.schedule.problem import ScheduleProblem
from surefoot.robot import Robot
from surefoot.spatial import rotation_from_quaternion

STEPS, DAMPING, LONGEST = 20, 1e-3, 0.3
"""Of the inverse kinematics: steps a knot, damping [m²], largest change of a joint per step [rad]."""


def centroidal_problem(problem: ScheduleProblem, **changes: Any) -> CentroidalProblem:
    """Return the centroidal problem of a whole-body one: its schedule, start, reference and windows.

    Mass, inertia and the feet's places are those of the start. The windows of the base's pose become those of
    the centre of mass by the reference's rotation; those of its velocity are kept as for an upright body.
    Bounds on turning are kept where they mean rest: in the air legs that are drawn in or stretched change how
    fast a body turns, and the inertia of this model is constant.

    Parameters
    ----------
    problem
        Of the whole body; one contact point a foot or more.
    changes
        Any field of `CentroidalProblem`.
    """
    robot, q, v = problem.robot, problem.q, problem.v
    import pinocchio

    model, data = robot.model, robot.model.createData()
    pinocchio.ccrba(model, data, q, v)
    turned = rotation_from_quaternion(q[3:7])
    com, inertia = np.array(data.com[0]), turned.T @ np.array(data.Ig.inertia) @ turned
    start = np.concatenate([np.array(data.hg.linear) / robot.mass, np.array(data.hg.angular)])
    lever = turned.T @ (com - q[:3])
    feet = _soles(robot, data, q, problem)
    reference = problem.reference[:, :7].copy()
    shift = np.array([rotation_from_quaternion(t) @ lever for t in reference[:, 3:]])
    reference[:, :3] += shift
    windows = {k: _window(w, shift[k]) for k, w in problem.windows.items()}
    found = CentroidalProblem(
        robot.mass, inertia, (feet - com) @ turned, problem.schedule, problem.dt, problem.knots,
        np.concatenate([com, q[3:7]]), start, feet, reference, windows=windows,
        mu=problem.mu, terrain=problem.terrain, force_min=problem.force_min,
    )  # fmt: skip
    return replace(found, **changes) if changes else found


def whole_body_start(problem: ScheduleProblem, motion: CentroidalMotion) -> FloatArray:
    """Return variables for `optimise` to start a whole-body search from, in the unit of each (V,).

    The base is where the centre of mass says, the feet that stand are taken to their footholds by inverse
    kinematics, and the joints of feet in the air go from one stance to the next. Torques are those of inverse
    dynamics under the forces.

    Parameters
    ----------
    problem
        Of the whole body.
    motion
        Of its `centroidal_problem`.
    """
    import pinocchio

    robot, model, N = problem.robot, problem.robot.model, problem.knots
    data, joints = model.createData(), robot.joints
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
        stands = np.flatnonzero(motion.stance[knot])
        _reach(problem, data, q[k], motion.footholds[knot], stands)
        for foot in stands:
            known[k] |= robot.contact_points.foot_support[foot][robot.base_dof :]
    for j in range(joints):
        at = np.flatnonzero(known[:, j])
        q[:, 7 + j] = np.interp(np.arange(N + 1), at, q[at, 7 + j])
    v = np.zeros((N + 1, model.nv))
    v[0] = problem.v
    for k in range(N):
        v[k + 1] = pinocchio.difference(model, q[k], q[k + 1]) / problem.dt
    return _with_forces(problem, motion, data, q, v)


def _with_forces(
    problem: ScheduleProblem, motion: CentroidalMotion, data: Any, q: FloatArray, v: FloatArray
) -> FloatArray:
    """Return the variables of states (N + 1, nq), (N + 1, nv) with a motion's forces, and torques."""
    import pinocchio

    robot, model, N = problem.robot, problem.robot.model, problem.knots
    points, base = robot.contact_points, robot.base_dof
    share = 1.0 / np.bincount(points.foot)[points.foot]
    frame = np.asarray(problem.terrain.frame([0.0, 0.0]))
    inputs = np.empty((N, robot.joints + 3 * len(points)))
    for k in range(N):
        world = motion.forces[k, points.foot] * share[:, None]
        effort = pinocchio.rnea(model, data, q[k], v[k], (v[k + 1] - v[k]) / problem.dt)
        pinocchio.computeJointJacobians(model, data, q[k])
        torque = np.array(effort)
        for i, foot in enumerate(points.foot):
            J = pinocchio.getFrameJacobian(
                model, data, points.frames[foot], pinocchio.ReferenceFrame.LOCAL_WORLD_ALIGNED
            )
            torque -= J[:3].T @ world[i]
        use = np.clip(torque[base:] / problem.torque_limits, -1.0, 1.0)
        inputs[k] = np.concatenate([use, (world @ frame / problem.weight).ravel()])
    return pack(np.hstack([q, v]), inputs)


def _reach(problem: ScheduleProblem, data: Any, q: FloatArray, footholds: FloatArray, stands: Any) -> None:
    """Move the joints of (nq,) q so that feet reach (n, 3) footholds, as near as they can get [m]."""
    import pinocchio

    robot, model = problem.robot, problem.robot.model
    low, high = np.array(model.lowerPositionLimit)[7:], np.array(model.upperPositionLimit)[7:]
    for _ in range(STEPS):
        soles = _soles(robot, data, q, problem)
        if len(stands) == 0 or np.abs(footholds[stands] - soles[stands]).max() < 1e-6:
            return
        pinocchio.computeJointJacobians(model, data, q)
        for foot in stands:
            J = pinocchio.getFrameJacobian(
                model, data, robot.contact_points.frames[foot], pinocchio.ReferenceFrame.LOCAL_WORLD_ALIGNED
            )[:3, robot.base_dof :]
            off = footholds[foot] - soles[foot]
            move = J.T @ np.linalg.solve(J @ J.T + DAMPING * np.eye(3) * np.linalg.norm(off), off)
            q[7:] += move * min(1.0, LONGEST / max(float(np.abs(move).max()), 1e-12))
        q[7:] = np.clip(q[7:], low, high)


def _soles(robot: Robot, data: Any, q: FloatArray, problem: ScheduleProblem) -> FloatArray:
    """Return where the feet touch the ground below them: (n, 3) [m]."""
    import pinocchio

    points = robot.contact_points
    pinocchio.framesForwardKinematics(robot.model, data, q)
    normal = np.asarray(problem.terrain.frame([0.0, 0.0]))[:, 2]
    return np.array(
        [
            data.oMf[frame].act(middle) - radius * normal
            for frame, middle, radius in zip(points.frames, points.middles, points.foot_radii, strict=True)
        ]
    )


def _window(window: Window, shift: FloatArray) -> Window:
    """Return a window of the base as one of the centre of mass, `shift` [m] away."""
    moved = np.concatenate([shift, np.zeros(4)])
    q = [None if side is None else side[:7] + moved for side in (window.q_low, window.q_high)]
    if window.v_low is None or window.v_high is None:
        return Window(q[0], q[1])
    turning = (window.v_low[3:6] != 0.0) | (window.v_high[3:6] != 0.0)
    free = np.concatenate([np.zeros(3, dtype=bool), turning])
    return Window(
        q[0], q[1], np.where(free, -np.inf, window.v_low[:6]), np.where(free, np.inf, window.v_high[:6])
    )
