"""Put a robot on a terrain: feet on the ground, base along the surface, weight over the feet."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, finite_array, of_kind
from surefoot.base.errors import ModelError
from surefoot.base.spatial import quaternion_from_rotation, rotation_from_quaternion, rotation_log
from surefoot.mechanics.robot.nominal import WHOLE_LEG, leg_rank
from surefoot.mechanics.robot.robot import Robot
from surefoot.mechanics.robot.sole_plane import sole_plane
from surefoot.mechanics.terrain import FlatTerrain, Terrain

ITERATIONS = 60
SETTLED = 1e-9
"""Distances of the feet from the ground [m], and steps, that end the search."""
POSE_WEIGHT = 2e5
"""Weight of the wanted pose against joint motion: the pose is met, by the least motion."""
LOOSE = 1e-3
"""Weight of the place over the ground of a sole whose leg has too few joints to choose it."""
LEANS = (1.0, 0.75, 0.5, 0.25, 0.0)
"""Shares of the way to the feet's middle that the weight is moved; the first that the legs allow."""


class _ShiftedTerrain(Terrain):
    """A terrain with its origin moved to the (2,) place `at`."""

    def __init__(self, terrain: Terrain, at: FloatArray) -> None:
        self._terrain, self._at = terrain, at

    def __repr__(self) -> str:
        return repr(self._terrain)

    def height(self, xy: ArrayLike) -> FloatArray:
        return self._terrain.height(np.asarray(xy) + self._at)

    def normal(self, xy: ArrayLike) -> FloatArray:
        return self._terrain.normal(np.asarray(xy) + self._at)


class _UnderSoles(Terrain):
    """The planes on which soles lie that are put down at (n, 2) places; anywhere that of the nearest one."""

    planar = False

    def __init__(self, robot: Robot, terrain: Terrain, places: FloatArray) -> None:
        self._places = places
        normals, heights = [], []
        for foot, xy in zip(robot.feet, places, strict=True):
            corners = foot.centres - foot.centre if foot.flat else np.zeros((1, 3))
            robot._forward(robot.nominal)
            corners = corners @ robot.data.oMf[foot.frame].rotation.T
            frame, height = sole_plane(terrain, corners, xy, 0.0)
            normals.append(frame[:, 2])
            heights.append(height)
        self._normals, self._heights = np.array(normals), np.array(heights)

    def _nearest(self, xy: ArrayLike) -> tuple[FloatArray, Any]:
        at = np.asarray(xy, dtype=np.float64)
        return at, np.argmin(np.linalg.norm(at[..., None, :] - self._places, axis=-1), axis=-1)

    def height(self, xy: ArrayLike) -> FloatArray:
        at, k = self._nearest(xy)
        n, away = self._normals[k], at - self._places[k]
        return np.asarray(self._heights[k] - (away * n[..., :2]).sum(axis=-1) / n[..., 2])

    def normal(self, xy: ArrayLike) -> FloatArray:
        return np.asarray(self._normals[self._nearest(xy)[1]])


def place(
    robot: Robot,
    terrain: Terrain | None = None,
    q: ArrayLike | None = None,
    at: ArrayLike = (0.0, 0.0),
) -> FloatArray:
    """Return a configuration (nq,) [m, -, rad] that stands on the terrain about a place.

    The base takes the terrain's slope at that place (and stays level on flat feet, whose ankles take
    up the slope), every contact sphere touches the ground (soles lie on it as
    `sole_plane` says, where it is no plane), and the centre of mass lies above the middle of the feet
    as gravity sees it (or as far that way as the
    joints allow). Gauss-Newton on Pinocchio's
    Jacobians.

    Parameters
    ----------
    robot
        With a floating base and at least one foot.
    terrain
        None for flat ground.
    q
        (nq,) pose [m, -, rad] whose joints to stay near; None for the nominal one.
    at
        (2,) the place, world axes [m].

    Raises
    ------
    ModelError
        If the robot has no feet or a fixed base, or the legs cannot reach the ground this way.
    """
    of_kind("robot", robot, Robot)
    if not robot.floating or not robot.feet:
        raise ModelError(f"{robot.name} cannot be placed: it needs a floating base and feet")
    ground = FlatTerrain() if terrain is None else terrain
    of_kind("terrain", ground, Terrain)
    there = finite_array("at", at, (2,))
    seen = _ShiftedTerrain(ground, there) if there.any() else ground
    for share in LEANS:
        found = _place(robot, seen, robot.configuration(q), share)
        if found is not None:
            found[:2] += there
            return found
    raise ModelError(f"{robot.name} cannot stand on {ground!r}: its legs do not reach the ground there")


