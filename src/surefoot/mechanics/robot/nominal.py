"""A standing pose for a robot that brings none: feet under the hips, knees bent."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.mechanics.robot.foot import Foot

STRETCH = 0.8
"""Height of the hips over the feet, as a share of the leg's length."""
LEAN = 0.02
"""Weight of staying near the middle of the joint range, against the foot's place in leg lengths."""

WHOLE_LEG = 6
"""Directions in which a leg moves its foot that can put a sole anywhere."""
ASIDE = 0.02
"""Weight of a sole's place sideways where the leg has fewer joints."""


def chain(model: Any, frame: int) -> list[int]:
    """Return the joints between the base and a frame, base side first."""
    joints, joint = [], int(model.frames[frame].parentJoint)
    first = 1 if model.joints[1].nv == 6 else 0
    while joint > first:
        joints.append(joint)
        joint = int(model.parents[joint])
    return joints[::-1]


def leg_rank(model: Any, frame: int) -> int:
    """Return in how many of 6 directions the joints between base and frame move it, straight legs apart.

    Examples
    --------
    >>> from surefoot.mechanics.robot import load_robot
    >>> robot = load_robot("g1")
    >>> leg_rank(robot.model, robot.feet[0].frame)
    6
    """
    import pinocchio

    columns = [
        k
        for j in chain(model, frame)
        for k in range(model.joints[j].idx_v, model.joints[j].idx_v + model.joints[j].nv)
    ]
    if not columns:
        return 0
    data, best = model.createData(), 0
    spread = np.random.default_rng(0)
    for _ in range(3):  # a pose without symmetry; chance may bring it near to a singular one
        turn = spread.uniform(-1.0, 1.0, size=model.nv)
        q = pinocchio.integrate(model, pinocchio.neutral(model), turn)
        J = pinocchio.computeFrameJacobian(model, data, q, frame, pinocchio.ReferenceFrame.LOCAL)[:, columns]
        reach = max(float(np.linalg.norm(J[:3], axis=0).max()), 1e-9)
        scaled = J / np.array([reach, reach, reach, 1.0, 1.0, 1.0])[:, None]
        best = max(best, int(np.linalg.matrix_rank(scaled, tol=1e-3)))
    return best


def bend_legs(model: Any, q: FloatArray, feet: Sequence[Foot]) -> FloatArray:
    """Return a standing configuration for feet.

    Each foot is put below its hip (the second joint of a leg with three or more, so that hips keep
    their width) at `STRETCH` of the leg's length; flat feet are also kept level. One bounded
    least-squares problem per leg, started with the knee bent either way.

    Parameters
    ----------
    model
        Pinocchio's Model.
    q
        (nq,) starting pose [m, -, rad]; the base and all joints outside the legs stay as they are.
    feet
        Which frames stand, and whether they are flat.
    """
    out = q.copy()
    for foot in feet:
        if joints := chain(model, foot.frame):
            out = _bend(model, out, q, foot, joints)
    return out


def _standing_place(foot: Foot) -> FloatArray:
    """Return what is put below the hip, in the foot's frame (3,) [m].

    It is the frame's origin, or the ball where that lies beyond: an MJCF names bodies, from their joint on.
    """
    beyond = not foot.flat and float(np.linalg.norm(foot.centre)) > foot.radius
    return foot.centre if beyond else np.zeros(3)


def _bend(model: Any, q: FloatArray, start: FloatArray, foot: Foot, joints: Sequence[int]) -> FloatArray:
    """Return q with one leg's joints moved so that its foot reaches its place below the hip at the start."""
    import pinocchio
    from scipy.optimize import least_squares  # takes 0.2 s to load

    frame, level, place = foot.frame, foot.flat, _standing_place(foot)
    data = model.createData()
    pinocchio.framesForwardKinematics(model, data, start)
    places = [data.oMi[j].translation.copy() for j in joints[1 if len(joints) >= 3 else 0 :]]
    places.append(data.oMf[frame].act(place))
    length = max(float(sum(np.linalg.norm(b - a) for a, b in pairwise(places))), 1e-9)
    target = places[0] - [0.0, 0.0, STRETCH * length]
    index = [model.joints[j].idx_q for j in joints]
    low = np.maximum(model.lowerPositionLimit[index], -np.pi)
    high = np.minimum(model.upperPositionLimit[index], np.pi)
    high = np.maximum(high, low + 1e-6)  # a joint that its limits hold still is no unknown, but has bounds
    middle = np.clip(0.0, low, high)
    # an ankle that cannot roll leaves the sole level only where the hip does not roll either
    nearness = np.array([1.0, ASIDE if level and leg_rank(model, frame) < WHOLE_LEG else 1.0, 1.0])

    def miss(angles: FloatArray) -> FloatArray:
        full = q.copy()
        full[index] = angles
        pinocchio.framesForwardKinematics(model, data, full)
        pose = data.oMf[frame]
        rest = LEAN * (angles - middle)
        tilt = pose.rotation[:, 2] - [0.0, 0.0, 1.0] if level else np.zeros(0)
        turn = pose.rotation[1, :1] if level else np.zeros(0)
        return np.concatenate([(pose.act(place) - target) * nearness / length, tilt, turn, rest])

    best: Any = None
    for bend in (0.6, -0.6):
        start = middle.copy()
        start[len(joints) - (3 if level else 1)] += -2.0 * bend
        start[max(len(joints) - (4 if level else 2), 0)] += bend
        found = least_squares(miss, np.clip(start, low + 1e-7, high - 1e-7), bounds=(low, high))
        if best is None or found.cost < 0.999 * best.cost:
            best = found
    out = q.copy()
    out[index] = np.clip(best.x, model.lowerPositionLimit[index], model.upperPositionLimit[index])
    return out
