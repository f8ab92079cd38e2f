"""The loop of a real robot: readings in, joint targets out, and a state machine in between; no simulator."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import finite_array, of_kind, real_number
from surefoot.base.errors import ProblemError, check_name
from surefoot.base.loaded import SENSED
from surefoot.base.memory import Remade, Remembering
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics import Actuators, FlatTerrain, Robot, Terrain, actuators_of, with_rotors
from surefoot.motion.control.controller import Command, JointTargets, RobotState
from surefoot.motion.drive.foot_load import HANGS, MAYBE_HANGS, FootLoad, hint
from surefoot.motion.drive.getting_up import FALLEN, LOW, TRIES, UPRIGHT, FallRecovery
from surefoot.motion.drive.joint_targets import JointTargetController
from surefoot.motion.drive.latency_compensation import LatencyCompensation
from surefoot.motion.drive.loop_state import ResumableLoop
from surefoot.motion.drive.modes import CONTROLLED, FOLLOWS, POWERLESS, LoopMode
from surefoot.motion.drive.posture_player import SETTLE, PosturePlayer
from surefoot.motion.drive.readings import ReadingLimits, ReadingWatch, RobotReadings, motor_order
from surefoot.motion.drive.state_tracker import StateTracker
from surefoot.motion.drive.target_limits import TargetLimits
from surefoot.motion.drive.watchdog import damping_targets
from surefoot.motion.estimation.state_estimator import Reading
from surefoot.motion.ground.terrain_knowledge import controller_ground
from surefoot.motion.walking.walker import Walker
from surefoot.motion.walking.walkers import default_gait, walking_controller
from surefoot.motion.walking.walking_body import VelocityCommand

SLOW = 0.05
"""Speed of a body, as a share of sqrt(g h), at which one that was commanded to stop stands."""


class RobotLoop(Remade, ResumableLoop):
    """Turns a robot's readings into its joints' targets; call `step` at a fixed rate, and `go` at any time.

    Limits of joints, speeds and torques are enforced last. Readings that are late, repeated, not finite, out
    of range or contradictory are not used; without usable ones for `ReadingLimits.patience` joints are
    damped, and stay so after `outage`, or if control was lost for another reason: see `fault`.

    Parameters
    ----------
    robot
        With a floating base and feet.
    dt
        Time between steps [s].
    motors
        Names of the joints in the order of readings and targets; None for the robot's own order.
    gait
        To walk with; None for one that suits the robot: on four feet `auto`, which stands, walks and trots.
    mu
        Friction that is believed in [-].
    terrain
        The ground that is believed in, where the robot stands up at the origin; None for flat, "blind" for
        the plane that its feet find.
    actuators
        What is believed of the motors, see `surefoot.mechanics.robot.actuators`: "real", "ideal" or a value.
    latency
        From a reading to the torques that answer it [s]; None to measure it.
    limits
        Of readings; None for the defaults.
    imu_position
        (3,) from the base's origin, base axes [m].

    Attributes
    ----------
    recover
        Whether a robot that has fallen gets up by itself once it lies still, and walks on if it walked;
        False until it is set.
    mode
        `LoopMode`.
    fault
        Why control was lost last; empty after the next `go`.
    time
        Steps made times `dt` [s].
    command, estimate
        What the balance controller asked for last, and the estimate that it was given; None in modes without.
    walker
        The balance controller, for what it notes.

    Raises
    ------
    ProblemError
        For motors that are not the robot's joints, or numbers out of range.

    Examples
    --------
    >>> from surefoot.mechanics.robot import load_robot
    >>> robot = load_robot("go2")
    >>> loop = RobotLoop(robot, dt=0.002)
    >>> still, level = np.zeros(12), np.array([0.0, 0.0, 0.0, 1.0])
    >>> readings = RobotReadings(
    ...     0.0, level, np.zeros(3), np.array([0, 0, 9.81]), robot.nominal[7:], still, still
    ... )
    >>> float(loop.step(readings).stiffness.max()), loop.mode.value
    (0.0, 'damp')
    """

    def __init__(
        self,
        robot: Robot,
        dt: float = 0.002,
        *,
        motors: Sequence[str] | None = None,
        gait: str | None = None,
        mu: float = 0.6,
        terrain: Terrain | str | None = None,
        actuators: str | Actuators = "real",
        latency: float | None = None,
        limits: ReadingLimits | None = None,
        imu_position: ArrayLike = (0.0, 0.0, 0.0),
    ) -> None:
        of_kind("robot", robot, Robot)
        self.robot, self.dt = robot, real_number("dt", dt, low=1e-4, high=0.02)
        self._order, self._back = motor_order(robot, motors)
        self.limits = limits or ReadingLimits()
        self.watch = ReadingWatch(robot, self.dt, self.limits)
        ground = terrain or "exact"
        self.terrain = controller_ground(ground, FlatTerrain()) if isinstance(ground, str) else ground
        known = None if self.terrain.learns else self.terrain
        self._motors = actuators_of(robot, actuators)
        geared = robot if self._motors is None else with_rotors(robot, self._motors.armature)
        self.tracker = StateTracker(geared, self.dt, None, known, imu_position, actuators=self._motors)
        self._player = PosturePlayer(robot, self.dt, self._motors)
        self._load, self.target_limits = FootLoad(robot), TargetLimits(robot)
        self.recover, self._recovery = False, FallRecovery()
        self._damp = damping_targets(robot, self.dt)
        self._passive = JointTargets(*np.zeros((5, robot.joints)))
        chosen = gait or ("auto" if len(robot.feet) == 4 else default_gait(robot))
        names = {LoopMode.WALK: chosen, LoopMode.STAND: chosen if chosen == "auto" else "stand"}
        made = {name: self._balance(name, mu, latency) for name in dict.fromkeys(names.values())}
        self._balances = {mode: made[name] for mode, name in names.items()}
        words = robot.name, self.dt, self._order.tolist(), [*made], mu, latency, self.terrain, self.limits
        self._make = repr((*words, imu_position, self._motors and self._motors.name)), made
        self.reset()
        self.warm_up()

    def _parts(self) -> dict[str, Remembering]:
        """See `ResumableLoop`."""
        parts = self.watch, self._recovery, self._player, self._load, self.tracker
        return dict(zip(("watch", "recovery", "player", "load", "tracker"), parts, strict=True))

    def warm_up(self) -> None:
        """Make a dry run of damping, standing and walking, so that all kernels are compiled, and reset."""
        robot, q, v = self.robot, self.robot.nominal, np.zeros(self.robot.model.nv)
        start = RobotState(q, v, 0.0, np.ones(len(robot.feet), dtype=bool), v[6:])
        for walker, controller in dict.fromkeys(self._balances.values()):
            walker.steer(SLOW * np.ones(3))
            controller.warm_up(start)
        level, up = np.array([0.0, 0.0, 0.0, 1.0]), np.array([0.0, 0.0, GRAVITY])
        for k in range(4):
            if k == 2:
                self._begin()
            self.step(RobotReadings(k * self.dt, level, np.zeros(3), up, q[7:], v[6:], v[6:]))
        self.reset()

    def _balance(self, gait: str, mu: float, latency: float | None) -> tuple[Walker, LatencyCompensation]:
        """Return a controller that balances and what makes joint targets of its commands."""
        robot, dt = self.robot, self.dt
        walker = walking_controller(
            robot, VelocityCommand.constant(0.0), gait, self.terrain, mu, self._motors, dt
        )
        return walker, LatencyCompensation(JointTargetController(walker, robot, dt), robot, dt, latency)

    def reset(self) -> None:
        """Damp, and forget the past."""
        self.mode, self.fault, self.time = LoopMode.DAMP, "", -self.dt
        self.watch.reset()
        self._recovery.reset()
        self._velocity, self._posture, self._began = np.zeros(3), np.zeros(3), 0.0
        self._forget()

    def _forget(self) -> None:
        """Forget what the last mode was doing."""
        self.command: Command | None = None
        self.estimate: RobotState | None = None
        self._reading: Reading | None = None
        self._steered: tuple[bytes, ...] = ()
        self.walker, self._controller = self._balances[LoopMode.STAND]

    @property
    def settled(self) -> bool:
        """Whether what `go` asked for last is reached, and the next may follow."""
        if self.mode in (LoopMode.SIT, LoopMode.LIE):
            return self._player.rest(self.time) > 0.0
        return self.mode is not LoopMode.STAND_UP and (self.mode is not LoopMode.STAND or self._still())

    def go(self, goal: str) -> None:
        """Change the mode: "stand", "walk", "sit", "lie", "damp" or "passive"; `FOLLOWS` says when.

        Raises
        ------
        ProblemError
            For what may not follow, with what may; for a posture that is not reached yet, a robot on its side
            or back that does not know how to roll over, or one whose readings cannot be used.
        """
        check_name("mode", goal, ("stand", "walk", "sit", "lie", "damp", "passive"))
        self._recovery.reset()
        self.change(goal)

    def change(self, goal: str) -> None:
        """Change the mode; `go` is this for those outside, who end what `recover` has in mind."""
        if goal not in FOLLOWS[self.mode] and goal != self.mode:
            raise ProblemError(f"{self.mode} is followed by {' or '.join(FOLLOWS[self.mode])}, not by {goal}")
        if goal not in POWERLESS:
            self._check(goal)
        self.fault, last = "", self.watch.last
        if goal == self.mode:
            return
        if goal == LoopMode.WALK or (goal == LoopMode.STAND and self.mode is LoopMode.WALK):
            self.mode = LoopMode(goal)
            return
        self._forget()
        if goal in POWERLESS or last is None:
            self._player.reset()
            self.mode = LoopMode(goal)
            return
        anywhere = self.mode in POWERLESS
        leans = anywhere and self.watch.lean > UPRIGHT
        self._player.take(goal, last.positions, self.time, anywhere=anywhere, leans=leans)
        self.mode = LoopMode.STAND_UP if goal == "stand" else LoopMode(goal)

    def _check(self, goal: str) -> None:
        """Refuse what cannot be begun now."""
        postures = self._player.postures
        if self.watch.blind:
            raise ProblemError(f"cannot {goal}: {self.watch.reason or 'there is no reading yet'}")
        if goal in ("sit", "lie") and postures.lie == postures.stand:
            raise ProblemError(f"{self.robot.name} stands on two feet: it does not {goal}")
        if goal in ("sit", "lie", "stand") and self.mode is not LoopMode.STAND_UP and not self.settled:
            raise ProblemError(f"cannot {goal} yet: the robot is still on its way to {self.mode}")
        if goal == "stand" and self.mode in POWERLESS and not self.can_rise:
            why = f"the base leans too much, and how {self.robot.name} rolls over is not known"
            raise ProblemError(f"cannot stand up: {why}; lay it on its belly{MAYBE_HANGS}")

    @property
    def can_rise(self) -> bool:
        """Whether the robot can stand up from how it lies."""
        return self._player.roll_over.known or self.watch.lean <= UPRIGHT

    def steer(self, velocity: ArrayLike, posture: ArrayLike = (0.0, 0.0, 0.0)) -> None:
        """Take another velocity and posture for `walk`; standing, the posture alone.

        Parameters
        ----------
        velocity
            (3,) forward, left [m/s], yaw rate [rad/s].
        posture
            (3,) body height over the usual [m], pitch, nose down [rad], foot clearance over the usual [m].

        Raises
        ------
        ProblemError
            For what is not three finite numbers each, or too steep a pitch.
        """
        velocity, posture = finite_array("velocity", velocity, (3,)), finite_array("posture", posture, (3,))
        VelocityCommand(np.zeros(1), velocity[None], posture[None])  # or raise
        self._velocity, self._posture = velocity, posture

    def step(self, readings: RobotReadings | None, now: float | None = None) -> JointTargets:
        """Return the joints' targets, in the order of the motors; never raises on what is read.

        Parameters
        ----------
        readings
            New ones; None if none came in time.
        now
            By the clock of this side [s]; None where every step is exactly `dt` after the last.
        """
        self.time += self.dt
        came = None if readings is None else readings.arrange(self._order)
        usable = self.watch.look(came, self.time if now is None else now)
        if self.mode not in POWERLESS:
            self._judge()
        self._recover()
        targets = self._targets(usable)
        if (last := self.watch.last) is not None:
            targets = self.target_limits.hold(targets, last.positions, last.speeds)
        return JointTargets(*(values[self._back] for values in targets))

    def plan_ahead(self) -> None:
        """Plan coming steps once the targets are sent: from its first call on `step` leaves that to it."""
        self.walker.answers_first = True
        self.walker.plan_ahead()

    def _judge(self) -> None:
        """Damp for good where control has been impossible for too long, or the robot has fallen."""
        watch = self.watch
        if watch.silent >= self.limits.outage or watch.contradictory:
            self._stop(watch.reason)
        elif self._down() and not (self.mode is LoopMode.STAND_UP and self._player.lying):
            self._recovery.fell(self.mode, self.time)
            self._stop(FALLEN)
        elif self.mode in CONTROLLED and self.tracker.failure:
            self._stop(f"the state estimate was lost: {self.tracker.failure}{hint(self.robot, watch.last)}")

    def _recover(self) -> None:
        """Get up after a fall, and walk on if the robot walked."""
        if self.recover and self._recovery.walks_on(self.mode, self.settled):
            self.change("walk")
        usable = None if self.watch.blind else self.watch.last
        if self.recover and self._recovery.rises(self.mode, self.fault, self.time, usable) and self.can_rise:
            self.change("stand")

    def _stop(self, fault: str) -> None:
        """Damp, because of a fault."""
        self._forget()
        self.mode, self.fault = LoopMode.DAMP, fault

    def _targets(self, usable: bool) -> JointTargets:
        """Return what the mode wants of the joints, in the robot's order."""
        if self.mode is LoopMode.PASSIVE:
            return self._passive
        if self.mode is LoopMode.DAMP or self.watch.blind:
            if self.mode in CONTROLLED:
                self._follow(usable)  # so that it can go on when readings come again
            return self._damp
        if self.mode not in CONTROLLED:
            targets = self._player.targets(self.time)
            self._load.look(held := self._player.rest(self.time), self.watch.last)
            if self.mode is not LoopMode.STAND_UP or held < SETTLE:
                return targets
            if self._player.lying:
                if not self._player.go_on(targets.positions, self.time, self.watch.lean > UPRIGHT):
                    self._stop(f"the robot rolled {TRIES} times and is not on its belly{MAYBE_HANGS}")
                return targets
            if self._load.nothing:
                self._stop(HANGS)
                return self._damp
            self._begin()
        return self._follow(usable)

    def _begin(self) -> None:
        """Begin to balance where the robot stands."""
        last = self.watch.last
        assert last is not None
        for walker, controller in self._balances.values():
            controller.reset()
            walker.steer(np.zeros(3))
        q = np.concatenate([np.zeros(3), last.quaternion / np.linalg.norm(last.quaternion), last.positions])
        feet = self.robot.foot_positions(q)
        q[2] = (self.terrain.height(feet[:, :2]) + self.robot.contact_points.foot_radii - feet[:, 2]).mean()
        self.tracker.begin(q)
        self.walker, self._controller = self._balances[LoopMode.STAND]
        self._began, self.mode, self._steered = self.time, LoopMode.STAND, ()

    def _follow(self, usable: bool) -> JointTargets:
        """Return the balance controller's targets."""
        self._choose()
        state = self._sense(usable)
        self.estimate, self.command = state, self._controller.step(state)
        self.tracker.plan(self.command)
        return self.command.joint_targets or self._damp._replace(feedforward=self.command.torques)

    def _choose(self) -> None:
        """Tell the walker where to go, and change to another where the mode asks for it."""
        walker, controller = self._balances[self.mode]
        if walker is not self.walker and (self.mode is LoopMode.WALK or self._still()):
            self.walker, self._controller = walker, controller
            controller.reset()
            self._began, self._steered = self.time, ()
        velocity = self._velocity if self.mode is LoopMode.WALK else np.zeros(3)
        asked = velocity.tobytes(), self._posture.tobytes()
        if asked != self._steered:
            self.walker.steer(velocity, self._posture)
            self._steered = asked

    def _sense(self, usable: bool) -> RobotState:
        """Return the state after a reading, or what the one before says where it cannot be used."""
        last = self.watch.last
        assert last is not None
        if usable or self._reading is None:
            self._reading = Reading(last.gyro, last.accelerometer, last.positions, last.speeds)
        else:
            before = self._reading
            self._reading = before._replace(positions=before.positions + self.dt * before.speeds)
        self.tracker.note_torques(last.torques)
        loaded = last.loaded_feet(SENSED * self.robot.mass * GRAVITY)
        state = self.tracker.state(
            self._reading, self.time - self._began, None if loaded is None else lambda _: loaded
        )
        return state._replace(torques=last.torques if usable else None)

    def _still(self) -> bool:
        """Whether a robot that balances stands on all feet and hardly moves."""
        feet, state = self.walker.feet, self.estimate
        if feet is None or state is None or not feet.stance.all():
            return False
        return float(np.linalg.norm(state.v[:2])) < SLOW * math.sqrt(GRAVITY * self.walker.height)

    def _down(self) -> bool:
        """Whether the base leans as one that has fallen, or is as low by the estimate."""
        q = None if self.estimate is None else self.estimate.q
        low = q is not None and q[2] - self.terrain.height(q[:2]) < LOW * self.robot.nominal[2]
        return bool(low) or self.watch.lean > self.limits.tilt
