"""Put a robot on a terrain: feet on the ground, base along the surface, weight over the feet."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import BoolArray, FloatArray, finite_array, of_kind
from surefoot.base.errors import ModelError
from surefoot.base.spatial import quaternion_from_rotation, rotation_from_quaternion, rotation_log
from surefoot.mechanics.robot.nominal import WHOLE_LEG, chain, leg_rank
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


MOST_HELD = 6
"""Rounds in which joints are held at the ends of their ranges, at most [-]."""
EDGE = 1e-6
"""Gap [m], and way beyond the end of a range [rad, m], that are rounding."""


@dataclass
class _Goal:
    """What a pose should reach: slope and base in the world, places of the feet, weight from their middle.

    `holds` weighs the place of each foot over the ground.
    """

    slope: FloatArray
    rotation: FloatArray
    anchors: FloatArray
    holds: list[float]
    offset: FloatArray


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
    for rounds in (1, MOST_HELD):  # joints are held at the ends of their ranges where nothing else stands
        for share in LEANS:
            found = _place(robot, seen, robot.configuration(q), share, rounds)
            if found is not None:
                found[:2] += there
                return found
    raise ModelError(f"{robot.name} cannot stand on {ground!r}: its legs do not reach the ground there")


def _place(robot: Robot, ground: Terrain, start: FloatArray, share: float, rounds: int) -> FloatArray | None:
    """Return the pose whose weight is moved by a share of the way to the feet's middle, or None.

    After each round but the last, joints that are beyond their range are held at its end.
    """
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
    goal = _Goal(slope, rotation, anchors, [LOOSE if few else 1.0 for few in poor], offset)
    held, begin = np.zeros(robot.joints, dtype=bool), start
    for _ in range(rounds):
        now, worst = _settle(robot, ground, goal, begin, held)
        within = _within_ranges(robot, now)
        beyond = np.abs(pinocchio.difference(robot.model, within, now)[6:]) > EDGE
        if not beyond.any():
            return now if worst < EDGE else None
        held |= beyond
        begin = _ends_of_ranges(robot, start, within, held)
        for k, foot in enumerate(robot.feet):
            joints = [robot.model.joints[j].idx_v - 6 for j in chain(robot.model, foot.frame)]
            if foot.flat and held[joints].any():
                goal.holds[k] = LOOSE
    return None


def _within_ranges(robot: Robot, q: FloatArray) -> FloatArray:
    """Return q (nq,) with every joint in its range."""
    out = q.copy()
    out[7:] = np.clip(q[7:], robot.model.lowerPositionLimit[7:], robot.model.upperPositionLimit[7:])
    return out


def _ends_of_ranges(robot: Robot, q: FloatArray, within: FloatArray, held: BoolArray) -> FloatArray:
    """Return q (nq,) with the joints that are held (joints,) as they are within their ranges."""
    out = q.copy()
    for joint in list(robot.model.joints)[2:]:
        if joint.nq == joint.nv and held[joint.idx_v - 6 : joint.idx_v - 6 + joint.nv].any():
            span = slice(joint.idx_q, joint.idx_q + joint.nq)
            out[span] = within[span]
    return out


def _settle(
    robot: Robot, ground: Terrain, goal: _Goal, start: FloatArray, held: BoolArray
) -> tuple[FloatArray, float]:
    """Return the pose by Gauss-Newton steps of all joints that are not held, and its worst gap [m]."""
    import pinocchio

    now, worst = start.copy(), np.inf
    lower = np.hstack([np.zeros((robot.joints, 6)), np.eye(robot.joints)])
    for _ in range(ITERATIONS):
        residual, jacobian, worst = _miss(robot, ground, now, goal)
        # Least motion of the joints subject to the pose, by weight: legs with a joint to spare keep their
        # shape.
        stay = pinocchio.difference(robot.model, start, now)[6:]
        stacked = np.vstack([POSE_WEIGHT * jacobian, lower])
        stacked[:, 6:][:, held] = 0.0  # no step then: the least one that does as well
        wanted = np.concatenate([POSE_WEIGHT * residual, stay])
        step = np.linalg.lstsq(stacked, -wanted, rcond=None)[0]
        now = np.asarray(pinocchio.integrate(robot.model, now, step / max(1.0, 4.0 * np.abs(step).max())))
        if max(worst, np.abs(step).max()) < SETTLED:
            break
    return now, worst


def _support_middle(robot: Robot, ground: Terrain, anchors: FloatArray) -> FloatArray:
    """Return the mean of the contact points under sphere centres at (n, 2) places: (2,)."""
    radii = np.array([[foot.radius] for foot in robot.feet])
    return np.asarray((anchors - radii * ground.normal(anchors)[:, :2]).mean(axis=0))


def _miss(robot: Robot, ground: Terrain, q: FloatArray, goal: _Goal) -> tuple[FloatArray, FloatArray, float]:
    """Return what a pose still misses, its Jacobian, and the worst gap [m]."""
    import pinocchio

    slope, rotation, anchors, offset = goal.slope, goal.rotation, goal.anchors, goal.offset
    model, data = robot.model, robot.data
    pinocchio.computeJointJacobians(model, data, q)
    pinocchio.framesForwardKinematics(model, data, q)
    pinocchio.jacobianCenterOfMass(model, data, q, False)
    aligned = pinocchio.ReferenceFrame.LOCAL_WORLD_ALIGNED
    rows, values, worst = [], [], 0.0
    for foot, anchor, hold in zip(robot.feet, anchors, goal.holds, strict=True):
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
