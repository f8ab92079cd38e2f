"""What legs do in the air: follow the plan, then reach for where the body will need its feet.

A robot in flight cannot choose where its weight goes, only where its feet will be when it lands. From the
state now, the moment is predicted when the centre of mass sinks to the planned height of the touchdown, and
the body's attitude then. The feet are placed around the centre of mass as the plan has them at touchdown,
level with the ground whatever the body's attitude is, and further out by what the body is faster than
planned times sqrt(h / g), as a capture point is (Pratt et al., "Capture point", Humanoids 2006).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.spatial import GRAVITY, rotation_about, rotation_log
from surefoot.mechanics import Legs, Robot
from surefoot.motion.control.whole_body import Kinematics
from surefoot.motion.planning.tracking.reference import Reference
from surefoot.motion.walking.swing import minimum_jerk

PREPARE, READY = 0.25, 0.07
"""Legs begin and end to reach for the landing so long before the touchdown [s]."""
FURTHEST = 0.12
"""Most that feet are moved from where the plan has them at touchdown [m]."""
LEAD = 0.015
"""So long before the touchdown feet are level with the ground under the attitude of that moment [s]: a body
that still turns would put some of them down too early."""
SOFT, EXTRA = 0.7, 0.08
"""Speed with which feet meet the ground, while the legs give way with the rest of the body's [m/s], and how
much further down they reach before that [m]."""
SLACK, MOST_TURN = 0.03, 0.5
"""Of the way that soft landings are corrected: damping [m/rad], and most of any joint [rad]."""
SPEED_SHARE = 0.9
"""Share of a joint's speed limit that targets in the air may move with."""


FOLLOW = 1.5
"""Rate with which joints follow their targets, over that with which the targets follow the plan."""


class Targets(NamedTuple):
    """Wanted angles, speeds and accelerations of the joints, (joints,) each [rad, rad/s, rad/s²]."""

    angles: FloatArray
    speeds: FloatArray
    accelerations: FloatArray


@dataclass(frozen=True)
class Touchdown:
    """What the plan has at the end of a flight; around the centre of mass, world axes.

    Attributes
    ----------
    start, end
        Of the flight [s].
    feet
        (n, 3) centres of the feet [m].
    height
        Of the centre of mass [m].
    velocity
        (3,) of the centre of mass [m/s].
    rotation
        (3, 3) of the base.
    joints
        (joints,) angles [rad].
    landing
        (n,) the feet that stand then.
    soft
        Whether the plan's own legs give way before they land: they are followed as they are.
    attitude
        Planned attitude (3, 3) at a time of the flight.
    """

    start: float
    end: float
    feet: FloatArray
    height: float
    velocity: FloatArray
    rotation: FloatArray
    joints: FloatArray
    landing: BoolArray
    soft: bool
    attitude: Callable[[float], FloatArray]


def touchdowns(reference: Reference) -> list[Touchdown]:
    """Return the ends of a motion's airborne phases."""
    robot, out = reference.robot, []
    for start, end in reference.airborne_phases():
        sample = reference.at(end - 1e-9)
        feet = robot.foot_positions(sample.q) - sample.com
        after = reference.at(end + 1e-9).stance
        sinking = float(-reference.feet_at(end - 1e-9)[1][after, 2].min(initial=0.0))
        out.append(
            Touchdown(
                start, end, feet, float(sample.com[2]), sample.com_velocity.copy(), sample.rotation,
                sample.q[7:], after, sinking < SOFT, reference.attitude_at,
            )
        )  # fmt: skip
    return out


