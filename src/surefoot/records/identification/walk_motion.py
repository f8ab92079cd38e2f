"""The equation of motion of a recorded walk, row by row: what forces, motors and a load make of it."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy import stats
from scipy.ndimage import convolve1d, minimum_filter1d

from surefoot.base.arrays import BoolArray, FloatArray, finite_array
from surefoot.base.errors import ProblemError
from surefoot.mechanics import Actuators, Robot, surface_frames
from surefoot.records.log import Log

WINDOW, CREEP = 0.05, 0.03
"""Time over which rows are averaged [s], and speed at which dry friction counts as three quarters [rad/s]."""
SWUNG, AROUND = 0.3, 0.02
"""A foot that is faster [m/s] so long before and after [s] does not touch."""
FEW = 11
"""Rows over which a speed is averaged before its sign is taken."""
PARTS = 10
"""Parts of the log that are left out one after the other."""


class WalkRows(NamedTuple):
    """T rows of a log, as the equation of motion needs them.

    Attributes
    ----------
    v, a, tau
        (T, nv), (T, nv), (T, joints) velocity at the end of a row, acceleration, torques.
    needed, load
        (T, nv) M a + h [N, N m]; (T, 6, 10) the same of a unit of each inertial parameter of the base's load.
    levers, frames
        (T, p, 3, nv) Jacobians of the contact points, world axes, and (T, p, 3, 3) axes of the ground there.
    swung
        (T, p) which points cannot touch.
    """

    v: FloatArray
    a: FloatArray
    tau: FloatArray
    needed: FloatArray
    load: FloatArray
    levers: FloatArray
    frames: FloatArray
    swung: BoolArray


def walk_channels(robot: Robot, log: Log) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return q (T, nq), v (T, nv) and torques (T, joints), or raise for what is missing or does not fit."""
    model, names = robot.model, ("q_estimated", "v_estimated", "torques")
    if not robot.floating or not robot.feet:
        raise ProblemError(f"a walk is of a floating base with feet; {robot.name} has no such thing")
    if "q_estimated" not in log or "v_estimated" not in log:
        names = ("q", "v", "torques")
    if missing := [name for name in names if name not in log]:
        raise ProblemError(f"a robot is identified from q, v and torques; the log has no {missing[0]}")
    sizes = (int(model.nq), int(model.nv), robot.joints)
    q, v, tau = (finite_array(n, log[n], (len(log), k)) for n, k in zip(names, sizes, strict=True))
    return q, v, tau


def walk_rows(
    robot: Robot, q: FloatArray, v: FloatArray, tau: FloatArray, normals: FloatArray | None, dt: float
) -> WalkRows:
    """Return what the equation of motion needs, row by row, but the last.

    Parameters
    ----------
    robot
        Who walked.
    q, v, tau
        (T, nq), (T, nv), (T, joints) as `walk_channels` returns them.
    normals
        (T, p, 3) of the ground at the contact points, world axes; None where it is level.
    dt
        Of a row [s].
    """
    import pinocchio

    model, data, points = robot.model, robot.model.createData(), robot.contact_points
    T, p, nv = len(q) - 1, len(points), int(model.nv)
    a, spheres = np.diff(v, axis=0) / dt, list(zip(points.joints.tolist(), points.places, strict=True))
    needed, load, J = np.empty((T, nv)), np.empty((T, 6, 10)), np.empty((T, 6, nv))
    frames, up = np.empty((T, p, 3, 3)), np.zeros((T, p, 3)) + np.array([0.0, 0.0, 1.0])
    up = up if normals is None else np.asarray(normals[:-1])
    surface_frames(np.ascontiguousarray(up).reshape(-1, 3), frames.reshape(-1, 3, 3))
    places = -points.radii[:, None] * up
    for k in range(T):
        # M a + h, and the columns Y of the base's ten inertial parameters: the regressor reads the velocities
        # and accelerations that rnea has left in the data, so it comes right behind it.
        needed[k] = pinocchio.rnea(model, data, q[k], v[k], a[k])
        load[k] = pinocchio.jointBodyRegressor(model, data, 1)
        J[k] = pinocchio.computeJointJacobians(model, data, q[k])
        places[k] += [data.oMi[joint].act(place) for joint, place in spheres]
    # Pinocchio's M has the rotors' inertias in it, which get a factor of their own here.
    needed[:, robot.base_dof :] -= np.array(model.armature)[robot.base_dof :] * a[:, robot.base_dof :]
    # World-axes columns are of the point at the origin: at the contact it is v + ω x p, of joints that move
    # the foot.
    levers = J[:, None, :3] + np.cross(J[:, None, 3:], places[..., None], axis=2)
    levers *= points.support[:, None, :]
    speed = np.linalg.norm(np.einsum("tpiv,tv->tpi", levers, v[1:]), axis=2)
    swung = minimum_filter1d(speed, 2 * round(AROUND / dt) + 1, axis=0) > SWUNG
    return WalkRows(v[1:], a, tau[:-1], needed, load, levers, frames, swung)


