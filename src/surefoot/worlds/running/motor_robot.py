"""A robot in MuJoCo as a loop of joint targets meets it: motors, noisy sensors, a delay; and by wire."""

from __future__ import annotations

import time as clock
from collections import deque
from typing import TYPE_CHECKING

import numpy as np

from surefoot.base.arrays import FloatArray, real_number
from surefoot.base.memory import Memory, Remembering
from surefoot.base.spatial import quaternion_from_rotation, rotation_from_quaternion
from surefoot.mechanics import Robot, Terrain
from surefoot.motion import BodyPostures, JointTargets, RobotReadings, damping_targets, motor_order
from surefoot.worlds.interface.world_state import WorldState
from surefoot.worlds.mujoco.mujoco_world import MujocoWorld
from surefoot.worlds.running.sensors import SensorModel, Sensors

if TYPE_CHECKING:  # DDS is an extra of its own: a robot without a wire needs none
    from surefoot.motion import Dialect, PackedMessage, WireEnd

DROP = 0.01
"""How high above the ground a robot that lies is let go [m]."""


class MotorRobot(Remembering):
    """Takes joint targets and gives readings; nothing else of the robot's motion is known outside.

    The drives close their loop at every step of the world, see `JointTargets.torques`, within the motors'
    limits; targets take effect `delay` after they were given.

    Parameters
    ----------
    robot
        With a floating base.
    dt
        Time between readings [s]; the world's steps are of 1 ms.
    delay
        From targets to motors [s].
    terrain, mu
        The ground.
    seed
        Of the sensors' random numbers.

    Attributes
    ----------
    world
        Where it is in truth: a `MujocoWorld` with real motors, in which all links may touch.
    torques
        (joints,) that the motors gave last [N m].
    """

    MEMORY = ("sensors", "_error", "_queue", "torques", "_count", "_given")

    def __init__(
        self,
        robot: Robot,
        dt: float = 0.002,
        delay: float = 0.004,
        terrain: Terrain | None = None,
        mu: float = 0.6,
        seed: int = 0,
    ) -> None:
        self.robot, self.dt = robot, real_number("dt", dt, low=1e-3, high=0.1)
        self.world = MujocoWorld(robot, terrain, mu, 1e-3, collision="full", actuators="real")
        self._steps = round(dt / self.world.dt)
        late = round(real_number("delay", delay, low=0.0, high=0.1) / self.world.dt)
        self._model, self._seed = SensorModel(), seed
        self._damp = damping_targets(robot, self.world.dt)
        self._queue: deque[JointTargets] = deque(maxlen=late + 1)
        self.reset(robot.nominal)

    def reset(self, q: FloatArray) -> None:
        """Put the robot at (nq,) q [m, -, rad], at rest, its joints damped."""
        self.world.reset(q)
        self.sensors = Sensors(self._model, self.robot, self.dt, self._seed)
        tilted = rotation_from_quaternion(self.sensors.attitude_at_start(q)[3:7])
        self._error = tilted @ rotation_from_quaternion(q[3:7]).T
        self._queue.clear()
        self.torques, self._count = np.zeros(self.robot.joints), 0
        self.take(self._damp)

    def lie_down(self) -> None:
        """Put the robot on its belly, legs folded."""
        self.reset(lying(self.robot, self.world.terrain))

    @property
    def state(self) -> tuple[WorldState, Memory]:
        """A copy of all that lasts from one reading to the next: of the world, and of sensors and targets."""
        return self.world.state, self.remembered()

    def go_on(self, state: tuple[WorldState, Memory]) -> None:
        """Go on from the `state` of a robot that was made in the same way, to the last bit.

        Raises
        ------
        ProblemError
            For one that does not fit.
        """
        world, own = state
        self.world.resume(world)
        self.resume(own)

    def take(self, targets: JointTargets | None) -> None:
        """Take (joints,) targets for the drives; None damps the joints, as when nothing comes any more."""
        self._given = self._damp if targets is None else targets

    @property
    def time(self) -> float:
        """Simulated time since the last reset [s]."""
        return self._count * self.dt

    def step(self, push: FloatArray | None = None) -> None:
        """Go on to the next reading, under a (3,) force on the base [N], world axes."""
        for _ in range(self._steps):
            self._queue.append(self._given)
            q, v = self.world.q_v()
            self.world.step(self._queue[0].torques(q[7:], v[6:]), push)
        self.torques = np.asarray(self.world.applied)
        self._count += 1

    def read(self) -> RobotReadings:
        """Return what sensors and motors say now; once a step."""
        q, v = self.world.q_v()
        reading = self.sensors.read(q, v)
        attitude = quaternion_from_rotation(self._error @ rotation_from_quaternion(q[3:7]))
        return RobotReadings(self.time, attitude, *reading, self.sensors.torques(self.torques))