def _place(robot: Robot, ground: Terrain, start: FloatArray, share: float) -> FloatArray | None:
    """Return the pose whose weight is moved by a share of the way to the feet's middle, or None."""
    import pinocchio

    level = any(foot.flat for foot in robot.feet)
    slope = np.eye(3) if level else ground.frame([0.0, 0.0])
    rotation = slope @ rotation_from_quaternion(robot.nominal[3:7])  # some bases have other axes
    middle = robot.foot_positions(start).mean(axis=0)
    lowest = min(robot.sphere_bottoms(start))
    start[:3] = slope @ (start[:3] - [middle[0], middle[1], lowest])
    start[2] += float(ground.height([0.0, 0.0]))
    start[3:7] = quaternion_from_rotation(rotation)
    anchors = robot.foot_positions(start)[:, :2]
    if level and not ground.planar:
        ground = _UnderSoles(robot, ground, anchors)
    offset = (1.0 - share) * (robot.com(start)[:2] - _support_middle(robot, ground, anchors))
    # a leg of few joints cannot choose where its sole lies level
    poor = [foot.flat and leg_rank(robot.model, foot.frame) < WHOLE_LEG for foot in robot.feet]
    holds = [LOOSE if few else 1.0 for few in poor]
    now = start.copy()
    worst = np.inf
    for _ in range(ITERATIONS):
        residual, jacobian, worst = _miss(robot, ground, now, slope, rotation, anchors, holds, offset)
        # Least motion of the joints subject to the pose, by weight: legs with a joint to spare keep their
        # shape.
        stay = pinocchio.difference(robot.model, start, now)[6:]
        lower = np.hstack([np.zeros((robot.joints, 6)), np.eye(robot.joints)])
        stacked = np.vstack([POSE_WEIGHT * jacobian, lower])
        wanted = np.concatenate([POSE_WEIGHT * residual, stay])
        step = np.linalg.lstsq(stacked, -wanted, rcond=None)[0]
        now = np.asarray(pinocchio.integrate(robot.model, now, step / max(1.0, 4.0 * np.abs(step).max())))
        if max(worst, np.abs(step).max()) < SETTLED:
            break
    low, high = robot.model.lowerPositionLimit[7:], robot.model.upperPositionLimit[7:]
    reached = worst < 1e-6 and np.all(now[7:] > low - 1e-6) and np.all(now[7:] < high + 1e-6)
    return now if reached else None


def _support_middle(robot: Robot, ground: Terrain, anchors: FloatArray) -> FloatArray:
    """Return the mean of the contact points under sphere centres at (n, 2) places: (2,)."""
    radii = np.array([[foot.radius] for foot in robot.feet])
    return np.asarray((anchors - radii * ground.normal(anchors)[:, :2]).mean(axis=0))


def _miss(
    robot: Robot,
    ground: Terrain,
    q: FloatArray,
    slope: FloatArray,
    rotation: FloatArray,
    anchors: FloatArray,
    holds: list[float],
    offset: FloatArray,
) -> tuple[FloatArray, FloatArray, float]:
    """Return what a pose still misses, its Jacobian, and the worst gap [m]."""
    import pinocchio

    model, data = robot.model, robot.data
    pinocchio.computeJointJacobians(model, data, q)
    pinocchio.framesForwardKinematics(model, data, q)
    pinocchio.jacobianCenterOfMass(model, data, q, False)
    aligned = pinocchio.ReferenceFrame.LOCAL_WORLD_ALIGNED
    rows, values, worst = [], [], 0.0
    for foot, anchor, hold in zip(robot.feet, anchors, holds, strict=True):
        pose = data.oMf[foot.frame]
        J = pinocchio.getFrameJacobian(model, data, foot.frame, aligned)
        for centre in foot.centres:
            arm = pose.rotation @ centre
            point = pose.translation + arm
            normal = ground.normal(point[:2])
            gap = float(ground.gap(point)) - foot.radius
            worst = max(worst, abs(gap))
            # Gap of each sphere along the normal, places of the feet over the ground, toes, attitude, weight:
            # all to zero.
            rows.append(normal @ (J[:3] - pinocchio.skew(arm) @ J[3:]))
            values.append(gap)
        arm = pose.rotation @ foot.centre
        rows.extend(hold * (J[:3] - pinocchio.skew(arm) @ J[3:])[:2])
        values.extend(hold * ((pose.translation + arm)[:2] - anchor))
        if foot.flat:  # toes along the heading
            rows.append(slope[:, 2] @ J[3:])
            values.append(float(slope[:, 1] @ pose.rotation[:, 0]))
    base = data.oMi[1].rotation
    turn = np.zeros((3, model.nv))
    turn[:, 3:6] = base
    values.extend(rotation_log(base @ rotation.T))
    rows.extend(turn)
    values.extend(data.com[0][:2] - _support_middle(robot, ground, anchors) - offset)
    rows.extend(data.Jcom[:2])
    return np.array(values, dtype=np.float64), np.array(rows), worst
