"""From readings to the state that a controller is given: the estimator and what it is given at each step."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.memory import Remembering
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics import Actuators, Robot, Terrain
from surefoot.motion.control.controller import Command, RobotState
from surefoot.motion.estimation.inekf import STIFF_FEET, FilterNoise
from surefoot.motion.estimation.inekf_robot import InvariantEkf
from surefoot.motion.estimation.state_estimator import Health, Reading, StateEstimator


class StateTracker(Remembering):
    """Turns readings into states: a contact-aided invariant filter, given plan and torques step by step.

    Parameters
    ----------
    robot
        With a floating base and feet.
    dt
        Time between readings [s].
    noise
        What is believed of the sensors; None for the defaults with stiff legs (`STIFF_FEET`).
    ground
        A map of the ground; None to know nothing of it.
    imu_position
        (3,) of the IMU from the base's origin, base axes [m].
    latency
        How late IMU and encoders tell [s].
    actuators
        The motors, whose gears' friction is in their torques; None for ideal ones.
    point_foot
        (p,) the foot of each contact point of the commands; None for the robot's own.

    Attributes
    ----------
    estimator
        `StateEstimator`.
    """

    MEMORY = ("estimator", "_standing", "_speeds")

    def __init__(
        self,
        robot: Robot,
        dt: float,
        noise: FilterNoise | None = None,
        ground: Terrain | None = None,
        imu_position: ArrayLike = (0.0, 0.0, 0.0),
        latency: tuple[float, float] = (0.0, 0.0),
        actuators: Actuators | None = None,
        point_foot: ArrayLike | None = None,
    ) -> None:
        self.robot = robot
        noise = noise or FilterNoise(**STIFF_FEET)
        self.estimator = StateEstimator(InvariantEkf(robot, dt, noise, ground, imu_position), latency=latency)
        self._actuators = actuators
        self._foot = np.asarray(robot.contact_points.foot if point_foot is None else point_foot)
        self._standing: BoolArray | None = None
        self._speeds = np.zeros(robot.joints)
        self._warm_up()

    def _warm_up(self) -> None:
        """Compile or load all that a step calls, so that no step of the run waits."""
        estimator, joints = self.estimator, np.zeros(self.robot.joints)
        reading = Reading(np.zeros(3), np.array([0.0, 0.0, GRAVITY]), self.robot.nominal[7:], joints)
        for _ in range(3):
            touching = estimator.decide(~estimator.predict(reading))
            estimator.update(np.ones_like(touching))
            estimator.applied(joints)
        self.begin(self.robot.nominal)

    @property
    def failure(self) -> str:
        """Reason why the state is no longer estimated; empty while it is."""
        health = self.estimator.health
        return "" if health is Health.GOOD else str(health)

    def begin(self, q: FloatArray) -> None:
        """Start from rest at (nq,) q [m, rad]: place and heading are taken as they are."""
        self.estimator.reset(q)
        self._standing = None

    def state(
        self, reading: Reading, time: float, measured: Callable[[BoolArray], BoolArray] | None = None
    ) -> RobotState:
        """Return the state after the next reading.

        Parameters
        ----------
        reading
            One step after the last.
        time
            Of the run [s].
        measured
            From (n,) which feet bear a force by the estimate to what is taken for that: a sensor in the feet
            knows better.
        """
        estimator = self.estimator
        sensed = estimator.predict(reading)
        touching = estimator.decide(sensed if measured is None else measured(sensed))
        q, v = estimator.update(touching, self._standing)
        self._speeds = v[6:]
        # a copy: whoever keeps the state, as a dropout does, is not to find the forces of later steps in it
        return RobotState(q, v, time, touching, forces=estimator.forces.copy())

    def plan(self, command: Command) -> None:
        """Tell what was commanded: which feet push until the next reading, which should stand."""
        pushing = np.zeros(len(self.robot.feet), dtype=bool)
        if np.isnan(command.forces).all():  # it says nothing of its feet, as policies do: odds are even
            self._standing = None
            self.estimator.expect(pushing, ~pushing)
            return
        pushing[self._foot[command.active]] = True
        self._standing = pushing
        self.estimator.expect(pushing, np.asarray(command.rows().get("planned", pushing), dtype=bool))

    def note_torques(self, torques: FloatArray) -> None:
        """Record the motors' (joints,) torques between the last reading and the next [N m]."""
        losses = 0.0 if self._actuators is None else self._actuators.losses(self._speeds)
        self.estimator.applied(torques - losses)  # currents tell what motors give, friction included
