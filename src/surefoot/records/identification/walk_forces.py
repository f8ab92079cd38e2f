"""Forces on the feet of a recorded walk, from torques and motion alone, and how well they are known.

Joints tell the forces of their own legs, whatever else pushes the robot. The base's six equations tell the
sum of all, but a push that nobody wrote down is in them, and so are an estimator's leaps where a foot slips:
each counts by what it usually leaves open, and by what it needs besides the joints' forces at the time.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.ndimage import maximum_filter1d

from surefoot.base.arrays import FloatArray
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics import Actuators, Robot
from surefoot.records.identification.friction_tracker import SUSTAINED
from surefoot.records.identification.walk_motion import CREEP, WalkRows, foot_levers, motion_terms, smooth

SINGULAR = 1e-3
"""Ratio to the largest from which a lever counts, where joints alone tell a force."""
NOISE, FLOOR = 0.03, 1e-3
"""Deviation of torques that no leg in the air tells, as a share of their mean [-], and least deviation of the
base's equations, as a share of m g."""
SCALE = 0.03
"""Deviation of the scale of a joint's torques, the same in all rows [-]."""
LASTING = 0.02
"""Time that a use of friction has to last, and around a row whose largest misfit counts for it [s]."""


class WalkForces(NamedTuple):
    """Forces on the n feet in T rows, axes of the ground under each.

    Attributes
    ----------
    forces
        (T, n, 3) of all points of a foot together [N].
    covariance
        (T, n, 3, 3) of what the equation of motion leaves open of them [N²].
    by_scales
        (T, n, 3, 3) the same of what scales of torques do to them, which more rows do not make better known.
    """

    forces: FloatArray
    covariance: FloatArray
    by_scales: FloatArray


def foot_forces_of(
    robot: Robot, rows: WalkRows, motors: Actuators, theta: FloatArray, dt: float
) -> WalkForces:
    """Return the forces on the feet by weighted least squares, row by row.

    Parameters
    ----------
    robot, rows
        Who walked, and how.
    motors, theta
        Nominal motors and the (13,) parameters that `fit_motion` found of them and of the load.
    dt
        Of a row [s].
    """
    X, y = motion_terms(rows, motors, CREEP, 0.0)
    levers, needed = foot_levers(rows), X @ theta - y
    window = max(1, round(SUSTAINED / dt))
    deviations = _find_deviations(robot, rows, levers, needed, dt)
    back = np.linalg.pinv(levers / deviations[:, :, None], rcond=1e-6) / deviations[:, None]
    pushed = back @ needed[:, :, None]
    joints = robot.base_dof
    over = (smooth(needed - (levers @ pushed)[:, :, 0], window) / deviations)[:, joints:]
    misfit = np.maximum(_largest_around(np.sqrt(np.mean(over**2, axis=1)), dt), 1.0)
    per_foot = _sum_points(robot, rows, back)
    forces = smooth(np.einsum("tniv,tv->tni", per_foot, needed), window)
    left = per_foot * (deviations * misfit[:, None])[:, None, None]
    scaled = per_foot[..., joints:] * (SCALE * smooth(rows.tau, window))[:, None, None]
    return WalkForces(forces, *(np.einsum("tniv,tnjv->tnij", part, part) for part in (left, scaled)))


def _find_deviations(
    robot: Robot, rows: WalkRows, levers: FloatArray, needed: FloatArray, dt: float
) -> FloatArray:
    """Return how far off the equations of motion are, row by row: (T, nv) [N, N m].

    Joints by what their legs leave in the air; the base by what it needs besides the forces that joints alone
    tell, usually, and in a row where that is more than both explain.
    """
    joints, window = robot.base_dof, max(1, round(SUSTAINED / dt))
    means = smooth(needed, window)[:, joints:]
    bears = (levers[:, joints:] != 0.0).any(axis=2)
    free = [means[~bears[:, k], k] for k in range(robot.joints)]
    told = [_usual_size(one) for one in free if len(one)]
    known = float(np.sqrt(np.mean(np.square(told)))) if told else 0.0
    torque = max(known, NOISE * float(np.abs(rows.tau).mean()), 1e-9)
    alone = np.linalg.pinv(levers[:, joints:], rcond=SINGULAR)
    sums = levers[:, :joints] @ alone
    rest = smooth(needed[:, :joints] - (sums @ needed[:, joints:, None])[:, :, 0], window)
    base = np.maximum(_usual_size(rest), FLOOR * robot.mass * GRAVITY)
    expected = np.sqrt(base**2 + torque**2 * np.sum(sums**2, axis=2))
    base = base * np.maximum(_largest_around(np.abs(rest) / expected, dt), 1.0)
    return np.concatenate([base, np.full((len(base), robot.joints), torque)], axis=1)


def _largest_around(values: FloatArray, dt: float) -> FloatArray:
    """Return the largest of (T, ...) values within `LASTING`."""
    return np.asarray(maximum_filter1d(values, max(2, round(LASTING / dt)), axis=0))


def _usual_size(values: FloatArray) -> FloatArray:
    """Return the deviation from zero of (T, ...) values by their median, which few leaps do not move."""
    return np.asarray(1.4826 * np.median(np.abs(values), axis=0))


def _sum_points(robot: Robot, rows: WalkRows, back: FloatArray) -> FloatArray:
    """Return what makes the (T, n, 3) forces on feet of the equations of motion: (T, n, 3, nv)."""
    T, p = rows.frames.shape[:2]
    points = np.einsum("tpji,tpjv->tpiv", rows.frames, back.reshape(T, p, 3, -1))
    owner = np.asarray(robot.contact_points.foot)
    return np.stack([points[:, owner == k].sum(axis=1) for k in range(len(robot.feet))], axis=1)
