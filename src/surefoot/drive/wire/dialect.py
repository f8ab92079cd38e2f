"""Unitree's messages as readings and targets: which robot speaks which, in which order, and what is void."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np

from surefoot.control.controller import JointTargets
from surefoot.drive.readings import RobotReadings
from surefoot.drive.wire import messages
from surefoot.drive.wire.checksum import checksum
from surefoot.errors import ProblemError
from surefoot.robot import Robot
from surefoot.spatial import quaternion_wxyz, quaternion_xyzw

HEAD, LOW_LEVEL, ENABLED = [0xFE, 0xEF], 0xFF, 1
"""First bytes of a quadruped's messages, its level of commands to motors, and the mode of one that obeys."""
TICK = 1e-3
"""Length of a tick of the robot's clock [s]."""
LEGS, PARTS = ("FR", "FL", "RR", "RL"), ("hip", "thigh", "calf")
QUADRUPED = tuple(f"{leg}_{part}_joint" for leg in LEGS for part in PARTS)


def blank(kind: Any) -> Any:
    """Return a message, or a part of one, of zeros."""
    said = getattr(kind, "__metadata__", None)
    if said is None:
        return kind(**{field.name: blank(field.type) for field in fields(kind)})
    if isinstance(said[0], str):
        return 0.0 if said[0] == "float32" else 0
    return [blank(said[0].subtype) for _ in range(said[0].length)]


@dataclass(frozen=True)
class Dialect:
    """How a robot speaks.

    Attributes
    ----------
    motors
        Names of its joints in the order of its motors.
    state, command
        Classes of its messages.
    headed
        Whether they begin with `HEAD`; if not, commands repeat the state's `mode_machine`.
    """

    motors: tuple[str, ...]
    state: Any
    command: Any
    headed: bool
    _said: list[Any] = field(default_factory=list, init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        # messages are made once: what is returned holds until the next of its kind
        self._said.extend((blank(self.state), blank(self.command)))
        for message in self._said if self.headed else ():
            message.head, message.level_flag = list(HEAD), LOW_LEVEL

    def told(self, readings: RobotReadings, mode_machine: int = 0) -> Any:
        """Return the message of a robot that reads this, joints in the order of the motors."""
        message = self._message(0, mode_machine)
        imu = message.imu_state
        imu.quaternion = quaternion_wxyz(readings.quaternion).tolist()
        imu.gyroscope, imu.accelerometer = readings.gyro.tolist(), readings.accelerometer.tolist()
        rows = zip(*(values.tolist() for values in readings[4:7]), strict=True)
        for motor, row in zip(message.motor_state, rows, strict=False):
            motor.mode, (motor.q, motor.dq, motor.tau_est) = ENABLED, row
        message.tick = round(readings.time / TICK) % 2**32
        message.crc = checksum(message)
        return message

    def readings(self, message: Any) -> RobotReadings | None:
        """Return what a robot's message reads; None for a wrong checksum or a motor that does not obey."""
        motors = message.motor_state[: len(self.motors)]
        if not self._sound(message) or any(motor.mode != ENABLED for motor in motors):
            return None
        imu, rows = message.imu_state, np.array([(m.q, m.dq, m.tau_est) for m in motors]).T
        attitude = quaternion_xyzw(imu.quaternion)
        vectors = np.array(imu.gyroscope), np.array(imu.accelerometer)
        return RobotReadings(message.tick * TICK, attitude, *vectors, *rows)

    def asked(self, targets: JointTargets, mode_machine: int = 0) -> Any:
        """Return the message that asks for targets, joints in the order of the motors."""
        message = self._message(1, mode_machine)
        rows = zip(*(values.tolist() for values in targets), strict=True)
        for motor, row in zip(message.motor_cmd, rows, strict=False):
            motor.mode, (motor.q, motor.dq, motor.kp, motor.kd, motor.tau) = ENABLED, row
        message.crc = checksum(message)
        return message

    def targets(self, message: Any, mode_machine: int = 0) -> JointTargets | None:
        """Return what a message asks for; None if a robot would not listen. A motor of mode 0 is off."""
        headed = list(message.head) == HEAD if self.headed else message.mode_machine == mode_machine
        if not headed or not self._sound(message):
            return None
        motors = message.motor_cmd[: len(self.motors)]
        rows = np.array([(m.q, m.dq, m.kp, m.kd, m.tau) for m in motors]).T
        if not np.isfinite(rows).all():
            return None
        rows[2:, [m.mode != ENABLED for m in motors]] = 0.0
        return JointTargets(*rows)

    def _message(self, which: int, mode_machine: int) -> Any:
        """Return the state's message or the command's, to be filled anew."""
        message = self._said[which]
        if not self.headed:
            message.mode_machine = mode_machine
        return message

    @staticmethod
    def _sound(message: Any) -> bool:
        """Return whether the checksum is right."""
        try:
            return bool(checksum(message) == message.crc)
        except (ArithmeticError, ValueError):
            return False


MOTORS = {"go2": QUADRUPED, "b2": QUADRUPED, "g1": None}
"""Robots that speak, and their motors; None for a humanoid, whose joints stand in the motors' order."""


def dialect_of(robot: Robot) -> Dialect:
    """Return how a robot speaks.

    Raises
    ------
    ProblemError
        For a robot that is not known to, or whose joints have other names.
    """
    if robot.name not in MOTORS:
        raise ProblemError(
            f"{robot.name} speaks no language of the wire that is known here: {', '.join(MOTORS)} do"
        )
    motors = MOTORS[robot.name]
    if motors is None:
        return Dialect(robot.joint_names, messages.HG_STATE, messages.HG_COMMAND, False)
    found = Dialect(motors, messages.GO_STATE, messages.GO_COMMAND, True)
    if sorted(found.motors) != sorted(robot.joint_names):
        raise ProblemError(
            f"the joints of {robot.name} are not those of its motors: {', '.join(found.motors)}"
        )
    return found
