"""What a controller is given in a run.

The true state, or what an estimator makes of the robot's sensors; the ground ahead, and forces on the feet.
"""

from __future__ import annotations

import time as clock
from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.memory import Remembering
from surefoot.mechanics import frames_on
from surefoot.motion import Command, RobotState, StateTracker
from surefoot.records import CHANNELS, Channel
from surefoot.worlds.interface.world import ContactReading, World
from surefoot.worlds.running.faults import ActiveFaults
from surefoot.worlds.running.height_scan import ActiveRangeSensor, RangeSensor
from surefoot.worlds.running.sensors import SensorModel, Sensors

STOP_TIME = 1.5
"""How long a robot that has lost its state estimate goes on standing before the run ends [s]."""


class Sensing(Protocol):
    """Tells a controller the state, step by step; subclass it to take what stands here ready-made.

    Attributes
    ----------
    channels
        What it adds to the log; `rows` gives the values.
    failure
        Why it cannot tell the state any longer; empty while it can.
    heard
        (joints,) torques that the motors say they gave last [N m]; None before the first.
    """

    channels: tuple[Channel, ...] = ()
    failure: str = ""
    heard: FloatArray | None = None

    def state(self, q: FloatArray, v: FloatArray, time: float, contact: BoolArray) -> RobotState:
        """Return what the controller is given at a true state, with (n,) the feet that truly touch."""
        ...

    def note_step(self, command: Command, torques: FloatArray) -> None:
        """Record the command of a step and the (joints,) torques that the motors gave [N m]."""
        self.heard = torques

    def rows(self) -> Mapping[str, Any]:
        """Return the values of its channels at this step."""
        return {}


class TrueState(Sensing, Remembering):
    """Tells the true state with the simple noise of `Faults`, and which feet truly touch."""

    MEMORY = ("failure", "heard")

    def __init__(self, faults: ActiveFaults) -> None:
        self._faults = faults

    def state(self, q: FloatArray, v: FloatArray, time: float, contact: BoolArray) -> RobotState:
        """See `Sensing.state`."""
        return RobotState(*self._faults.sense(q, v), time, contact)


class EstimatedState(Sensing, Remembering):
    """Tells what a contact-aided invariant filter makes of IMU, encoders and torques; see docs/estimation.md.

    Parameters
    ----------
    model
        The sensors.
    world
        Whose true motion they measure; its terrain is the map, if there is one.
    seed
        Of all their random numbers.

    Raises
    ------
    ProblemError
        For sensors that cannot be, or a robot that is bolted to the world.
    """

    channels = tuple(
        CHANNELS[name] for name in ("q_estimated", "v_estimated", "contact_estimated", "estimator_time")
    )

    MEMORY = ("failure", "heard", "sensors", "tracker", "_started")

    def __init__(self, model: SensorModel, world: World, seed: int | None) -> None:
        robot = world.robot
        self.sensors = Sensors(model, robot, world.dt, seed)
        self.tracker = StateTracker(
            robot, world.dt, model.filter_noise(), world.terrain if model.heights else None,
            model.imu.position, (model.imu.latency, model.encoders.latency),
            getattr(world, "actuators", None), world.contact_foot,
        )  # fmt: skip
        self._started = False

    def state(self, q: FloatArray, v: FloatArray, time: float, contact: BoolArray) -> RobotState:
        """See `Sensing.state`."""
        tracker = self.tracker
        if not self._started:
            tracker.begin(self.sensors.attitude_at_start(q))
            self._started = True
        reading = self.sensors.read(q, v)
        start = clock.perf_counter()
        self._reported = tracker.state(reading, time, self.sensors.touches)
        self._spent = clock.perf_counter() - start
        if tracker.failure and not self.failure:
            self.failure = f"the state estimate was lost at {time:.3f} s: {tracker.failure}"
        return self._reported

    def note_step(self, command: Command, torques: FloatArray) -> None:
        """See `Sensing.note_step`."""
        start = clock.perf_counter()
        self.tracker.plan(command)
        self.heard = self.sensors.torques(torques)
        self.tracker.note_torques(self.heard)
        self._spent += clock.perf_counter() - start

    def rows(self) -> Mapping[str, Any]:
        """See `Sensing.rows`."""
        reported = self._reported
        return {
            "q_estimated": reported.q, "v_estimated": reported.v, "contact_estimated": reported.contact,
            "estimator_time": self._spent,
        }  # fmt: skip


class ExteroceptiveSensing(Remembering):
    """Range scan and foot forces of a run, added to a state that lacks them.

    Parameters
    ----------
    world
        Where the robot is.
    scanner
        Its range sensor; None for none.
    seed
        Of the sensor's random numbers.
    """

    MEMORY = ("_scanner",)

    def __init__(self, world: World, scanner: RangeSensor | None, seed: int | None) -> None:
        self._terrain, self._foot, self._feet = world.terrain, world.contact_foot, len(world.robot.feet)
        self._scanner = None
        if scanner is not None:
            self._scanner = ActiveRangeSensor(scanner, world.robot, world.terrain, world.dt, seed)

    def add(self, state: RobotState, q: FloatArray, reading: ContactReading) -> RobotState:
        """Return the state with forces (n, 3) [N] and a scan, if there are any, at the true (nq,) q."""
        if state.forces is None:
            state = state._replace(forces=self._forces(reading))
        if self._scanner is not None:
            scan = self._scanner.look(q, state.time)
            if scan is not None:
                state = state._replace(scan=scan)
        return state

    def _forces(self, reading: ContactReading) -> FloatArray:
        """Return the true forces on the feet, world axes."""
        frames = frames_on(reading.normals_on(self._terrain))
        forces = np.zeros((self._feet, 3))
        np.add.at(forces, self._foot, np.einsum("pij,pj->pi", frames, reading.forces))
        return forces
