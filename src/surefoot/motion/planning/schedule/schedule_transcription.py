"""A scheduled motion as an NLP: the exact step's equations with the contact modes of the schedule.

The step is that of `transcription.knot`. A foot that stands has gap / dt + u_n = 0, u_t = 0 and its force
inside the friction cone; one that does not has no force and gap / dt + u_n >= 0. Those are the laws of
contact for feet that stick or are in the air, so that the torques of a solution lead through the exact step
to the same motion.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.libraries import import_casadi
from surefoot.base.numerics.phases import runs_of
from surefoot.mechanics import MotorLimits, Robot, body_corners, quadruped_order, velocity_of_way
from surefoot.motion.planning.schedule.mirror import robot_reflections
from surefoot.motion.planning.schedule.schedule_problem import ScheduleProblem
from surefoot.motion.planning.symbolic.rigid_body import SymbolicBody
from surefoot.motion.planning.transcription.nlp import Block, Sides, pack
from surefoot.motion.planning.transcription.state_window import limit_joints
from surefoot.motion.planning.transcription.symbolic_knot import Row, SymbolicKnot, stack_rows

ROUND = 1e-3
"""Rounds the cone's tip, as a share of m g: sqrt(f_t² + ROUND²) has a slope there."""

SHANK = (0.25, 0.5, 0.75)
"""Where shanks are looked at on their way over an edge, as shares of the way from foot to knee: between two
such places of Go2's there are 5 cm, less than steps are taken for wider (`AHEAD`)."""


def transcribe(problem: ScheduleProblem) -> tuple[Block, Sides]:
    """Return the block of a problem's knots, and the bounds (knots, m) of its rows.

    Variables: x = (q, v), u = (torques as shares of their limits, forces in contact axes as shares of m g).
    """
    ca, robot, stance, inf = import_casadi(), problem.robot, problem.stance, np.inf
    knot, dt, weight = SymbolicKnot(robot, problem.terrain, problem.dt), problem.dt, problem.weight
    body, q_after, v_after = knot.body, knot.q_after, knot.v_after
    p = body.points
    u = ca.SX.sym("u", robot.joints + 3 * p)
    torques = u[: robot.joints] * ca.DM(problem.torque_limits)
    shares = ca.reshape(u[robot.joints :], 3, p)
    speeds = knot.point_speeds(knot.q, v_after)
    slip = np.where(np.repeat(stance, 2, axis=1), 0.0, inf)
    # The cone in newtons over m g; its tip is rounded, since the norm has no slope at zero force, where every
    # swing ends. The row below gives the rounding back, sqrt(f² + r²) - r <= mu f_n, so that forces leave the
    # cone by less than r.
    size = ca.sqrt(shares[0, :] ** 2 + shares[1, :] ** 2 + ROUND**2)
    joints, places = body_corners(robot)
    above = body.body_points(q_after, joints, places)
    corners = ca.mtimes(ca.DM(knot.frame[:, 2:].T), above) - knot.height
    least = np.full(len(joints), problem.body_clearance)
    least[: len(np.unique(robot.contact_points.joints))] = problem.knee_clearance
    swung, heights = knot.gaps(q_after), problem.heights
    if problem.passed is not None:
        # the knot's gaps are to height 0, of which the bounds of feet that stand know
        centres, knees = body.sphere_centres(q_after), np.unique(robot.contact_points.joints)
        swung = swung - problem.passed.smooth(centres[0, :])
        own = np.searchsorted(knees, robot.contact_points.joints).tolist()
        along = [centres + share * (above[:, own] - centres) for share in SHANK]
        above = ca.horzcat(*along, above)
        corners = above[2, :] - problem.passed.smooth(above[0, :])
        least = np.concatenate([np.repeat(np.multiply(SHANK, problem.knee_clearance), p), least])
    rows: list[Row] = [
        (knot.missing_effort(weight * knot.world(shares), torques) / weight, 0.0, 0.0),
        (knot.missed_way() / dt, 0.0, 0.0),
        ((knot.gaps(knot.q) / dt + speeds[2, :]).T, heights / dt, np.where(stance, heights / dt, inf)),
        (ca.reshape(speeds[:2, :], 2 * p, 1), -slip, slip),
        ((problem.mu * shares[2, :] - size).T, np.where(stance, -ROUND, -inf), inf),
        (swung.T, swing_heights(problem), inf),
        (corners.T, least, inf),
    ]
    for axis, least_gap in enumerate((problem.leg_gap, problem.leg_spread)):
        if least_gap > 0.0:
            gaps = _leg_gaps(robot, body, q_after, axis)
            least = np.full((problem.knots, gaps.shape[0]), least_gap)
            least[:, 8:] = np.where(_reared(problem)[:, None], problem.hip_gap, -inf)
            rows.append((gaps, least, inf))
    if problem.stance_reach > 0.0:
        rows.append((_reach(robot, body, q_after), np.where(stance, problem.stance_reach, -inf), inf))
    if np.isfinite(problem.touchdown_speed):
        # The speed with which a foot arrives is that at the start of its first knot of stance.
        landing = stance & ~np.vstack([stance[:1], stance[:-1]])
        most = np.where(np.repeat(landing, 3, axis=1), problem.touchdown_speed, inf)
        rows.append((ca.reshape(knot.point_speeds(knot.q, knot.v), 3 * p, 1), -most, most))
    if problem.motors is not None:
        use = _motor_use(problem.motors, torques, (knot.v[robot.base_dof :], v_after[robot.base_dof :]))
        rows.append((use, -problem.motor_share, problem.motor_share))
    reference = ca.SX.sym("reference", body.nq)
    cost = _cost(problem, (q_after - reference, v_after, v_after - knot.v), u)
    if problem.weights.symmetry:
        cost += problem.dt * problem.weights.symmetry * _difference(problem, q_after)
    expression, bounds = stack_rows(rows, problem.knots)
    return Block(knot.x, u, knot.after, ca.SX.sym("nothing", 0), expression, cost, reference), bounds


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
    ca, place = import_casadi(), robot_reflections(problem.robot)[0]
    apart = ca.mtimes(ca.sparsify(ca.DM(np.eye(len(place)) - place)), q)
    return (0.5 * apart[1] - problem.q[1]) ** 2 + ca.sumsqr(apart[3:7]) + 0.5 * ca.sumsqr(apart[7:])