def lying(robot: Robot, terrain: Terrain) -> FloatArray:
    """Return the (nq,) configuration [m, -, rad] of a robot on its belly, just above the ground."""
    postures, q = BodyPostures(robot), robot.nominal.copy()
    q[7:] = postures.way(postures.lie, postures.lie).points[0]
    q[2] = -min(robot.sphere_bottoms(q)) + q[2] + DROP
    slope = terrain.frame([0.0, 0.0])
    q[:3] = slope @ q[:3]
    q[3:7] = quaternion_from_rotation(slope @ rotation_from_quaternion(q[3:7]))
    return q


SILENCE = 0.02
"""Time without a command that can be obeyed, after which the joints are damped [s]."""
MACHINE = 5
"""A humanoid's `mode_machine`."""
PATIENT = 1.0
"""Time without an answer in slow motion after which a state is said again [s]."""


class WiredRobot:
    """Says what its sensors read and does what commands ask for; damps its joints when none comes.

    Parameters
    ----------
    robot
        The robot.
    end
        Of the wire.
    dialect
        What is spoken there.
    slow
        Whether each state waits for its answer, and the robot's time for the first command: slower than real
        time on a busy machine, and nothing is late.

    Attributes
    ----------
    damped
        How many steps it has damped by itself since the first command.
    """

    def __init__(self, robot: MotorRobot, end: WireEnd, dialect: Dialect, slow: bool = False) -> None:
        self.robot, self.end, self.dialect, self.slow = robot, end, dialect, slow
        self._back, self._order = motor_order(robot.robot, dialect.motors)
        self._silent, self._heard, self.damped = 0.0, False, 0
        self._due = clock.perf_counter()

    def step(self) -> None:
        """Say what is read, listen, and go on by a step."""
        robot = self.robot
        state = self.dialect.state_message(robot.read().ordered(self._order), MACHINE)
        self.end.send(state)
        self._due = max(self._due + robot.dt, clock.perf_counter() - robot.dt)
        message = self._listen(state)
        targets = None if message is None else self.dialect.targets(message, MACHINE)
        if targets is None and self.slow and not self._heard:
            return
        if targets is not None:
            self._heard, self._silent = True, 0.0
            robot.take(JointTargets(*(values[self._back] for values in targets)))
        else:
            self._silent += robot.dt
            if self._silent >= SILENCE - 1e-9:
                self.damped += self._heard
                robot.take(None)
        robot.step()
        left = self._due - clock.perf_counter()
        if left > 0.0 and not self.slow:
            clock.sleep(left)

    def _listen(self, state: PackedMessage) -> PackedMessage | None:
        """Return the command that comes in time; in slow motion the answer, if anybody is there."""
        if not self.slow or self._silent:
            return self.end.receive(max(self._due - clock.perf_counter(), 1e-5))
        message = self.end.receive(PATIENT)
        while message is None and self._heard and self.end.partners():
            self.end.send(state)
            message = self.end.receive(PATIENT)
        return message