class AirborneControl:
    """Joint targets and torques of a robot in the air.

    Parameters
    ----------
    robot
        Who flies.
    stiffness
        Natural frequency with which targets go to the planned angles [rad/s].
    capture
        Share of the capture point's offset that the feet go out by.
    """

    def __init__(self, robot: Robot, stiffness: float, capture: float) -> None:
        import pinocchio

        self.robot, self.legs = robot, Legs(robot)
        self._pin, self._model, self._data = pinocchio, robot.model, robot.model.createData()
        self._omega, self._capture = stiffness, capture
        model = robot.model
        self._roots = [
            int(model.joints[k].idx_v) - 6 for k in range(2, model.njoints) if model.parents[k] == 1
        ]
        self._fastest = SPEED_SHARE * robot.speed_limits

    def begin(self, joints: FloatArray, speeds: FloatArray) -> None:
        """Start from joint angles and speeds (joints,): targets move on from there."""
        self._angles, self._speeds = joints.copy(), speeds.copy()
        self._aim: FloatArray | None = None
        self._landing = joints.copy()

    def time_left(self, now: Kinematics, goal: Touchdown) -> float:
        """Return the time until the centre of mass has sunk to the planned touchdown [s], at least 0."""
        # The later root of h + u t - g t² / 2 = 0; a body that cannot reach the height any more has its apex
        # now.
        height, climb = float(now.com[2]) - goal.height, float(now.com_velocity[2])
        inside = climb * climb + 2.0 * GRAVITY * height
        return max((climb + math.sqrt(max(inside, 0.0))) / GRAVITY, 0.0)

    def moment(self, now: Kinematics, goal: Touchdown, clock: float) -> float:
        """Return the time of the plan whose legs are wanted now [s]: its end comes when the ground does."""
        left = self.time_left(now, goal)
        if not goal.soft or left > PREPARE:
            return clock
        share = minimum_jerk(min((PREPARE - left) / (PREPARE - READY), 1.0))[0]
        return clock + share * (goal.end - left - clock)

    def _average_rate(self, q: FloatArray, v: FloatArray) -> FloatArray:
        """Return the angular momentum over the robot's inertia (3,) [rad/s]: legs that move leave it alone.

        The base's own rate would not do: it answers every motion of the legs, and they would answer it.
        """
        self._pin.ccrba(self._model, self._data, q, v)
        momentum = np.array(self._data.hg.angular)
        return np.asarray(np.linalg.solve(np.array(self._data.Ig.inertia), momentum))

    def level_feet(self, now: Kinematics, goal: Touchdown, left: float) -> FloatArray:
        """Return the change (joints,) of the plan's joints with which feet land at their planned heights.

        The body will be off the plan's attitude as it is now; a foot that reaches the ground early trips it.
        Feet that do not land, and the joints at the base that a folded leg has little use of, stay.
        """
        planned = goal.attitude(max(goal.end - left, goal.start))
        off = now.rotation @ planned.T
        ahead = np.cross(goal.rotation[:, 1], [0.0, 0.0, 1.0])
        sides = np.array([ahead / max(float(np.linalg.norm(ahead)), 1e-9), [0.0, 0.0, 1.0]])
        miss = (goal.feet[goal.landing] @ (np.eye(3) - off).T @ sides.T).ravel()
        slope = np.einsum("ai,nij->naj", sides @ off @ goal.rotation, self.legs.slopes(goal.joints))
        slope = slope[goal.landing].reshape(len(miss), -1)
        slope[:, self._roots] = 0.0
        # Damped least squares: near the end of a leg's reach it gives up millimetres instead of turning
        # joints by much.
        square = slope @ slope.T + SLACK**2 * np.eye(len(miss))
        return np.asarray(np.clip(slope.T @ np.linalg.solve(square, miss), -MOST_TURN, MOST_TURN))

    def landing_joints(
        self, q: FloatArray, v: FloatArray, now: Kinematics, goal: Touchdown, left: float
    ) -> FloatArray:
        """Return the angles (joints,) that have the feet where they are needed after `left` seconds."""
        speed = self._average_rate(q, v)
        rate = float(np.linalg.norm(speed))
        turned = rotation_about(speed / rate, rate * max(left - LEAD, 0.0)) if rate > 1e-9 else np.eye(3)
        rotation = turned @ now.rotation
        # the plan's feet, turned to the heading that the body will have
        twist = rotation_log(rotation @ goal.rotation.T)
        heading = rotation_about([0.0, 0.0, 1.0], float(twist[2]))
        feet = goal.feet @ heading.T
        planned = heading @ goal.velocity
        offset = self._capture * math.sqrt(goal.height / GRAVITY) * (now.com_velocity - planned)[:2]
        length = float(np.linalg.norm(offset))
        feet[:, :2] += offset * min(1.0, FURTHEST / max(length, 1e-12))
        # further down now than at touchdown: from there they give way to the ground
        sinking = max(GRAVITY * left - float(now.com_velocity[2]), 0.0)
        feet[:, 2] -= min(max(sinking - SOFT, 0.0) * left, EXTRA)
        # from the centre of mass to the base's origin, with the body as it will be
        base = feet + rotation @ (now.rotation.T @ (now.com - q[:3]))
        self._landing = self.legs.reach(base @ rotation, self._landing, iterations=2)
        return self._landing

    def targets(
        self, q: FloatArray, v: FloatArray, now: Kinematics, planned: FloatArray, goal: Touchdown, dt: float
    ) -> Targets:
        """Return the joints' targets at (nq,) q, (nv,) v: from (joints,) planned to the landing's."""
        left = self.time_left(now, goal)
        wanted = planned
        if left < PREPARE:
            share = minimum_jerk(min((PREPARE - left) / (PREPARE - READY), 1.0))[0]
            if goal.soft:  # the plan's way down, moved by as much as its end
                wanted = planned + share * self.level_feet(now, goal, left)
            else:
                landing = self.landing_joints(q, v, now, goal, left)
                wanted = (1.0 - share) * planned + share * landing
        return self._smooth(wanted, dt)

    def _smooth(self, wanted: FloatArray, dt: float) -> Targets:
        """Return targets that go to the wanted angles without a jump in speed, and not too fast."""
        rate = np.zeros_like(wanted) if self._aim is None else (wanted - self._aim) / dt
        self._aim, w = wanted, self._omega
        speed = np.clip(rate, -self._fastest, self._fastest)
        pull = w * w * (wanted - self._angles) + 2.0 * w * (speed - self._speeds)
        before = self._speeds
        after = before + dt * pull
        # not faster than allowed, but from too fast only as far down as the pull goes
        most = np.maximum(self._fastest, np.abs(before))
        self._speeds = np.clip(after, -most, most)
        self._angles = self._angles + dt * self._speeds
        return Targets(self._angles, self._speeds, (self._speeds - before) / dt)

    def torques(
        self, M: FloatArray, bias: FloatArray, angles: FloatArray, speeds: FloatArray, targets: Targets
    ) -> FloatArray:
        """Return the torques that move the joints as wanted, while the base reacts: (joints,) [N m].

        The joints' equations of motion with the base's six eliminated, M̄ a + h̄ = τ.

        Parameters
        ----------
        M, bias
            (nv, nv), (nv,) mass matrix and bias forces.
        angles, speeds
            (joints,) as they are.
        targets
            As they should be.
        """
        # Nothing holds the base: M_bb a_b = -M_bj a_j - h_b, put into the joints' rows.
        gain = np.linalg.solve(M[:6, :6], np.column_stack([M[:6, 6:], bias[:6]]))
        reduced, rest = M[6:, 6:] - M[6:, :6] @ gain[:, :-1], bias[6:] - M[6:, :6] @ gain[:, -1]
        w = FOLLOW * self._omega
        pull = w * w * (targets.angles - angles) + 2.0 * w * (targets.speeds - speeds)
        return np.asarray(reduced @ (targets.accelerations + pull) + rest)
