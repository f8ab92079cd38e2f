"""A scheduled motion as an NLP: the exact step's equations with the contact modes of the schedule.

Semi-implicit Euler as `surefoot.stepping.Knot` takes it, written as inverse dynamics::

    RNEA(q, v, (v⁺ - v) / dt, f) = S tau,      q⁺ = q ⊕ dt v⁺

A foot that stands has gap / dt + u_n = 0, u_t = 0 and its force inside the friction cone; one that does not
has no force and gap / dt + u_n >= 0. Those are the laws of contact for feet that stick or are in the air, so
that the torques of a solution lead through the exact step to the same motion.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from surefoot.arrays import FloatArray, IntArray
from surefoot.planning.direct.problem import limit_joints
from surefoot.planning.schedule.problem import ScheduleProblem
from surefoot.planning.schedule.symmetry import mirrored_joints, quadruped_order
from surefoot.planning.transcription.nlp import Block, Sides, pack
from surefoot.robot import Robot
from surefoot.robot.libraries import import_casadi
from surefoot.robot.motor_limits import MotorLimits
from surefoot.robot.symbolic_body import SymbolicBody

ROUND = 1e-3
"""Rounds the cone's tip, as a share of m g: sqrt(f_t² + ROUND²) has a slope there."""
TRUNK_DEPTH = 0.3
"""Half the height of the box that stands for the trunk, as a share of its half length."""


@dataclass(frozen=True)
class Parts:
    """Where the rows of a knot are: name to slice, in the order that they were written.

    Attributes
    ----------
    rows
        Slices of a block's rows.
    count
        Number of rows.
    """

    rows: dict[str, slice]
    count: int


def transcribe(problem: ScheduleProblem) -> tuple[Block, Parts]:
    """Return the block of a problem's knots, and where its rows are.

    Variables: x = (q, v), u = (torques as shares of their limits, forces in contact axes as shares of m g).
    """
    ca, robot = import_casadi(), problem.robot
    body, dt, weight = SymbolicBody(robot.model, robot.contact_points), problem.dt, problem.weight
    nq, n, p = body.nq, body.nv, body.points
    x, after = ca.SX.sym("x", nq + n), ca.SX.sym("after", nq + n)
    q, v, q_after, v_after = x[:nq], x[nq:], after[:nq], after[nq:]
    u = ca.SX.sym("u", robot.joints + 3 * p)
    torques = u[: robot.joints] * ca.DM(problem.torque_limits)
    shares = ca.reshape(u[robot.joints :], 3, p)
    frame = problem.terrain.frame([0.0, 0.0])
    normal = frame[:, 2]
    height = float(problem.terrain.height([0.0, 0.0])) * normal[2]
    effort = body.inverse_dynamics(q, v, (v_after - v) / dt, weight * ca.mtimes(ca.DM(frame), shares), normal)
    motors = ca.vertcat(ca.SX.zeros(robot.base_dof), torques)
    slope = ca.DM(frame[:, 2:].T)
    above = ca.DM(robot.contact_points.radii + height).T
    gaps = ca.mtimes(slope, body.sphere_centres(q)) - above
    seen = ca.mtimes(ca.DM(frame.T), body.point_velocities(q, v_after, normal))
    joints, places = body_corners(robot)
    size = ca.sqrt(shares[0, :] ** 2 + shares[1, :] ** 2 + ROUND**2)
    named = {
        "dynamics": (effort - motors) / weight,
        "motion": (q_after - body.integrate(q, dt * v_after)) / dt,
        "normal": (gaps / dt + seen[2, :]).T,
        "tangential": ca.reshape(seen[:2, :], 2 * p, 1),
        "cone": (problem.mu * shares[2, :] - size).T,
        "gap": (ca.mtimes(slope, body.sphere_centres(q_after)) - above).T,
        "corners": (ca.mtimes(slope, body.body_points(q_after, joints, places)) - height).T,
    }
    if problem.leg_gap > 0.0:
        named["legs"] = _leg_gaps(robot, body, q_after)
    if problem.stance_reach > 0.0:
        named["reach"] = _reach(robot, body, q_after)
    if np.isfinite(problem.touchdown_speed):
        before = ca.mtimes(ca.DM(frame.T), body.point_velocities(q, v, normal))
        named["touchdown"] = ca.reshape(before, 3 * p, 1)
    if problem.motors is not None:
        named["motors"] = _motor_use(
            problem.motors, torques, (v[robot.base_dof :], v_after[robot.base_dof :])
        )
    reference = ca.SX.sym("reference", nq)
    cost = _cost(problem, (q_after - reference, v_after, v_after - v), u)
    if problem.weights.symmetry:
        cost += problem.dt * problem.weights.symmetry * _difference(problem, q_after)
    rows, at = dict[str, slice](), 0
    for name, part in named.items():
        rows[name] = slice(at, at + int(part.shape[0]))
        at = rows[name].stop
    nothing = ca.SX.sym("nothing", 0)
    block = Block(x, u, after, nothing, ca.vertcat(*named.values()), cost, reference)
    return block, Parts(rows, at)


