"""What can be wrong between a robot and its controller: noisy sensors, late commands, weak motors."""

from __future__ import annotations

import copy
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, real_number
from surefoot.base.errors import ProblemError, check_name
from surefoot.base.memory import Remembering
from surefoot.base.spatial import quaternion_from_rotation, rotation_exp, rotation_from_quaternion
from surefoot.mechanics import Robot
from surefoot.motion import Command, RobotState
from surefoot.worlds.interface.world import World


@dataclass(frozen=True)
class Faults:
    """Levels of the faults of a run; all zero by default.

    Attributes
    ----------
    noise
        Standard deviation of white noise on the measured state, in units of: joint angles 0.01 rad,
        joint speeds 0.2 rad/s, base position 0.01 m, orientation 0.01 rad, velocity 0.05 m/s, turn rate
        0.05 rad/s.
    delay
        Time between a measurement and its torques [s].
    weak_joint, torque_loss
        Name of a joint, and the share of its torque that is lost.
    strength
        Torque that every motor gives over the one asked for.
    dropouts
        (start, duration) of times in which the controller gets the state before them, again and again [s].
    """

    noise: float = 0.0
    delay: float = 0.0
    weak_joint: str = ""
    torque_loss: float = 0.0
    strength: float = 1.0
    dropouts: Sequence[tuple[float, float]] = ()

    def __post_init__(self) -> None:
        if self.torque_loss and not self.weak_joint:
            raise ProblemError("a torque loss is of a weak joint: name it")

    def start(self, world: World, seed: int | None) -> ActiveFaults:
        """Return the faults at work in a world, their noise seeded.

        Raises
        ------
        ProblemError
            For a negative level or a joint that the robot does not have.
        """
        real_number("noise", self.noise, low=0.0)
        real_number("torque loss", self.torque_loss, low=0.0, high=1.0)
        names = world.robot.joint_names
        strength = np.full(len(names), real_number("strength", self.strength, low=0.0, high=10.0))
        if self.weak_joint:
            check_name("joint", self.weak_joint, names)
            strength[names.index(self.weak_joint)] *= 1.0 - self.torque_loss
        late = round(real_number("delay", self.delay, low=0.0, high=1.0) / world.dt)
        for start, duration in self.dropouts:
            real_number("start of a dropout", start, low=0.0)
            real_number("duration of a dropout", duration, low=0.0)
        generator = np.random.default_rng([0 if seed is None else seed, 1])
        return ActiveFaults(self, strength, late, generator, world.robot.effort_limits)


@dataclass
class ActiveFaults(Remembering):
    """The faults of one run; made by `Faults.start`."""

    MEMORY = ("generator", "_queue", "_reached")

    levels: Faults
    strength: FloatArray
    late: int
    generator: np.random.Generator
    effort: FloatArray
    _queue: deque[Command] = field(default_factory=deque)

    def __post_init__(self) -> None:
        self._reached: RobotState | None = None
        self.weak = bool((self.strength != 1.0).any())

    def sense(self, q: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the state, q (nq,) [m, -, rad] and v (nv,) [m/s, rad/s], as the controller sees it."""
        r, level = self.generator, self.levels.noise
        if level == 0.0:
            return q, v
        q, v = q.copy(), v.copy()
        q[:3] += 0.01 * level * r.normal(size=3)
        turn = 0.01 * level * r.normal(size=3)
        q[3:7] = quaternion_from_rotation(rotation_exp(turn) @ rotation_from_quaternion(q[3:7]))
        q[7:] += 0.01 * level * r.normal(size=len(q) - 7)
        v[:6] += 0.05 * level * r.normal(size=6)
        v[6:] += 0.2 * level * r.normal(size=len(v) - 6)
        return q, v

    def heard(self, state: RobotState) -> RobotState:
        """Return the state that reaches the controller: in a dropout the last one before it."""
        if self.levels.dropouts and self._reached is not None:
            now = state.time + 1e-9
            if any(start <= now < start + duration for start, duration in self.levels.dropouts):
                return self._reached
        self._reached = state
        return state

    def act(self, command: Command, q: FloatArray, v: FloatArray) -> FloatArray:
        """Return the torques (joints,) [N m] that the motors are to give: late and weakened.

        A late command's joint targets are followed from the joints' state as it is, (nq,) q [rad] and (nv,) v
        [rad/s]: drives know that without a delay.
        """
        if self.late:
            self._queue.append(command)
            command = self._queue[0] if len(self._queue) <= self.late else self._queue.popleft()
        torques, joints = command.torques, len(self.strength)
        if command.joint_targets is not None:
            torques = command.joint_targets.torques(q[len(q) - joints :], v[len(v) - joints :])
            torques = np.minimum(np.maximum(torques, -self.effort), self.effort)
        return torques * self.strength if self.weak else torques


def scaled_robot(
    robot: Robot, mass: float = 1.0, inertia: float = 1.0, shift: ArrayLike = (0.0, 0.0, 0.0)
) -> Robot:
    """Return the robot with other masses; geometry and limits stay.

    Parameters
    ----------
    robot
        It is left as it is.
    mass, inertia
        Factors of all masses with their inertias, and of inertias about the links' own centres once more.
    shift
        (3,) of the base's centre of mass: forward, left, up [m].
    """
    scale, again = (
        real_number(f"{name} factor", value, low=1e-3, high=1e3)
        for name, value in (("mass", mass), ("inertia", inertia))
    )
    moved = np.asarray(shift, dtype=np.float64)
    if scale == again == 1.0 and not moved.any():
        return robot
    out, model = copy.copy(robot), robot.model.copy()
    for k in range(model.njoints):
        own = model.inertias[k]
        lever = own.lever + moved if k == 1 else own.lever
        model.inertias[k] = type(own)(scale * own.mass, lever, scale * again * own.inertia)
    out.__dict__.pop("mass", None)  # a cached sum
    out.model, out.data = model, model.createData()
    return out
