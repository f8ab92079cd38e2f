"""The wire under DDS: how types are announced, who finds whom on `lo`, and processes that talk over it."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import surefoot as sf
from surefoot.motion.control.controller import JointTargets

pytest.importorskip("cyclonedds", reason="the wire is of surefoot[wire]")

from surefoot.motion.drive.wire import messages
from surefoot.motion.drive.wire.dds_types import carrier_type, dds_type
from surefoot.motion.drive.wire.dialect import Dialect, dialect_of
from surefoot.motion.drive.wire.link import WireEnd
from surefoot.motion.drive.wire.messages import GO_COMMAND, GO_STATE, HG_COMMAND, HG_STATE, Structure

GO2_WEIGHT = 157.8
"""m g [N]."""
ANNOUNCED = {
    GO_STATE: ("853a99e23d0daa1610b65c526b40", "08f239c471d3a27e67e7c7723184"),
    GO_COMMAND: ("832876ceec9737d69f6ed62a3f63", "52cc8eb0d427d692aa2b20a90540"),
    HG_STATE: ("2f38296b52aa0230b92d378b1e39", "2be9706c9587e8d8afd8bfc6de7b"),
    HG_COMMAND: ("6569fc15f0d47aa8600b9e91fbbc", "42b0283aa7e1bb592ec898a0dbed"),
}
"""How Cyclone DDS 0.10.2 announces the types of Unitree's SDK: hashes of the minimal and complete type."""


@pytest.mark.parametrize("name", ["go2", "g1"])
def test_messages_are_what_dds_packs(name: str) -> None:
    """Field by field, as cyclonedds does it for anybody's messages, in both encodings."""
    robot = sf.load_robot(name)
    dialect = dialect_of(robot)
    asked = JointTargets(*np.random.default_rng(3).normal(size=(5, robot.joints)))
    rng, attitude = np.random.default_rng(2), np.array([0.0, 0.6, 0.0, 0.8])
    read = sf.RobotReadings(1.234, attitude, *rng.normal(size=(2, 3)), *rng.normal(size=(3, robot.joints)))
    for packed in (dialect.state_message(read, 5), dialect.command_message(asked, 5)):
        idl = dds_type(packed.kind).__idl__
        unpacked = idl.deserialize(bytes(packed.data))
        assert idl.serialize(unpacked, use_version_2=False) == packed.data
        other = idl.serialize(unpacked, use_version_2=True)
        assert carrier_type(packed.kind).deserialize(other).data == packed.data
    assert unpacked.motor_cmd[3].tau == pytest.approx(asked.feedforward[3])


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
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=600)
    assert done.stdout == "deleted late: False", done.stderr


TALK = """
import sys
import surefoot as sf
from surefoot.motion.drive.wire.packed import PackedMessage
from surefoot.motion.drive.wire.dialect import dialect_of
from surefoot.motion.drive.wire.link import WireEnd
dialect = dialect_of(sf.load_robot("go2"))
end = WireEnd(dialect, False, "lo", int(sys.argv[1]))
sys.stdin.readline()
end.send(PackedMessage(dialect.command).seal())
sys.stdin.read()
end.close()
"""
"""A controller that listens, commands once when it is given a line, and stays until its input ends."""


def until(happens: Callable[[], bool], seconds: float = 60.0) -> bool:
    """Return whether something happens in time [s]."""
    end = time.monotonic() + seconds
    while not (now := happens()) and time.monotonic() < end:
        time.sleep(0.02)
    return now


def free_domain(first: int) -> int:
    """Return a domain that no other run of these tests is likely to use."""
    return first + os.getpid() % 20


