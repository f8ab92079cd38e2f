"""Stacks in a process of their own: what goes to and fro, and what happens when one ends."""

from __future__ import annotations

import textwrap
from pathlib import Path

import numpy as np
import pytest

from benchmarks.stacks.peer import Peer, PeerController
from benchmarks.stacks.pins import PINS, Pin
from benchmarks.stacks.setting import IDEAL
from benchmarks.stacks.stack import Job
from benchmarks.stacks.tasks import TASKS
from benchmarks.stacks.trial import carry_out
from surefoot.base.errors import SurefootError
from surefoot.mechanics.robot import load_robot
from surefoot.mechanics.terrain import FlatTerrain, SlopeTerrain
from surefoot.motion.control.controller import RobotState

STANDS = """
    import json, os, sys, time
    channel = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    print("a peer may print")
    import numpy as np
    told = json.loads(sys.stdin.buffer.readline())
    assert os.path.isdir(sys.argv[1]) and os.path.isfile(told["urdf"]["file"])
    goal = np.array(told["q"][7:])
    channel.write((json.dumps({"dt": 0.002, "period": 0.5, "joints": goal.tolist()}) + "\\n").encode())
    channel.flush()
    while len(raw := sys.stdin.buffer.read(8 * 45)) == 8 * 45:
        request = np.frombuffer(raw)
        q, v = request[4:23], request[23:41]
        torques = 60.0 * (goal - q[7:]) - 2.0 * v[6:] + 0.0 * request[0]
        forces = np.tile([1.0, 2.0, 10.0], 4)
        EXTRA
        stance = [1.0, 1.0, 1.0, 0.0]
        answer = np.concatenate([torques, forces, stance, [1e-3]])
        channel.write(answer.tobytes())
        channel.flush()
"""


@pytest.fixture
def peer(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Peer:
    """A peer that stands."""
    monkeypatch.setitem(PINS, "stander", Pin("https://example.org/stander", "0" * 40, "STANDER", "numpy"))
    return make(tmp_path, "")


def make(folder: Path, extra: str) -> Peer:
    program = folder / "stander.py"
    program.write_text(textwrap.dedent(STANDS.replace("EXTRA", extra)))
    return Peer("stander", str(program), ("go2",)).at(folder)


def job(slope: float = 0.0) -> Job:
    ground = SlopeTerrain(slope) if slope else FlatTerrain()
    return Job(load_robot("go2"), (0.4, 0.0, 0.0), ground, 0.6)


def test_torques_are_held_between_the_times_when_the_peer_is_due(peer: Peer) -> None:
    task = job()
    robot = task.robot
    controller = peer.controller(task)
    try:
        v = np.zeros(18)
        v[6:] = 0.1
        first = controller.step(RobotState(robot.nominal, v, 0.0))
        held = controller.step(RobotState(robot.nominal, 0.0 * v, 0.001))
        after = controller.step(RobotState(robot.nominal, 0.0 * v, 0.002))
        assert first.torques == pytest.approx(-0.2 * np.ones(12))
        assert held.torques == pytest.approx(first.torques)
        assert after.torques == pytest.approx(np.zeros(12))
        assert controller.cpu == [1e-3, 0.0, 1e-3]
        assert first.active.tolist() == [True, True, True, False]
        assert first.forces[0] == pytest.approx([1.0, 2.0, 10.0])
        assert first.forces[3] == pytest.approx([0.0, 0.0, 0.0]), "a foot in the air pushes nothing"
        assert controller.step(RobotState(robot.nominal, v, 5.0)).rows()["command"] == pytest.approx(
            [0.4, 0, 0]
        )
    finally:
        controller.close()


@pytest.mark.long
def test_a_trial_with_a_peer(peer: Peer) -> None:
    found = carry_out(peer, TASKS["speed-0.2"], 0, IDEAL)
    assert found.outcome == "done"
    assert found.faults(TASKS["speed-0.2"], (0.2, 0.0, 0.0))[0] == "off course", "it only stands"
    assert found.measures.slip < 0.01
    assert found.step_us == pytest.approx(500.0)
    assert found.real_time < 2.0, "the peer's own CPU time counts"


@pytest.mark.parametrize(
    ("extra", "said"),
    [
        ("if request[0] > 0.01: raise ValueError('no such foot')", "ended: ValueError: no such foot"),
        ("torques = torques * (np.nan if request[0] > 0.01 else 1.0)", "that are not finite"),
    ],
)
def test_a_peer_that_fails_ends_its_trial(peer: Peer, tmp_path: Path, extra: str, said: str) -> None:
    found = carry_out(make(tmp_path, extra), TASKS["speed-0.2"], 0, IDEAL)
    assert found.outcome == "invalid"
    assert said in found.why


def test_a_peer_that_does_not_start(peer: Peer, tmp_path: Path) -> None:
    Path(peer.program).write_text("import nothing_like_it\n")
    with pytest.raises(SurefootError, match="did not start: ModuleNotFoundError"):
        PeerController(peer, job())
    refused = carry_out(peer, TASKS["speed-0.2"], 0, IDEAL)
    assert (refused.outcome, refused.duration) == ("refused", 0.0)
