"""Known motions as scheduled problems for any quadruped: jumps along the ground or up, a backflip.

Times scale with sqrt(h / g) for legs of height h, so that small and large robots move alike; numbers are
those of a robot of Go2's size.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.spatial import (
    GRAVITY,
    quaternion_about,
    quaternion_from_rotation,
    rotation_about,
    rotation_from_quaternion,
)
from surefoot.mechanics import FlatTerrain, Legs, Robot, Terrain, motor_limits, place, quadruped_order
from surefoot.motion.gaits.gait import ModeSchedule
from surefoot.motion.planning.schedule.mirror import own_image
from surefoot.motion.planning.schedule.schedule_problem import ScheduleProblem, ScheduleWeights
from surefoot.motion.planning.stepped_ground import AHEAD, climb_of
from surefoot.motion.planning.transcription.state_window import StateWindow

LEG = 0.33
"""Height of the base that the times below are for [m]."""
PUSH, LAND = 0.4, 0.5
"""Time on the ground before and after a flight [s]."""
FLIGHT, QUICK = 0.3, 0.75
"""Longest flight of a jump forward [s], and share of the speed at which the legs can lift the body that a
flight may begin with: joints that are at their limits push no more."""
LEAD, LONGER = 0.134, 1.25
"""How much longer the feet that go ahead onto a step as high as the base are in the air, before and after the
flight [s], and how much longer than others such a flight would be without that: with all feet at once next to
no motion onto 0.25 m is found. Lower steps take their share of it."""
ONTO = {"joints": 10.0, "symmetry": 50.0}
"""Weights of a jump onto a step: with less on their posture front legs are swung through the rear ones, and
left and right legs without a price on what differs are thrown about one by one."""
WIDE, HIP = 0.42, 0.5
"""How far apart left and right legs stay on the way there, and rear hips behind front feet, as shares of the
base's height: bent legs are wider than their knees and feet."""
REAR, TURN, FRONT = 0.24, 0.34, 0.24
"""Time on the rear feet, in the air, and on the front feet, of a backflip [s]."""
RISE = 0.3
"""How much higher than where it stands the base is expected in the middle of a backflip [m]."""
QUIET = 1e-2
"""Weight of changes of velocity in a jump up: with ten times less its search takes twice as long."""
KNOT = 0.01
"""Length of a knot [s]."""
REST = 0.01
"""Largest speed at the end [m/s, rad/s]. With none at all Ipopt creeps: feet whose gaps are closed before and
after the last motion, to second order, admit next to none of it, and its rows have no slope there."""
LIKELY = 0.75
"""Share of the ground's friction that a plan counts on."""
GAP = 0.4
"""How far the rear legs stay behind the front ones when they are tucked, as a share of the base's height."""
ABDUCTION, FOLD = 0.12, 0.12
"""How far hips may turn in a flight from where they stand [rad]; share of its range that a knee leaves."""
LOAD = 0.05
"""Least normal force of a foot that stands, as a share of m g: a foot without any might as well lift off."""
SOFTLY, REACH = 0.4, 0.3
"""Speed of the feet that land from a backflip [m/s]; how far below the base feet stand in it, as a share of
its height."""
HEAD = 0.45
"""How near the ground the trunk's corners may come where it is upside down: heads reach beyond them."""
TUCK = 0.45
"""How far feet are expected to be drawn up on the way onto a step, as a share of the base's height."""
APART, SPREAD = 0.15, 0.25
"""How far rear legs stay behind front ones in a jump, and right legs from left ones, as such shares."""
BODY, KNEE = 0.18, 0.15
"""How near the ground the trunk and the joints above the feet may come, as shares of the base's height."""


def time_scale(robot: Robot) -> float:
    """Return by how much motions take longer than a robot's of Go2's size: sqrt(h / `LEG`)."""
    return math.sqrt(float(robot.nominal[2]) / LEG)


def lift_speed(robot: Robot, q: FloatArray) -> float:
    """Return how fast legs in the pose of (nq,) q can lift the body from standing feet [m/s].

    Straight up in the base's axes; the joint that first runs at its limit decides.
    """
    # Joint rates per speed of the foot along z: the third column of the leg's inverse Jacobian. A foot on the
    # ground moves against the body, and the sign plays no part in what is the first limit.
    rates = [np.linalg.pinv(slope)[:, 2] for slope in Legs(robot).slopes(q[7:])]
    return float(1.0 / np.abs(np.array(rates) / robot.speed_limits).max())