def figures_of(motors: Actuators) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return rotors' inertia, damping and dry friction of motors, (joints,) each."""
    return motors.armature, motors.damping, motors.friction


def smooth(values: FloatArray, window: int) -> FloatArray:
    """Return (T, ...) values averaged over a Hann window of so many rows."""
    weights = np.hanning(window + 2)[1:-1]
    return np.asarray(convolve1d(values, weights / weights.sum(), axis=0))


def motion_terms(
    rows: WalkRows, motors: Actuators, creep: float, lead: float
) -> tuple[FloatArray, FloatArray]:
    """Return X (T, nv, 13) and y (T, nv) with X θ - Jᵀ f = y for the factors and inertial parameters θ."""
    joints = slice(rows.v.shape[1] - rows.tau.shape[1], None)
    X, y = np.zeros((*rows.v.shape, 13)), -rows.needed
    moving = rows.a, rows.v, np.tanh((smooth(rows.v, FEW) + lead * smooth(rows.a, FEW)) / creep)
    for k, (figure, by) in enumerate(zip(figures_of(motors), moving, strict=True)):
        X[:, joints, k] = figure * by[:, joints]
    X[:, :6, 3:] = rows.load
    y[:, joints] += rows.tau
    return X, y


def foot_levers(rows: WalkRows) -> FloatArray:
    """Return (T, nv, 3p) what forces on the points do, zero for those of feet in the air."""
    T, nv = rows.v.shape
    levers = rows.levers * ~rows.swung[:, :, None, None]
    return np.asarray(levers.reshape(T, -1, nv).transpose(0, 2, 1))


def fit_motion(
    rows: WalkRows, motors: Actuators, window: int, creep: float, lead: float = 0.0
) -> tuple[FloatArray, FloatArray]:
    """Return the parameters (13,) and the half-widths of their 95 % intervals by the jackknife."""
    X, y = motion_terms(rows, motors, creep, lead)
    U, sizes, _ = np.linalg.svd(foot_levers(rows), full_matrices=False)
    U *= (sizes > 1e-6 * sizes.max(axis=1, keepdims=True))[:, None, :]
    system = np.concatenate([X, y[:, :, None]], axis=2)
    system -= U @ (U.transpose(0, 2, 1) @ system)
    system = smooth(system, window)[window :: max(1, window // 4)]
    weights = np.ones(rows.v.shape[1])
    for _ in range(3):
        theta = _solve(system, weights)
        left = system[:, :, -1] - system[:, :, :-1] @ theta
        weights = 1.0 / (left.std(axis=0) + 1e-9)
    cuts = np.linspace(0, len(system), PARTS + 1).astype(int)
    parts = [_solve(np.delete(system, slice(a, b), axis=0), weights) for a, b in pairwise(cuts)]
    error = np.sqrt((PARTS - 1) * np.var(parts, axis=0))
    return theta, stats.t.ppf(0.975, PARTS - 1) * error


def _solve(system: FloatArray, weights: FloatArray) -> FloatArray:
    """Return the least squares' parameters (13,); zero where nothing tells one."""
    flat = (system * weights[:, None]).reshape(-1, system.shape[2])
    size = np.linalg.norm(flat[:, :-1], axis=0)
    size[size == 0.0] = 1.0
    return np.asarray(np.linalg.lstsq(flat[:, :-1] / size, flat[:, -1], rcond=1e-10)[0] / size)
