"""The wire: message layouts, checksums, what makes a message void, and two processes that talk over it."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys

import numpy as np
import pytest

import surefoot as sf
from surefoot.control.controller import JointTargets

pytest.importorskip("cyclonedds", reason="the wire is of surefoot[wire]")

from surefoot.drive.wire.checksum import checksum, flat, layout
from surefoot.drive.wire.dialect import dialect_of

GO2_WEIGHT = 157.8
"""m g [N]."""
ROBOTS = {"go2": (812, 1180), "g1": (1004, 2092)}
"""Sizes of Unitree's C structures of commands and states [bytes]."""


def readings(joints: int) -> sf.RobotReadings:
    rng = np.random.default_rng(2)
    attitude = np.array([0.0, 0.6, 0.0, 0.8])
    return sf.RobotReadings(1.234, attitude, *rng.normal(size=(2, 3)), *rng.normal(size=(3, joints)))


@pytest.mark.parametrize("name", ROBOTS)
def test_messages_come_back(name: str) -> None:
    robot = sf.load_robot(name)
    dialect, sent = dialect_of(robot), readings(robot.joints)
    assert (layout(dialect.command).size, layout(dialect.state).size) == ROBOTS[name]
    message = dialect.told(sent, mode_machine=5)
    again = dialect.readings(type(message).deserialize(message.serialize()))
    assert again is not None
    assert all(np.allclose(a, b, atol=1e-6) for a, b in zip(sent[:7], again[:7], strict=True))
    asked = JointTargets(*np.random.default_rng(3).normal(size=(5, robot.joints)))
    command = dialect.asked(asked, 5)
    heard = dialect.targets(type(command).deserialize(command.serialize()), 5)
    assert heard is not None
    assert np.allclose(np.array(heard), np.array(asked), atol=1e-6)
    # the remainder of a long division of polynomials, in whole numbers
    words = np.frombuffer(layout(type(command)).pack(*flat(command, [])), "<u4")[:-1]
    bits = 0
    for word in words:
        bits = bits << 32 | int(word)
    bits = (bits ^ 0xFFFFFFFF << 32 * (len(words) - 1)) << 32
    while bits.bit_length() > 32:
        bits ^= 0x104C11DB7 << bits.bit_length() - 33
    assert command.crc == bits


@pytest.mark.parametrize("name", ROBOTS)
def test_void_messages(name: str) -> None:
    robot = sf.load_robot(name)
    dialect = dialect_of(robot)
    targets = JointTargets(*np.ones((5, robot.joints)))

    def spoiled(field: str, value: object, of: int = 0, seal: bool = True) -> bool:
        state = of == 0
        message = dialect.told(readings(robot.joints)) if state else dialect.asked(targets)
        motor = message.motor_state[3] if state else message.motor_cmd[3]
        part = motor if hasattr(motor, field) else message
        kept = getattr(part, field)
        setattr(part, field, value)
        if seal:
            message.crc = checksum(message)
        void = (dialect.readings(message) if state else dialect.targets(message)) is None
        setattr(part, field, kept)
        return void

    assert spoiled("q", 0.5, seal=False)
    assert spoiled("mode", 0)
    assert spoiled("q", 0.5, of=1, seal=False)
    assert spoiled("tau", float("nan"), of=1)
    assert spoiled("head", [0, 0], of=1) if name == "go2" else spoiled("mode_machine", 4, of=1)
    assert not spoiled("q", 0.5)
    off = dialect.asked(targets)
    off.motor_cmd[2].mode = 0
    off.crc = checksum(off)
    heard = dialect.targets(off)
    off.motor_cmd[2].mode = 1
    assert heard is not None
    assert heard.feedforward[2] == heard.stiffness[2] == heard.damping[2] == 0.0
    assert heard.feedforward[3] == 1.0


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("--interface eth7", "hang it up.* --yes-real-robot"),
        ("--terrain-knowledge map", "valid names: blind, exact"),
    ],
)
def test_words_that_drive_refuses(words: str, said: str) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "surefoot", "drive", "go2", *words.split()],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 2
    assert re.search(said, " ".join(done.stderr.split()))


@pytest.mark.long
def test_two_processes_walk(tmp_path: os.PathLike[str]) -> None:
    """Up, 0.5 m/s for 4 s, stop, sit: in slow motion, since machines that run tests are busy."""
    log = os.path.join(tmp_path, "walk.mcap")
    wire = ["--domain", str(60 + os.getpid() % 100), "--slow-motion"]
    start = [sys.executable, "-m", "surefoot"]
    robot = subprocess.Popen(
        [*start, "robot", "go2", "--seconds", "16.0", "--json", *wire], stdout=subprocess.PIPE, text=True
    )
    try:
        drive = [*start, "drive", "go2", "--duration", "4", "--out", log, "--json", *wire]
        done = subprocess.run(drive, capture_output=True, text=True, check=False, timeout=300)
        said = json.loads(robot.communicate(timeout=120)[0])
    finally:
        robot.kill()
    assert done.returncode == 0, done.stdout + done.stderr
    told = json.loads(done.stdout)
    assert not told["fault"]
    assert told["balanced"] > 4.0
    assert said["place"][0] > 1.6
    assert said["highest"] > 0.32
    assert said["torque_use"] <= 1.0 + 1e-9
    kept = sf.read_log(log)
    assert kept.fact("robot") == "go2"
    assert float(np.mean(kept["forces"][..., 2].sum(axis=1))) == pytest.approx(GO2_WEIGHT, rel=0.1)
