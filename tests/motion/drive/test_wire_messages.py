"""Messages of the wire without a wire: layouts, checksums, what makes one void, bytes that never change."""

from __future__ import annotations

import base64
import json

import numpy as np
import pytest

import surefoot as sf
from surefoot.motion.control.controller import JointTargets
from surefoot.motion.drive.wire.dialect import dialect_of
from surefoot.motion.drive.wire.packed import PackedMessage
from tests.motion.drive.wire_table import COUNT, MACHINE, TABLE, packed, targets

ROBOTS = {"go2": (812, 1180), "g1": (1004, 2092)}
"""Sizes of Unitree's C structures of commands and states [bytes]."""
CHECKSUMS = {"go2": (0xAE6B986F, 0xF33BAD20), "g1": (0x674CCCAE, 0xD9500433)}
"""Of the messages below: remainders of long divisions of the C structures that `struct` packs."""


def readings(joints: int) -> sf.RobotReadings:
    rng = np.random.default_rng(2)
    attitude = np.array([0.0, 0.6, 0.0, 0.8])
    return sf.RobotReadings(1.234, attitude, *rng.normal(size=(2, 3)), *rng.normal(size=(3, joints)))


@pytest.mark.parametrize("name", ROBOTS)
def test_messages_come_back(name: str) -> None:
    robot = sf.load_robot(name)
    dialect, sent = dialect_of(robot), readings(robot.joints)
    message = dialect.state_message(sent, mode_machine=5)
    again = dialect.readings(PackedMessage(dialect.state, bytes(message.data)))
    assert again is not None
    assert all(np.allclose(a, b, atol=1e-6) for a, b in zip(sent[:7], again[:7], strict=True))
    asked = JointTargets(*np.random.default_rng(3).normal(size=(5, robot.joints)))
    command = dialect.command_message(asked, 5)
    heard = dialect.targets(command, 5)
    assert heard is not None
    assert np.allclose(np.array(heard), np.array(asked), atol=1e-6)
    assert (command.layout.structure, message.layout.structure) == ROBOTS[name]
    assert (message["crc"], command["crc"]) == CHECKSUMS[name]


@pytest.mark.parametrize("name", ROBOTS)
def test_void_messages(name: str) -> None:
    robot = sf.load_robot(name)
    dialect = dialect_of(robot)
    targets = JointTargets(*np.ones((5, robot.joints)))

    def spoiled(field: str, value: object, of: int = 0, seal: bool = True) -> bool:
        state = of == 0
        message = dialect.state_message(readings(robot.joints)) if state else dialect.command_message(targets)
        motors = f"{'motor_state' if state else 'motor_cmd'}.{field}"
        field = motors if motors in message.layout.places else field
        kept = message[field]
        message[field] = value
        if seal:
            message.seal()
        void = (dialect.readings(message) if state else dialect.targets(message)) is None
        message[field] = kept
        return void

    assert spoiled("q", 0.5, seal=False)
    assert spoiled("mode", 0)
    assert spoiled("q", 0.5, of=1, seal=False)
    assert spoiled("tau", float("nan"), of=1)
    assert spoiled("head", [0, 0], of=1) if name == "go2" else spoiled("mode_machine", 4, of=1)
    assert not spoiled("q", 0.5)
    off = dialect.command_message(targets)
    off["motor_cmd.mode"] = [1, 1, 0]
    heard = dialect.targets(off.seal())
    assert heard is not None
    assert heard.feedforward[2] == heard.stiffness[2] == heard.damping[2] == 0.0
    assert heard.feedforward[3] == 1.0


@pytest.mark.parametrize("name", ROBOTS)
def test_bytes_are_those_of_the_table(name: str) -> None:
    """Twenty fixed commands, equal byte for byte to what Unitree's SDK packs and seals."""
    kept = [base64.b64decode(text) for text in json.loads(TABLE.read_text(encoding="utf-8"))[name]]
    assert packed(name) == kept
    robot = sf.load_robot(name)
    dialect = dialect_of(robot)
    assert len(set(kept)) == COUNT
    for k, data in enumerate(kept):
        heard = dialect.targets(PackedMessage(dialect.command, data), MACHINE)
        assert heard is not None
        np.testing.assert_array_equal(np.array(heard), np.array(targets(k, robot.joints)))