def _reared(problem: ScheduleProblem) -> BoolArray:
    """Return in which knots (knots,) feet stand, and no front one: rear thighs come up to those."""
    front = np.isin(problem.robot.contact_points.foot, quadruped_order(problem.robot)[:2])
    return np.asarray(problem.stance.any(axis=1) & ~problem.stance[:, front].any(axis=1))


def _leg_gaps(robot: Robot, body: SymbolicBody, q: Any, axis: int) -> Any:
    """Return how far apart knees and feet of neighbouring legs are along an axis of the base (m, 1) [m].

    Axis 0: how far those of rear legs are behind those of front legs on their side, and last their hips
    behind front feet; axis 1: how far those of right legs are to the right of left ones.
    """
    ca, points = import_casadi(), robot.contact_points
    order = quadruped_order(robot)
    number = [int(np.flatnonzero(points.foot == k)[0]) for k in order]
    joints = np.repeat(points.joints[number], 2).tolist()
    hips = [int(robot.model.parents[knee]) for knee in joints[4::2]]
    places = np.zeros((8, 3))
    places[1::2] = points.places[number]
    seen = body.body_points(q, [*joints, *hips, 1], np.vstack([places, np.zeros((3, 3))]))
    ahead = body.body_points(q, [1], np.eye(3)[[axis]]) - seen[:, 10]
    along = ca.mtimes(ahead.T, seen[:, :10])
    legs = ((0, 2), (1, 3)) if axis == 0 else ((0, 1), (2, 3))
    pairs = [(2 * one + a, 2 * other + b) for one, other in legs for a in (0, 1) for b in (0, 1)]
    pairs += [(1, 8), (3, 9)] if axis == 0 else []
    return ca.vertcat(*(along[one] - along[other] for one, other in pairs))


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


def swing_heights(problem: ScheduleProblem) -> FloatArray:
    """Return the least gap (knots, p) at the end of every knot: half a sine over a flight, none in stance."""
    stance = problem.stance
    out = np.full(stance.shape, -np.inf)
    for point in range(stance.shape[1]):
        for begin, end in runs_of(~stance[:, point]):
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
    # The start's velocity is that of an instant; knots count with that of the way which led there.
    low[0] = high[0] = np.concatenate([problem.q, velocity_of_way(model, problem.q, problem.v, problem.dt)])
    force = np.repeat(problem.stance, 3, axis=1)
    most = np.where(force, np.inf, 0.0)
    least = -most
    least[:, 2::3] = problem.stance * (problem.force_min / problem.weight)
    ones = np.ones((n, robot.joints))
    return pack(low, np.hstack([-ones, least])), pack(high, np.hstack([ones, most]))
