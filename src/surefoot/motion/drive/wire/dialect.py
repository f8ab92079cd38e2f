"""Unitree's messages as readings and targets: which robot speaks which, in which order, and what is void."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from surefoot.base.errors import ProblemError
from surefoot.base.spatial import quaternion_wxyz, quaternion_xyzw
from surefoot.mechanics import Robot
from surefoot.motion.control.controller import JointTargets
from surefoot.motion.drive.readings import RobotReadings
from surefoot.motion.drive.wire import messages
from surefoot.motion.drive.wire.messages import Structure
from surefoot.motion.drive.wire.packed import PackedMessage

HEAD, LOW_LEVEL, ENABLED = (0xFE, 0xEF), 0xFF, 1
"""First bytes of a quadruped's messages, its level of commands to motors, and the mode of one that obeys."""
TICK = 1e-3
"""Length of a tick of the robot's clock [s]."""
IMU = ("quaternion", "gyroscope", "accelerometer")
STATE_FIELDS = ("motor_state.q", "motor_state.dq", "motor_state.tau_est")
COMMAND_FIELDS = tuple(f"motor_cmd.{name}" for name in ("q", "dq", "kp", "kd", "tau"))
"""Names of what motors measure and of what is commanded, in the order of readings and of targets."""
LEGS, PARTS = ("FR", "FL", "RR", "RL"), ("hip", "thigh", "calf")
QUADRUPED = tuple(f"{leg}_{part}_joint" for leg in LEGS for part in PARTS)


@dataclass(frozen=True)
class Dialect:
    """How a robot speaks.

    Attributes
    ----------
    motors
        Names of its joints in the order of its motors.
    state, command
        Structures of its messages.
    headed
        Whether they begin with `HEAD`; if not, commands repeat the state's `mode_machine`.
    simulator
        Whether states may come from a simulator of Unitree's, which leaves checksums and modes of motors 0.
    """

    motors: tuple[str, ...]
    state: Structure
    command: Structure
    headed: bool
    simulator: bool = False
    _messages: list[PackedMessage] = field(default_factory=list, init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        # messages are made once: what is returned holds until the next of its kind
        self._messages.extend((PackedMessage(self.state), PackedMessage(self.command)))
        for message in self._messages if self.headed else ():
            message["head"], message["level_flag"] = HEAD, LOW_LEVEL
        self._messages[0].seal()  # compiles or loads the checksum before anybody waits for it

    def of_simulator(self) -> Dialect:
        """Return the same dialect as Unitree's simulators speak it."""
        return replace(self, simulator=True)

    def state_message(self, readings: RobotReadings, mode_machine: int = 0) -> PackedMessage:
        """Return the message of a robot that reads this, joints in the order of the motors."""
        message = self._message(0, mode_machine)
        message["imu_state.quaternion"] = quaternion_wxyz(readings.quaternion)
        message["imu_state.gyroscope"] = readings.gyro
        message["imu_state.accelerometer"] = readings.accelerometer
        for name, values in zip(STATE_FIELDS, readings[4:7], strict=True):
            message[name] = values
        message["motor_state.mode"] = [ENABLED] * len(self.motors)
        message["tick"] = round(readings.time / TICK) % 2**32
        return message.seal()

    def refusal(self, message: PackedMessage) -> str:
        """Return why a robot's message is void, empty if it is not."""
        bare = self.simulator and int(message["crc"]) == 0
        if not bare and not message.sealed:
            return "checksum 0" if int(message["crc"]) == 0 else "a wrong checksum"
        modes = message["motor_state.mode"][: len(self.motors)]
        off = modes != ENABLED
        if not off.any() or (self.simulator and not modes.any()):
            return ""
        return f"motors in mode {modes[off][0]}"

    def readings(self, message: PackedMessage) -> RobotReadings | None:
        """Return what a robot's message reads; None for one that is void, see `refusal`."""
        if self.refusal(message):
            return None
        count = len(self.motors)
        imu = [message[f"imu_state.{name}"].astype(float) for name in IMU]
        rows = [message[name][:count].astype(float) for name in STATE_FIELDS]
        return RobotReadings(int(message["tick"]) * TICK, quaternion_xyzw(imu[0]), *imu[1:], *rows)

    def command_message(self, targets: JointTargets, mode_machine: int = 0) -> PackedMessage:
        """Return the message that asks for targets, joints in the order of the motors."""
        message = self._message(1, mode_machine)
        for name, values in zip(COMMAND_FIELDS, targets, strict=True):
            message[name] = values
        message["motor_cmd.mode"] = [ENABLED] * len(self.motors)
        return message.seal()

    def targets(self, message: PackedMessage, mode_machine: int = 0) -> JointTargets | None:
        """Return what a message asks for; None if a robot would not listen. A motor of mode 0 is off."""
        headed = tuple(message["head"]) == HEAD if self.headed else message["mode_machine"] == mode_machine
        if not headed or not message.sealed:
            return None
        count = len(self.motors)
        rows = np.array([message[name][:count] for name in COMMAND_FIELDS], dtype=float)
        if not np.isfinite(rows).all():
            return None
        rows[2:, message["motor_cmd.mode"][:count] != ENABLED] = 0.0
        return JointTargets(*rows)

    def _message(self, which: int, mode_machine: int) -> PackedMessage:
        """Return the state's message or the command's, to be filled anew."""
        message = self._messages[which]
        if not self.headed:
            message["mode_machine"] = mode_machine
        return message


MOTORS = {"go2": QUADRUPED, "b2": QUADRUPED, "g1": None}
"""Robots that speak, and their motors; None for a humanoid, whose joints stand in the motors' order."""


def dialect_of(robot: Robot, simulator: bool = False) -> Dialect:
    """Return how a robot speaks, or one of Unitree's simulators for it.

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
        return Dialect(robot.joint_names, messages.HG_STATE, messages.HG_COMMAND, False, simulator)
    found = Dialect(motors, messages.GO_STATE, messages.GO_COMMAND, True, simulator)
    if sorted(found.motors) != sorted(robot.joint_names):
        raise ProblemError(
            f"the joints of {robot.name} are not those of its motors: {', '.join(found.motors)}"
        )
    return found
