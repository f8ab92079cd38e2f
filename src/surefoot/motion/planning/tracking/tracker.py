"""Executes a plan: whole-body control where it stands, joint control where it flies, and the landing.

On the ground the centre of mass and the base follow the plan with its accelerations and forces as
feedforward; torques come from `WholeBodyController`, inside friction cones and torque limits. The plan's
last knot of a stance begins the flight; what the feet feel ends it, early or late. The landing then brakes
the body over the feet that touch, like a spring and damper of critical damping, and holds it there.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.loaded import UNLOADED
from surefoot.base.spatial import GRAVITY, rotation_log
from surefoot.mechanics import Robot, motor_limits
from surefoot.motion.control.controller import Command, Controller, RobotState
from surefoot.motion.control.damping import computable_pose
from surefoot.motion.control.whole_body import Kinematics, Tasks, TaskWeights, WholeBodyController
from surefoot.motion.planning.schedule.motions import time_scale
from surefoot.motion.planning.tracking.landing import Landing, gaps_to_close, gently, lowering_accelerations
from surefoot.motion.planning.tracking.legs_in_air import AirborneControl, Targets, touchdowns
from surefoot.motion.planning.tracking.reference import Reference
from surefoot.records import Channel

FRICTION = 0.5
"""What the controller counts on."""
BODY, TURN, SWING, JOINTS = 20.0, 20.0, 40.0, 60.0
"""Natural frequencies of critically damped feedback, of a robot of Go2's size: of the centre of mass and the
base's attitude on the ground, of feet in the air while others stand, of the joints in flight [rad/s]."""
CAPTURE = 0.7
"""Share of the capture point's offset that feet are moved by before they land."""
FORCE_SHARE = 0.01
"""Weight of the plan's forces, see `TaskWeights.force`."""
EARLY, FAST = 0.03, 0.92
"""So long before the planned end of a push [s] it ends as soon as half the feet have left the ground, or a
joint moves with this share of its speed limit: there is nothing left to push with."""
GONE = 4e-3
"""A foot that pushes off and feels nothing for so long is gone [s]; soft ground lets go for less."""
BRAKE = 0.9
"""Share of a joint's speed limit from which a leg on the ground brakes it."""
SPEED_MARGIN = 0.97
"""Share of a joint's speed limit that torques may take it to."""
BAUMGARTE = (2500.0, 100.0)
"""Stiffness [1/s²] and damping [1/s] with which feet are held on the ground."""
LEAST = 0.03
"""Least normal force of a stance foot, over m g: one without leaves the ground as soon as the body turns."""
AROUND = (0.03, 0.05)
"""How much earlier and later than the plan's end of a flight its next stance may begin [s]."""


class TrackPhase(IntEnum):
    """Values of the channel `phase` of a plan that is followed."""

    GROUND, FLYING, LANDED = range(3)


def whole_body(robot: Robot, least: float = 0.0) -> WholeBodyController:
    """Return the control of a robot on the ground, its stance feet with a `least` normal force [N]."""
    # a plan's swings are within its motors: its feet may ask as much of the body as the body itself
    weights = TaskWeights(swing=1.0, joints=1e-3, body=100.0, force=FORCE_SHARE)
    return WholeBodyController(robot, FRICTION, least, weights=weights, baumgarte=BAUMGARTE)


@dataclass(frozen=True, kw_only=True)
class TrackCommand(Command):
    """What a controller of a plan asks for at one step; `phase` is a `TrackPhase` or its like."""

    phase: IntEnum

    def rows(self) -> dict[str, Any]:
        """Return the phase."""
        return {"phase": float(self.phase)}