def _cost(problem: ScheduleProblem, state: tuple[Any, Any, Any], u: Any) -> Any:
    """Return the cost of a knot: of the distance from its reference, the velocity and its change, of u."""
    ca, w, robot = import_casadi(), problem.weights, problem.robot
    off, v, change = state
    running = w.position * ca.sumsqr(off[:3]) + w.orientation * ca.sumsqr(off[3:7])
    running += w.joints * ca.sumsqr(off[7:])
    running += w.velocity * (ca.sumsqr(v[:6]) + 0.1 * ca.sumsqr(v[6:]))
    running += w.torque * ca.sumsqr(u[: robot.joints]) + w.force * ca.sumsqr(u[robot.joints :])
    return problem.dt * running + w.change * ca.sumsqr(change)


def _difference(problem: ScheduleProblem, q: Any) -> Any:
    """Return what differs between left and right of a configuration, squared."""
    ca = import_casadi()
    other, sign = mirrored_joints(problem.robot)
    joints = q[7:]
    swapped = ca.vertcat(*(float(s) * joints[int(k)] for k, s in zip(other, sign, strict=True)))
    base = ca.vertcat(q[1] - problem.q[1], 2.0 * q[3], 2.0 * q[5])
    return ca.sumsqr(base) + 0.5 * ca.sumsqr(joints - swapped)


def body_corners(robot: Robot) -> tuple[IntArray, FloatArray]:
    """Return points that must not touch the ground: (m,) joints that carry them, (m, 3) places [m].

    The joints above the feet, and the corners of a box about the trunk as long and wide as the legs' first
    joints stand apart.
    """
    model, points = robot.model, robot.contact_points
    knees = np.unique(points.joints)
    hips = [model.jointPlacements[k].translation for k in range(2, model.njoints) if model.parents[k] == 1]
    half = np.abs(np.array(hips)).max(axis=0)
    half[2] = TRUNK_DEPTH * half[0]
    signs = np.array(np.meshgrid([1.0, -1.0], [1.0, -1.0], [1.0, -1.0])).reshape(3, -1).T
    joints = np.concatenate([knees, np.ones(len(signs), dtype=np.int64)])
    return joints, np.vstack([np.zeros((len(knees), 3)), signs * half])


def _leg_gaps(robot: Robot, body: SymbolicBody, q: Any) -> Any:
    """Return how far knees and feet of rear legs are behind those of front legs on their side (m, 1) [m]."""
    ca, points = import_casadi(), robot.contact_points
    order = quadruped_order(robot)
    number = [int(np.flatnonzero(points.foot == k)[0]) for k in order]
    joints = np.repeat(points.joints[number], 2)
    places = np.zeros((8, 3))
    places[1::2] = points.places[number]
    seen = body.body_points(q, [*joints.tolist(), 1], np.vstack([places, np.zeros(3)]))
    ahead = body.body_points(q, [1], np.array([[1.0, 0.0, 0.0]])) - seen[:, 8]
    along = ca.mtimes(ahead.T, seen[:, :8])
    pairs = [(2 * k + a, 2 * k + 4 + b) for k in (0, 1) for a in (0, 1) for b in (0, 1)]
    return ca.vertcat(*(along[front] - along[rear] for front, rear in pairs))


