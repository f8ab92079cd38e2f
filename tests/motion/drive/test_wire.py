"""The wire: message layouts, checksums, what makes a message void, and two processes that talk over it."""

from __future__ import annotations

import json
import os
import subprocess
import sys

import numpy as np
import pytest

import surefoot as sf
from surefoot.motion.control.controller import JointTargets

pytest.importorskip("cyclonedds", reason="the wire is of surefoot[wire]")

from surefoot.motion.drive.wire.dds_types import carrier_type, dds_type
from surefoot.motion.drive.wire.dialect import dialect_of
from surefoot.motion.drive.wire.messages import GO_COMMAND, GO_STATE, HG_COMMAND, HG_STATE, Structure
from surefoot.motion.drive.wire.packed import PackedMessage

GO2_WEIGHT = 157.8
"""m g [N]."""
ROBOTS = {"go2": (812, 1180), "g1": (1004, 2092)}
"""Sizes of Unitree's C structures of commands and states [bytes]."""
CHECKSUMS = {"go2": (0xAE6B986F, 0xF33BAD20), "g1": (0x674CCCAE, 0xD9500433)}
"""Of the messages below: remainders of long divisions of the C structures that `struct` packs."""

ANNOUNCED = {
    GO_STATE: ("853a99e23d0daa1610b65c526b40", "08f239c471d3a27e67e7c7723184"),
    GO_COMMAND: ("832876ceec9737d69f6ed62a3f63", "52cc8eb0d427d692aa2b20a90540"),
    HG_STATE: ("2f38296b52aa0230b92d378b1e39", "2be9706c9587e8d8afd8bfc6de7b"),
    HG_COMMAND: ("6569fc15f0d47aa8600b9e91fbbc", "42b0283aa7e1bb592ec898a0dbed"),
}
"""How Cyclone DDS 0.10.2 announces the types of Unitree's SDK: hashes of the minimal and complete type."""


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
    for packed in (message, command):  # field by field, as cyclonedds does it for anybody's messages
        idl = dds_type(packed.kind).__idl__
        unpacked = idl.deserialize(bytes(packed.data))
        assert idl.serialize(unpacked, use_version_2=False) == packed.data
        other = idl.serialize(unpacked, use_version_2=True)
        assert carrier_type(packed.kind).deserialize(other).data == packed.data
    assert unpacked.motor_cmd[3].tau == pytest.approx(asked.feedforward[3])


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


@pytest.mark.parametrize("kind", ANNOUNCED, ids=lambda kind: f"{kind.family}.{kind.name}")
def test_types_are_announced_as_an_older_dds_knows_them(kind: Structure) -> None:
    """`uint8` of Cyclone DDS 11 is unknown to 0.10.2, and ends every process of it on the topic."""
    idl = carrier_type(kind).__idl__
    idl.fill_type_data()
    announced = idl.get_type_info()
    hashes = [getattr(announced, of).typeid_with_size.type_id.value.hex() for of in ("minimal", "complete")]
    assert tuple(hashes) == ANNOUNCED[kind]


AT_THE_END = """
import sys
import surefoot as sf
from cyclonedds.domain import Domain
from surefoot.motion.drive.wire.dialect import dialect_of
from surefoot.motion.drive.wire.link import WireEnd
delete, ending, say = Domain.__del__, sys.is_finalizing, sys.stdout.write
Domain.__del__ = lambda domain: (say(f"deleted late: {ending()}"), delete(domain))
WireEnd(dialect_of(sf.load_robot("go2")), False, "lo", int(sys.argv[1])).close()
"""


def test_no_process_waits_for_the_wire_at_its_end() -> None:
    """Threads of DDS that want the interpreter while it ends are gone: what waits for them waits for ever."""
    command = [sys.executable, "-c", AT_THE_END, str(160 + os.getpid() % 50)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60)
    assert done.stdout == "deleted late: False", done.stderr


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
    assert told["balanced"] > 4.0
    assert said["place"][0] > 1.6
    assert said["highest"] > 0.32
    assert said["torque_use"] <= 1.0 + 1e-9
    kept = sf.read_log(log)
    assert float(np.mean(kept["forces"][..., 2].sum(axis=1))) == pytest.approx(GO2_WEIGHT, rel=0.1)