@pytest.mark.long
def test_who_else_commands_is_known_and_named() -> None:
    domain = free_domain(100)
    dialect = dialect_of(sf.load_robot("go2"))
    with (
        closing(WireEnd(dialect, False, "lo", domain)) as end,
        closing(WireEnd(dialect, True, "lo", domain)) as robot,
    ):
        assert not end.rivals()  # neither its own commands nor a robot's states count
        other = subprocess.Popen(
            [sys.executable, "-c", TALK, str(domain)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        try:
            assert until(lambda: bool(end.neighbours()))
            time.sleep(0.5)
            assert not end.rivals()  # who only listens is none
            assert other.stdin is not None
            other.stdin.write("now\n")
            other.stdin.flush()
            assert until(lambda: bool(end.rivals()))
            (name,) = end.rivals()
            assert f"process {other.pid}" in name
            assert robot.rivals() == []
            assert any(f"process {other.pid}" in one for one in end.neighbours())
            other.communicate("")
            assert until(lambda: not end.rivals())
        finally:
            other.kill()


def speak(robot: WireEnd, dialect: Dialect, count: int) -> None:
    """Say a robot's state."""
    still, level = np.zeros(12), np.array([0.0, 0.0, 0.0, 1.0])
    up = np.array([0.0, 0.0, 9.81])
    robot.send(
        dialect.state_message(sf.RobotReadings(2e-3 * count, level, np.zeros(3), up, still, still, still))
    )


ECHO = """
import sys
import surefoot as sf
from surefoot.motion.drive.wire.dialect import dialect_of
from surefoot.motion.drive.wire.link import WireEnd
end = WireEnd(dialect_of(sf.load_robot("go2")), False, "lo", int(sys.argv[1]))
print("heard" if any(end.receive(0.5) is not None for _ in range(80)) else "silence")
end.close()
"""


def test_two_processes_find_each_other_on_lo_as_it_is() -> None:
    """Linux's `lo` has no multicast unless somebody switched it on; discovery must not need it."""
    domain = free_domain(130)
    dialect = dialect_of(sf.load_robot("go2"))
    environment = {name: value for name, value in os.environ.items() if name != "CYCLONEDDS_URI"}
    with closing(WireEnd(dialect, True, "lo", domain)) as robot:
        other = subprocess.Popen(
            [sys.executable, "-c", ECHO, str(domain)], stdout=subprocess.PIPE, text=True, env=environment
        )
        count = 0
        while other.poll() is None:
            count += 1
            speak(robot, dialect, count)
            time.sleep(0.02)
        assert other.communicate()[0].strip() == "heard"


OLDER = os.environ.get("SUREFOOT_OLDER_DDS", "")
"""A Python with cyclonedds 0.10.2, which has wheels up to CPython 3.10."""


@pytest.mark.long
@pytest.mark.skipif(not OLDER, reason="SUREFOOT_OLDER_DDS names no Python with cyclonedds 0.10.2")
def test_an_older_dds_survives_and_hears_commands() -> None:
    domain, folder = free_domain(200), Path(__file__).parent
    dialect = dialect_of(sf.load_robot("go2"))
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    other = subprocess.Popen(
        [OLDER, str(folder / "older_robot.py"), messages.__file__, str(domain), "20"],
        stdout=subprocess.PIPE, text=True, env=environment,
    )  # fmt: skip
    heard = 0
    with closing(WireEnd(dialect, False, "lo", domain)) as end:
        asked = JointTargets(*np.zeros((3, 12)), np.full(12, 1.5), np.zeros(12))
        while other.poll() is None:
            heard += end.receive(0.05) is not None
            end.send(dialect.command_message(asked))
    assert other.returncode == 0  # or minus the signal that ended it
    said = json.loads(other.communicate()[0])
    assert (said["damping"], said["heard"] > 10, heard > 10) == (1.5, True, True)


PUBLISHED = os.environ.get("SUREFOOT_UNITREE_MUJOCO", ""), os.environ.get("SUREFOOT_UNITREE_SDK2_PYTHON", "")
"""Folders of the published simulator and of the SDK that it needs."""


FIRST_RIGHT = os.environ.get("SUREFOOT_REAL_TIME", "").split()
"""What gives a process first right to a core, as `chrt -f 20` does; `nice -n 0` where nothing else runs."""
_NAMES = "SUREFOOT_UNITREE_MUJOCO", "SUREFOOT_UNITREE_SDK2_PYTHON", "SUREFOOT_OLDER_DDS"
_MISSING = [name for name in _NAMES if not os.environ.get(name)]
needs_published = pytest.mark.skipif(
    bool(_MISSING),
    reason=f"Unitree's published simulator is not here: {', '.join(_MISSING)} not set, see docs/wire.md",
)
needs_first_right = pytest.mark.skipif(
    not FIRST_RIGHT, reason="SUREFOOT_REAL_TIME: what gives a process first right to a core, as `chrt -f 20`"
)


def beside_the_published_simulator(
    robot: str, rate: int, how: list[str], drive: list[str], first: Sequence[str] = ()
) -> tuple[subprocess.CompletedProcess[str], dict[str, Any]]:
    """Return how `surefoot drive` ended beside Unitree's program, and what that said of its robot."""
    domain = free_domain(20 + 20 * (rate == 500))
    program = [OLDER, str(Path(__file__).with_name("published_simulator.py")), *PUBLISHED]
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    simulator = subprocess.Popen(
        [*first, *program, str(domain), str(rate), "60", robot, *how],
        stdout=subprocess.PIPE, text=True, env=environment,
    )  # fmt: skip
    wire = ["--simulator", "--rate", str(rate), "--domain", str(domain), "--json"]
    slow = ["--slow-motion"] if "lockstep" in how else []
    command = [sys.executable, "-m", "surefoot", "drive", robot, *drive, *wire, *slow]
    try:
        done = subprocess.run([*first, *command], capture_output=True, text=True, check=False, timeout=300)
        said = json.loads(simulator.communicate(timeout=120)[0].splitlines()[-1])
    finally:
        simulator.kill()
    assert simulator.returncode == 0
    return done, said


@pytest.mark.long
@needs_published
@pytest.mark.parametrize("rate", 5 * [200, 500])
@pytest.mark.parametrize("how", ["lockstep", pytest.param("real time", marks=needs_first_right)])
def test_the_published_simulator_walks(how: str, rate: int) -> None:
    """Backwards, since stairs are in front of it in its scene; in lockstep, since machines are busy."""
    first = FIRST_RIGHT if how == "real time" else ()
    drive = ["--velocity=-0.5,0,0", "--duration", "5"]
    done, said = beside_the_published_simulator("go2", rate, [how], drive, first)
    assert done.returncode == 0, done.stdout + done.stderr + str(said)
    assert said["place"][0] < -2.0
    assert said["highest"] > 0.3
    assert said["place"][2] < 0.25


@pytest.mark.long
@needs_published
@pytest.mark.parametrize("robot", ["go2", "g1"])
def test_a_robot_that_hangs_in_the_published_scene_says_so(robot: str) -> None:
    """In its elastic band, with straps that hold its trunk level: the first advice of the page."""
    done, said = beside_the_published_simulator(
        robot, 500, ["lockstep", "band", "straps"], ["--duration", "2"]
    )
    assert done.returncode == 1, done.stdout + done.stderr
    assert json.loads(done.stdout)["fault"].startswith("the feet carry nothing")
    assert said["lowest"] > 0.05  # it did hang


def hold_up(process: subprocess.Popen[str], seconds: float) -> None:
    """Let a process stand still for a time [s], where the system can and it has not ended."""
    if process.poll() is None and hasattr(signal, "SIGSTOP"):
        process.send_signal(signal.SIGSTOP)
        time.sleep(seconds)
        process.send_signal(signal.SIGCONT)


@pytest.mark.long
def test_two_processes_walk(tmp_path: os.PathLike[str]) -> None:
    """Up, 0.5 m/s for 4 s, stop, sit: in slow motion, since machines that run tests are busy.

    Each side is held up for longer than it takes to be missed, in the midst of it.
    """
    log = os.path.join(tmp_path, "walk.mcap")
    domain = free_domain(60)
    wire = ["--domain", str(domain), "--slow-motion"]
    start = [sys.executable, "-m", "surefoot"]
    robot = subprocess.Popen(
        [*start, "robot", "go2", "--seconds", "16.0", "--json", *wire], stdout=subprocess.PIPE, text=True
    )
    try:
        with closing(WireEnd(dialect_of(sf.load_robot("go2")), False, "lo", domain)) as end:
            assert until(lambda: end.receive(0.5) is not None, 120.0)  # machines that run tests are busy
        drive = [*start, "drive", "go2", "--duration", "4", "--out", log, "--json", *wire]
        done = subprocess.Popen(drive, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        for one in (done, robot, done):
            time.sleep(6.0)
            hold_up(one, 2.5)
        out, error = done.communicate(timeout=1800)
        said = json.loads(robot.communicate(timeout=900)[0])
    finally:
        robot.kill()
    assert done.returncode == 0, out + error
    told = json.loads(out)
    assert told["balanced"] > 4.0
    assert said["place"][0] > 1.6
    assert said["highest"] > 0.32
    assert said["torque_use"] <= 1.0 + 1e-9
    kept = sf.read_log(log)
    assert float(np.mean(kept["forces"][..., 2].sum(axis=1))) == pytest.approx(GO2_WEIGHT, rel=0.1)
