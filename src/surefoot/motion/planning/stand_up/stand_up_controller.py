"""Executes a plan that gets up from lying: postures in turn, each stage begun by what the attitude says.

The postures that roll the body over are played by the clock, as planned. What comes after waits for the body:
it rises once it lies level over its folded legs, and if it has not got there it folds its legs, comes to lie
again, and tries once more. Once it stands, whole-body control holds it.
"""

from __future__ import annotations

import math
from enum import IntEnum

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.mechanics import Robot
from surefoot.motion.control.controller import Controller, RobotState
from surefoot.motion.control.damping import computable_pose
from surefoot.motion.planning.stand_up.lying import upright
from surefoot.motion.planning.stand_up.posture_sequence import Postures
from surefoot.motion.planning.tracking.landing import Landing
from surefoot.motion.planning.tracking.reference import Reference
from surefoot.motion.planning.tracking.tracker import FRICTION, TrackCommand, TrackingController, whole_body
from surefoot.records import Log

LEVEL, STILL = math.cos(math.radians(15.0)), 0.6
"""The body is ready to rise if it leans less than 15 degrees and moves slower than this [m/s, rad/s]."""
WAIT, FOLD = 0.6, 1.0
"""Longest time to wait for that after the last rolling posture, and time to lie down again [s]."""
STAGES = 2
"""Postures at the end that rise and hold."""


class StandUpPhase(IntEnum):
    """Values of the channel `phase` of a robot that gets up."""

    ROLLING, RISING, STANDING, FOLDING = range(4)


class StandUpController(Controller):
    """Gets a robot up by the postures of a plan; call `step` at a fixed rate.

    Parameters
    ----------
    robot
        Who gets up, as the controller knows it.
    plan
        Of the task `stand-up`.
    """

    channels = TrackingController.channels

    def __init__(self, robot: Robot, plan: Log) -> None:
        self.robot, self.law = robot, Postures.read(plan, robot)
        reference = Reference.of(plan, robot)
        self._lying = reference.start[7:]
        self.whole_body = whole_body(robot)
        self.landing = Landing(robot, reference)
        self.facts = {"kind": "track", "normal_min": 0.0, "normal_max": math.inf, "mu_controller": FRICTION}
        self._rolled = float(self.law.times[-STAGES - 1])
        self.reset()

    def reset(self) -> None:
        """Forget the past: the next step is the first of the plan."""
        self.whole_body.reset()
        self.phase = StandUpPhase.ROLLING
        self._since: float | None = None
        self._from = self._lying

    def step(self, state: RobotState) -> TrackCommand:
        """Return the command for a state; never raises on one that is not finite."""
        off = np.zeros(len(self.robot.feet), dtype=bool)
        if not computable_pose(state.q, state.v):
            return self._make_command(self.whole_body.damping(state.v).torques, off)
        if self._since is None:
            self._begin(StandUpPhase.ROLLING, state)
        sensed = off if state.contact is None else np.asarray(state.contact, dtype=bool)
        assert self._since is not None
        self._advance(state, state.time - self._since, sensed)
        if self.phase == StandUpPhase.STANDING and sensed.any():
            now = self.whole_body.update(state.q, state.v)
            body = self.whole_body.solve(self.landing.tasks(now, sensed))
            active = sensed[self.whole_body.point_foot]
            return TrackCommand(
                body.torques, body.forces, active, body.feasible, body.distribution, phase=self.phase
            )
        target = self._target(state.time - self._since)
        return self._make_command(self.law.torques(target, state.q[7:], state.v[6:]), off)

    def _begin(self, phase: StandUpPhase, state: RobotState) -> None:
        self.phase, self._since, self._from = phase, state.time, state.q[7:].copy()

    def _advance(self, state: RobotState, clock: float, sensed: BoolArray) -> None:
        """Go to the next stage when the body is where that begins."""
        level = upright(state.q) > LEVEL and float(np.abs(state.v[:6]).max()) < STILL
        law = self.law
        if self.phase == StandUpPhase.ROLLING and clock >= self._rolled:
            if level:
                self._begin(StandUpPhase.RISING, state)
            elif clock > self._rolled + WAIT:
                self._begin(StandUpPhase.FOLDING, state)
        elif self.phase == StandUpPhase.FOLDING and clock >= FOLD:
            self._begin(StandUpPhase.RISING if level else StandUpPhase.ROLLING, state)
        elif self.phase == StandUpPhase.RISING and clock >= law.duration - self._rolled:
            if sensed.all() and level:
                self._begin(StandUpPhase.STANDING, state)
                self.landing.begin(self.whole_body.update(state.q, state.v))
            elif not level:
                self._begin(StandUpPhase.FOLDING, state)
        elif self.phase == StandUpPhase.STANDING and upright(state.q) < 0.5:
            self._begin(StandUpPhase.FOLDING, state)

    def _target(self, clock: float) -> FloatArray:
        """Return the joints' targets (joints,) at a time since the stage began [s]."""
        law = self.law
        if self.phase == StandUpPhase.ROLLING:
            return law.at(min(clock, self._rolled), self._from)
        if self.phase == StandUpPhase.FOLDING:
            share = min(clock / (0.5 * FOLD), 1.0)
            return np.asarray((1.0 - share) * self._from + share * self._lying)
        if self.phase == StandUpPhase.STANDING:  # in the air for a moment: its legs stay as they stood
            return law.at(law.duration, self._from)
        return law.at(self._rolled + clock, self._from)

    def _make_command(self, torques: FloatArray, stance: BoolArray) -> TrackCommand:
        point_foot = self.whole_body.point_foot
        forces = np.zeros((len(point_foot), 3))
        return TrackCommand(torques, forces, stance[point_foot], phase=self.phase)


def controller_of(plan: Log | Reference, robot: Robot, dt: float = 1e-3) -> Controller:
    """Return who executes a plan: one that has postures by them, any other by tracking its motion."""
    if isinstance(plan, Log) and "posture_times" in plan.facts:
        return StandUpController(robot, plan)
    reference = plan if isinstance(plan, Reference) else Reference.of(plan, robot)
    return TrackingController(robot, reference, dt)