class TrackingController(Controller):
    """Makes a robot do what a plan says; call `step` at a fixed rate.

    The plan is laid from where the feet stand at the first step: its places and its heading are moved there.

    Parameters
    ----------
    robot
        Who executes the plan, as the controller knows it.
    reference
        The motion; its flight ends where the feet feel the ground.
    dt
        Time between steps [s].
    """

    channels = (Channel("phase", (), "1", meaning="0 on the ground, 1 in flight, 2 landed or at the end"),)

    def __init__(self, robot: Robot, reference: Reference, dt: float = 1e-3) -> None:
        self.robot, self.planned, self.dt = robot, reference, dt
        quick = self._quick = 1.0 / time_scale(robot)  # small robots are quicker
        least = LEAST * robot.mass * GRAVITY
        self.whole_body = whole_body(robot, least)
        self.motors = motor_limits(robot, "curve")
        self.flight = AirborneControl(robot, quick * JOINTS, CAPTURE)
        self.landing = Landing(robot, reference, quick)
        self.facts = {"kind": "track", "normal_min": least, "normal_max": math.inf, "mu_controller": FRICTION}
        self._radii = robot.contact_points.foot_radii
        self._support = robot.contact_points.foot_support[:, 6:]
        self._speed_limits = robot.speed_limits
        self._frames, self._still = np.tile(np.eye(3), (len(robot.feet), 1, 1)), np.zeros(robot.joints)
        self.reset()

    def reset(self) -> None:
        """Forget the past: the next step is the first of the plan."""
        self.whole_body.reset()
        self.phase = TrackPhase.GROUND
        self._reference: Reference | None = None
        self._clock, self._last = 0.0, -math.inf
        self._unsensed = np.zeros(len(self.robot.feet))

    def step(self, state: RobotState) -> TrackCommand:
        """Return the command for a state; where no foot feels, the plan is taken for the contacts.

        Never raises on a hard instance; a state that is not finite gets a command that slows the joints.
        """
        if not computable_pose(state.q, state.v):
            return self._make_command(self.whole_body.damping(state.v), self._off)
        now = self.whole_body.update(state.q, state.v)
        if self._reference is None:
            self._begin(now, state)
        since = state.time - self._last if math.isfinite(self._last) else 0.0
        self._clock, self._last = self._clock + since, state.time
        sensed = self._planned_stance() if state.contact is None else np.asarray(state.contact, dtype=bool)
        self._advance(now, state, sensed)
        if self.phase == TrackPhase.FLYING:
            return self._fly(now, state)
        stance = self._stance(sensed, since)
        if not stance.any():
            return self._fly(now, state)
        tasks = (
            self._follow(now, stance) if self.phase == TrackPhase.GROUND else self.landing.tasks(now, stance)
        )
        body = self.whole_body.solve(tasks)
        loose = ~self._support[stance & sensed].any(axis=0)
        slow = self._not_too_fast(body.torques, state.v[6:])
        torques = self.motors.clip(self._brake(np.where(loose, slow, body.torques), state.v[6:]), state.v[6:])
        return self._make_command(body._replace(torques=torques), stance)

    @property
    def _off(self) -> BoolArray:
        return np.zeros(len(self.robot.feet), dtype=bool)

    def _begin(self, now: Kinematics, state: RobotState) -> None:
        """Lay the plan where the feet are."""
        self._reference = self.planned.place_on(now.centres)
        self._flights = touchdowns(self._reference)
        self._next = 0
        self.flight.begin(state.q[7:], state.v[6:])

    def _planned_stance(self) -> BoolArray:
        assert self._reference is not None
        landed = self._flights[self._next - 1].end + 1e-9 if self._next else 0.0
        return self._reference.at(max(self._clock, landed)).stance

    def _advance(self, now: Kinematics, state: RobotState, sensed: BoolArray) -> None:
        """Go from one phase to the next: by the plan into flight, by touch out of it."""
        assert self._reference is not None
        airborne_phases, clock = self._flights, self._clock
        if self.phase == TrackPhase.GROUND:
            if self._next < len(airborne_phases) and self._leaves(state, airborne_phases[self._next].start):
                self.phase = TrackPhase.FLYING
                self.flight.begin(state.q[7:], state.v[6:])
            elif clock >= self._reference.duration or (
                0 < self._next == len(airborne_phases) and sensed.all()
            ):
                self._land(now)
        elif self.phase == TrackPhase.FLYING:
            goal = airborne_phases[self._next]
            if sensed.any() and now.com_velocity[2] < 0.0:  # while it rises, feet scrape as they leave
                self._next += 1
                if self._next == len(airborne_phases) and goal.landing.all():
                    self._land(now)
                else:
                    self.phase, self._clock = TrackPhase.GROUND, self._time_of_attitude(now, goal.end)
                    self._reference = self._reference.place_on(now.centres, goal.end, goal.landing)
                self._unsensed[:] = np.where(sensed, 0.0, math.inf)

    def _leaves(self, state: RobotState, start: float) -> bool:
        """Return whether the flight begins: as planned, or just before when the legs cannot push any more."""
        if self._clock >= start:
            return True
        fast = bool((np.abs(state.v[6:]) > FAST * self._speed_limits).any())
        planned = self._planned_stance()
        lost = 2 * int((planned & (self._unsensed > GONE)).sum()) >= int(planned.sum())
        return self._clock >= start - EARLY and (fast or lost)

    def _time_of_attitude(self, now: Kinematics, end: float) -> float:
        """Return the plan's time near a flight phase's end whose attitude is nearest to the measured one."""
        assert self._reference is not None
        times = end + self.dt * np.arange(-round(AROUND[0] / self.dt), round(AROUND[1] / self.dt) + 1)
        off = [np.trace(self._reference.attitude_at(float(t)).T @ now.rotation) for t in times[::4]]
        return float(times[::4][int(np.argmax(off))])

    def _land(self, now: Kinematics) -> None:
        self.phase = TrackPhase.LANDED
        self.landing.begin(now)

    def _stance(self, sensed: BoolArray, since: float) -> BoolArray:
        """Return which feet may push: those that should and feel the ground, or have just lost it."""
        self._unsensed = np.where(sensed, 0.0, self._unsensed + since)
        touching = self._unsensed <= UNLOADED
        return np.asarray(touching & self._planned_stance() if self.phase == TrackPhase.GROUND else touching)

    def _follow(self, now: Kinematics, stance: BoolArray) -> Tasks:
        """Return the tasks of the plan at this moment."""
        assert self._reference is not None
        body, turning, swing = self._quick * BODY, self._quick * TURN, self._quick * SWING
        want = self._reference.at(self._clock)
        com = want.com_acceleration + body**2 * (want.com - now.com)
        com = com + 2.0 * body * (want.com_velocity - now.com_velocity)
        turn = want.turn_acceleration + turning**2 * rotation_log(want.rotation @ now.rotation.T)
        turn = turn + 2.0 * turning * (want.turn_rate - now.angular_velocity)
        feet = np.zeros((len(stance), 6))
        if not stance.all():
            places, speeds = self._reference.feet_at(self._clock)
            # around the weight as it is, not as it was planned
            miss = places - want.com - (now.centres - now.com)
            slow = speeds - want.com_velocity - (now.twists[:, :3] - now.com_velocity)
            feet[:, :3] = want.com_acceleration + swing**2 * miss + 2.0 * swing * slow
            if self._next > 0:
                feet[:, 2] = np.maximum(feet[:, 2], gently(now, self.landing.stand))
            lost = self._planned_stance() & ~stance
            feet[lost, :3] = lowering_accelerations(now)[lost]
        gaps = gaps_to_close(now, self.landing.stand if self._next > 0 else self._radii)
        return Tasks(stance, com, turn, feet, self._still, want.forces, self._frames, gaps)

    def _fly(self, now: Kinematics, state: RobotState) -> TrackCommand:
        """Return the command of a robot in the air."""
        assert self._reference is not None
        goal = self._flights[min(self._next, len(self._flights) - 1)] if self._flights else None
        q, v = state.q, state.v
        moment = (
            self._clock if goal is None else min(self.flight.moment(now, goal, self._clock), goal.end - 1e-9)
        )
        planned = self._reference.at(moment).q[7:]
        if goal is None:
            targets = Targets(planned, np.zeros_like(planned), np.zeros_like(planned))
        else:
            targets = self.flight.targets(q, v, now, planned, goal, self.dt)
        M, bias, *_ = self.whole_body.instant()
        torques = self.flight.torques(M, bias, q[7:], v[6:], targets)
        limits = self.whole_body.limits
        torques = self.motors.clip(self._not_too_fast(np.clip(torques, -limits, limits), v[6:]), v[6:])
        return TrackCommand(
            torques, np.zeros((len(self.whole_body.point_foot), 3)),
            self._off[self.whole_body.point_foot], phase=self.phase,
        )  # fmt: skip

    def _not_too_fast(self, torques: FloatArray, speeds: FloatArray) -> FloatArray:
        """Return torques that take no joint of an unloaded leg beyond its speed limit by the next step."""
        M = self.whole_body.instant().M
        # What the torque of a joint does to its own speed while the others of the leg give way; never less
        # than zero room towards rest, so that a joint that is too fast already may be braked but is not
        # ordered to.
        inertia = 1.0 / np.diag(np.linalg.inv(M[6:, 6:])) / self.dt
        most = SPEED_MARGIN * self._speed_limits
        high, low = inertia * (most - speeds), inertia * (-most - speeds)
        return np.asarray(np.clip(torques, np.minimum(low, 0.0), np.maximum(high, 0.0)))

    def _brake(self, torques: FloatArray, speeds: FloatArray) -> FloatArray:
        """Return (joints,) torques with braking near the joints' speed limits."""
        use = np.abs(speeds) / self._speed_limits
        share = np.clip((use - BRAKE) / (1.0 - BRAKE), 0.0, 1.0)
        return np.asarray((1.0 - share) * torques - share * np.sign(speeds) * self.whole_body.limits)

    def _make_command(self, body: Any, stance: BoolArray) -> TrackCommand:
        active = stance[self.whole_body.point_foot]
        return TrackCommand(
            body.torques, body.forces, active, body.feasible, body.distribution, phase=self.phase
        )