def modes(robot: Robot, phases: list[tuple[float, str]]) -> tuple[ModeSchedule, float]:
    """Return the schedule of (duration [s], feet) and its length; feet: "all", "front", "rear" or "none"."""
    order = quadruped_order(robot)
    table = np.zeros((len(phases), len(order)), dtype=bool)
    for row, (_, feet) in zip(table, phases, strict=True):
        row[{"all": order, "front": order[:2], "rear": order[2:], "none": []}[feet]] = np.True_
    ends = np.cumsum([length for length, _ in phases])
    return ModeSchedule(ends[:-1], table, max_flight=math.inf), float(ends[-1])


def jump(
    robot: Robot,
    distance: float,
    height: float,
    mu: float,
    dt: float | None = None,
    way: tuple[float, float] = (0.0, 0.0),
    q: FloatArray | None = None,
    terrain: Terrain | None = None,
) -> ScheduleProblem:
    """Return a jump that carries the feet by a distance along a direction, the base up by a height [m].

    Parameters
    ----------
    robot, distance, height, mu, dt
        Who jumps, and how far and high; dt of None is that of the robot's size.
    way
        Direction of the jump from straight ahead to the left, and turn of the robot to the left [rad].
    q
        (nq,) the start; None for the nominal pose on the terrain, before steps that it begins with.
    terrain
        A plane, or level ground in steps along x; None for flat ground.

    Raises
    ------
    ProblemError
        For a robot that is no quadruped, and a jump that is none.
    """
    scale, ground = time_scale(robot), FlatTerrain() if terrain is None else terrain
    q = begun(robot, ground, distance) if q is None else q
    end = landing_configuration(robot, q, distance, way, ground)
    end[2] += (climb := climb_of(ground, robot, q, end))
    # A body that leaves the ground at v and lands at the same height flies for 2 v / g, one that rises by h
    # for at least 2 sqrt(2 h / g).
    longest = min(FLIGHT * scale, 2.0 * QUICK * lift_speed(robot, q) / GRAVITY)
    flight = max(longest, 2.0 * math.sqrt(2.0 * max(height, 0.0) / GRAVITY))
    dt = round(KNOT * scale, 3) if dt is None else dt
    push, land = PUSH * scale, LAND * scale
    over = [(flight, "none")]
    if climb > 0.0:
        over = _step_up(flight, LEAD * scale * climb / float(robot.nominal[2]), distance * math.cos(way[0]))
        flight = sum(length for length, _ in over)
    schedule, length = modes(robot, [(push, "all"), *over, (land, "all")])
    knots = round(length / dt)
    t = dt * np.arange(knots + 1, dtype=np.float64)
    flown = np.clip(t - push, 0.0, flight)
    up = rotation_from_quaternion(q[3:7]).T @ np.asarray(ground.normal(q[:2]))
    reference = _jump_reference(q, end, t, push, flight, (up, way[1]))
    # At the end: 1 cm ahead, 2 cm aside and in height, 0.015 in a quaternion's entries (1.7 degrees), and
    # 0.02 rad of each joint.
    within = np.concatenate([[0.01, 0.02, 0.02], np.full(4, 0.015), np.full(robot.joints, 0.02)])
    windows = {knots: StateWindow.at(reference[-1], np.zeros(robot.model.nv), within, REST)}
    if height > 0.0:  # reached in the middle of the flight at the latest
        low = np.full(len(q), -np.inf)
        low[2] = q[2] + height
        windows[round((push + 0.5 * flight) / dt)] = StateWindow(low)
    weights = ScheduleWeights(change=QUIET) if max(height, climb) > 0.0 else ScheduleWeights()
    if climb > 0.0:
        _tuck(robot, reference, min(climb, TUCK * float(robot.nominal[2])) * np.sin(math.pi * flown / flight))
        weights = replace(weights, **ONTO)
        if not own_image(robot, reference):  # a price on what differs would forbid the way that it goes
            weights = replace(weights, symmetry=0.0)
    reach = float(robot.nominal[2])
    return ScheduleProblem(
        robot, schedule, dt, knots, q, np.zeros(robot.model.nv), reference, windows, weights,
        LIKELY * mu, ground, torque_share=0.8, speed_share=0.8, motors=motor_limits(robot, "curve"),
        clearance=(0.12 if climb > 0.0 else 0.06) * reach,
        force_min=LOAD * robot.mass * GRAVITY, leg_gap=APART * reach,
        touchdown_speed=SOFTLY if climb > 0.0 else math.inf, hip_gap=HIP * reach,
        leg_spread=(WIDE if climb > 0.0 else SPREAD) * reach, body_clearance=BODY * reach,
        knee_clearance=KNEE * reach,
    )  # fmt: skip