def _reach(robot: Robot, body: SymbolicBody, q: Any) -> Any:
    """Return how far contact points are below the base's origin along the base's own z axis (p, 1) [m]."""
    ca, points = import_casadi(), robot.contact_points
    seen = body.body_points(
        q, [*points.joints.tolist(), 1, 1], np.vstack([points.places, [0.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    )
    feet, base = seen[:, : len(points)], seen[:, len(points)]
    up = seen[:, len(points) + 1] - base
    return ca.mtimes((ca.repmat(base, 1, len(points)) - feet).T, up)


def _motor_use(motors: MotorLimits, torques: Any, speeds: tuple[Any, Any]) -> Any:
    """Return what must be from -1 to 1 for motors to give torques at a knot's two speeds (2 joints, 1).

    The falling part of a torque-speed curve, driving (1 - speed) / (1 - knee) along the motion as shares of
    the limits, is a straight line that bounds nothing against the motion: two half spaces, no cases.
    """
    ca = import_casadi()
    steep = (1.0 - motors.knee) / motors.driving
    load = steep * torques / ca.DM(motors.effort)
    return ca.vertcat(*(load + speed / ca.DM(motors.speed) for speed in speeds))


def row_bounds(problem: ScheduleProblem, parts: Parts) -> Sides:
    """Return the bounds (knots, m) of all rows; both infinite where a row does not matter."""
    n, stance = problem.knots, problem.stance
    low = np.full((n, parts.count), -np.inf)
    high = -low
    rows = parts.rows
    for name in ("dynamics", "motion"):
        low[:, rows[name]] = high[:, rows[name]] = 0.0
    low[:, rows["normal"]] = 0.0
    high[:, rows["normal"]] = np.where(stance, 0.0, np.inf)
    still = np.repeat(stance, 2, axis=1)
    low[:, rows["tangential"]] = np.where(still, 0.0, -np.inf)
    high[:, rows["tangential"]] = np.where(still, 0.0, np.inf)
    low[:, rows["cone"]] = np.where(stance, -ROUND, -np.inf)
    low[:, rows["gap"]] = swing_heights(problem)
    if problem.leg_gap > 0.0:
        low[:, rows["legs"]] = problem.leg_gap
    if problem.stance_reach > 0.0:
        low[:, rows["reach"]] = np.where(stance, problem.stance_reach, -np.inf)
    if np.isfinite(problem.touchdown_speed):
        landing = stance & ~np.vstack([stance[:1], stance[:-1]])
        most = np.where(np.repeat(landing, 3, axis=1), problem.touchdown_speed, np.inf)
        low[:, rows["touchdown"]], high[:, rows["touchdown"]] = -most, most
    if problem.motors is not None:
        low[:, rows["motors"]], high[:, rows["motors"]] = -problem.motor_share, problem.motor_share
    knees = len(np.unique(problem.robot.contact_points.joints))
    least = np.full(rows["corners"].stop - rows["corners"].start, problem.body_clearance)
    least[:knees] = problem.knee_clearance
    low[:, rows["corners"]] = least
    return low, high


def swing_heights(problem: ScheduleProblem) -> FloatArray:
    """Return the least gap (knots, p) at the end of every knot: half a sine over a flight, none in stance."""
    stance = problem.stance
    out = np.full(stance.shape, -np.inf)
    for point in range(stance.shape[1]):
        on = np.concatenate([[True], stance[:, point], [True]])
        edges = np.flatnonzero(np.diff(on.astype(np.int8)))
        for begin, end in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
            share = np.arange(1, end - begin + 1) / (end - begin + 1)
            out[begin:end, point] = problem.clearance * np.sin(np.pi * share)
    return out


def variable_bounds(problem: ScheduleProblem) -> Sides:
    """Return the bounds of all variables, (n,) each, in the order of the NLP."""
    robot, model, n = problem.robot, problem.robot.model, problem.knots
    nq, nx = int(model.nq), int(model.nq + model.nv)
    low = np.full((n + 1, nx), -np.inf)
    high = -low
    limit_joints(robot, low, high, problem.speed_share)
    for k, window in problem.windows.items():
        window.narrow(low[k], high[k], nq, k)
    low[0] = high[0] = np.concatenate([problem.q, problem.v])
    force = np.repeat(problem.stance, 3, axis=1)
    most = np.where(force, np.inf, 0.0)
    least = -most
    least[:, 2::3] = problem.stance * (problem.force_min / problem.weight)
    ones = np.ones((n, robot.joints))
    return pack(low, np.hstack([-ones, least])), pack(high, np.hstack([ones, most]))