def _jump_reference(
    q: FloatArray, end: FloatArray, t: FloatArray, push: float, flight: float, turn: tuple[FloatArray, float]
) -> FloatArray:
    """Return the reference (k, nq) of a jump from q to `end` at (k,) times [s].

    Parameters
    ----------
    q, end
        (nq,) where it begins and lands.
    t, push, flight
        (k,) times, and those of the push and of the flight after it [s].
    turn
        (3,) axis of the robot's turn in its own axes, and angle [rad].
    """
    # The reference begins to move in the last 30 % of the push and has arrived 10 % of it after touchdown:
    # there the body accelerates and brakes. The optimiser is free to do otherwise.
    share = np.clip((t - 0.7 * push) / (flight + 0.4 * push), 0.0, 1.0)
    reference = np.tile(q, (len(t), 1))
    reference[:, :3] += share[:, None] * (end - q)[:3]
    # The parabola of free fall over the flight, zero at both ends: g/2 t (T - t).
    flown = np.clip(t - push, 0.0, flight)
    reference[:, 2] += 0.5 * GRAVITY * flown * (flight - flown)
    reference[:, 3:7] = _rotate_about(q[3:7], turn[0], turn[1] * share)
    return reference


def _step_up(flight: float, lead: float, ahead: float) -> list[tuple[float, str]]:
    """Return the phases of a flight [s] onto a step `ahead`: feet that go ahead leave and land first."""
    # The longer flight is spread over three phases, and half a `lead` of it is taken back: the body is over
    # the edge while two feet still push or push already.
    behind, first = ("rear", "front") if ahead > 0.0 else ("front", "rear")
    return [(lead, behind), (LONGER * flight - 1.5 * lead, "none"), (lead, first)]


def _tuck(robot: Robot, reference: FloatArray, lifts: FloatArray) -> None:
    """Draw the feet of (k, nq) configurations up by (k,) `lifts` [m], from where the first has them."""
    legs, start = Legs(robot), reference[0, 7:].copy()
    up, feet = np.array([0.0, 0.0, 1.0]), legs.feet(start)
    for k in np.flatnonzero(lifts):
        reference[k, 7:] = legs.reach(feet + lifts[k] * up, start)


def begun(robot: Robot, terrain: Terrain, distance: float) -> FloatArray:
    """Return the default start (nq,) of a jump: its landing is just beyond a step."""
    feet = robot.foot_positions(robot.nominal)[:, 0]
    before = max(distance + feet.min() - 2.0 * AHEAD, feet.max() + 2.0 * AHEAD)
    return place(robot, terrain, at=terrain.approach(before))


def landing_configuration(
    robot: Robot, q: FloatArray, distance: float, way: tuple[float, float], terrain: Terrain
) -> FloatArray:
    """Return the configuration (nq,) in which a jump lands on ground without steps.

    The robot turns about the middle of its feet.

    `way` holds the direction of the jump and its turn [rad].
    """
    feet, (direction, turn) = robot.foot_positions(q), way
    # Directions are measured in the plane of the ground, from the projection of the base's x axis on it.
    middle, frame = feet.mean(axis=0), terrain.frame(q[:2])
    ahead = frame.T @ rotation_from_quaternion(q[3:7])[:, 0]
    along = math.atan2(ahead[1], ahead[0]) + direction
    shift = distance * frame @ [math.cos(along), math.sin(along), 0.0]
    rotation = rotation_about(frame[:, 2], turn)
    end = q.copy()
    end[:3] = middle + rotation @ (q[:3] - middle) + shift
    end[3:7] = quaternion_from_rotation(rotation @ rotation_from_quaternion(q[3:7]))
    return end


def backflip(
    robot: Robot, mu: float, dt: float | None = None, q: FloatArray | None = None
) -> ScheduleProblem:
    """Return a full turn backwards from (nq,) q: all feet push, then the rear ones; the front ones land.

    The landing is the push the other way round. Feet that all land at once would have to take out the
    angular momentum of the turn, about 0.4 kg m² times 280 degrees over the flight, within a few
    centimetres: with it the rear hips come down at some 4 m/s, where Go2's knees allow 2.6.

    Raises
    ------
    ProblemError
        For a robot that is no quadruped.
    """
    scale = time_scale(robot)
    push, rear, flight, front, land = (scale * time for time in (PUSH, REAR, TURN, FRONT, LAND))
    dt = round(KNOT * scale, 3) if dt is None else dt
    parts = [(push, "all"), (rear, "rear"), (flight, "none"), (front, "front"), (land, "all")]
    schedule, length = modes(robot, parts)
    knots = round(length / dt)
    q = place(robot) if q is None else q
    t, nv = dt * np.arange(knots + 1), int(robot.model.nv)
    share = np.clip((t - push) / (rear + flight + front), 0.0, 1.0)
    reference = np.tile(q, (knots + 1, 1))
    # One turn about -y at constant rate, from the lift-off of the front feet to the touchdown of the rear
    # ones; the base moves back by 0.6 of its height, about as far as it pivots over its rear feet.
    reference[:, 0] -= 0.6 * float(robot.nominal[2]) * share
    reference[:, 2] += RISE * (0.5 - 0.5 * np.cos(2.0 * math.pi * share))
    reference[:, 3:7] = _rotate_about(q[3:7], np.array([0.0, 1.0, 0.0]), -2.0 * math.pi * share)
    reach = float(robot.nominal[2])
    # Where along x it lands is left to the optimiser, and joints end within 0.12 rad: it has to stand, not to
    # stand in a given place.
    within = np.concatenate([[1.05 * reach, 0.02, 0.03], np.full(4, 0.03), np.full(robot.joints, 0.12)])
    end = StateWindow.at(reference[-1], np.zeros(nv), within, REST)
    touchdown = round((push + rear + flight) / dt)
    # Between lift-off and touchdown nothing else would keep legs from passing through each other.
    windows = {k: _spread(robot, q) for k in range(round((push + rear) / dt), touchdown)}
    windows |= {knots: end}
    weights = ScheduleWeights(
        position=0.1, orientation=1.0, joints=0.05, velocity=0.002, change=1e-4, symmetry=50.0
    )
    return ScheduleProblem(
        robot, schedule, dt, knots, q, np.zeros(nv), reference,
        windows, weights, LIKELY * mu, torque_share=0.75, speed_share=0.7,
        motors=motor_limits(robot, "curve"), motor_share=0.9, touchdown_speed=SOFTLY,
        stance_reach=REACH * reach, clearance=0.06 * reach,
        force_min=2.0 * LOAD * robot.mass * GRAVITY, leg_gap=GAP * reach, hip_gap=GAP * reach,
        body_clearance=HEAD * reach, knee_clearance=KNEE * reach,
    )  # fmt: skip


def _spread(robot: Robot, q: FloatArray) -> StateWindow:
    """Return where legs may be in a flight: abducted about as in (nq,) q, knees not bent to their stops."""
    model = robot.model
    low, high = np.full(int(model.nq), -np.inf), np.full(int(model.nq), np.inf)
    hips = [int(model.joints[k].idx_q) for k in range(2, model.njoints) if model.parents[k] == 1]
    low[hips], high[hips] = q[hips] - ABDUCTION, q[hips] + ABDUCTION
    for knee in {int(model.joints[int(j)].idx_q) for j in robot.contact_points.joints}:
        least, most = float(model.lowerPositionLimit[knee]), float(model.upperPositionLimit[knee])
        if q[knee] < 0.0:
            low[knee] = least + FOLD * (most - least)
        else:
            high[knee] = most - FOLD * (most - least)
    return StateWindow(low, high)


def _rotate_about(quaternion: FloatArray, axis: FloatArray, angle: FloatArray) -> FloatArray:
    """Return a quaternion after turns about its own (3,) axis (T, 4); a full turn changes its sign."""
    turn, v, w = quaternion_about(axis, angle), quaternion[:3], quaternion[3]
    s, c = turn[:, :3], turn[:, 3:]
    # Hamilton product: turns about the body's own axis stand on the right
    return np.hstack([w * s + c * v + np.cross(v, s), w * c - (s @ v)[:, None]])
