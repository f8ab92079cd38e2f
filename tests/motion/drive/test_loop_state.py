"""The state of a robot's loop is a value, and a loop goes on from it to the last bit."""

from __future__ import annotations

import copy
import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from surefoot.base.errors import ProblemError
from surefoot.base.memory import alike, read_back, write_down
from surefoot.mechanics.robot import load_robot
from surefoot.motion.control.controller import JointTargets
from surefoot.motion.drive.loop_state import KINDS, LoopState
from surefoot.motion.drive.modes import LoopMode
from surefoot.motion.drive.readings import RobotReadings
from surefoot.motion.drive.robot_loop import RobotLoop
from surefoot.worlds.running.motor_robot import MotorRobot
from tests.motion.drive.loop_faults import DT, GO2

pytest.importorskip("mujoco")
Heard = list[tuple[RobotReadings | None, JointTargets]]


def go_on(loop: RobotLoop, robot: MotorRobot, steps: int, seed: int, ahead: bool) -> Heard:
    """Let the loop drive the robot, one in ten readings lost; return what it heard and said."""
    random, out = np.random.default_rng(seed), Heard()
    for _ in range(steps):
        readings = robot.read()
        came = None if random.random() < 0.1 else readings
        targets = loop.step(came)
        if ahead:
            loop.plan_ahead()
        robot.take(targets)
        robot.step()
        out.append((came, targets))
    return out


FRESH = """
import json, sys
from pathlib import Path
import numpy as np
from surefoot.base.memory import alike, read_back
from surefoot.motion.drive.loop_state import KINDS, LoopState
from surefoot.motion.drive.robot_loop import RobotLoop
from tests.motion.drive.loop_faults import DT, GO2
folder, ahead = Path(sys.argv[1]), sys.argv[2] == "True"

def read(name):
    return dict(np.load(folder / f"{name}.npz")), json.loads((folder / f"{name}.json").read_text())

loop = RobotLoop(GO2, DT)
loop.resume(LoopState.from_arrays(*read("state")))
heard = read_back(*read("heard"), KINDS)
for k, (came, targets) in enumerate(heard):
    given = loop.step(came)
    if ahead:
        loop.plan_ahead()
    assert all(a.tobytes() == b.tobytes() for a, b in zip(given, targets)), f"step {k}"
print(len(heard), loop.mode.name)
"""


def walking(ahead: bool) -> tuple[RobotLoop, MotorRobot]:
    """Return a loop that walks, and its robot."""
    loop, robot = RobotLoop(GO2, DT), MotorRobot(GO2, DT)
    go_on(loop, robot, 50, 0, ahead)
    loop.go("stand")
    while loop.mode is not LoopMode.STAND:
        assert loop.time < 4.0
        go_on(loop, robot, 50, 1, ahead)
    loop.steer([0.4, 0.0, 0.1], [0.01, 0.05, 0.0])
    loop.go("walk")
    go_on(loop, robot, 350, 2, ahead)
    assert loop.mode is LoopMode.WALK
    return loop, robot


def rising(ahead: bool) -> tuple[RobotLoop, MotorRobot]:
    """Return a loop on its way to standing, and its robot."""
    loop, robot = RobotLoop(GO2, DT), MotorRobot(GO2, DT)
    robot.lie_down()
    go_on(loop, robot, 50, 0, ahead)
    loop.go("stand")
    go_on(loop, robot, 300, 1, ahead)
    assert loop.mode is LoopMode.STAND_UP
    return loop, robot


@pytest.mark.parametrize(
    ("begin", "ahead", "steps"),
    [(walking, False, 500), (walking, True, 500), (rising, False, 1800)],
)
@pytest.mark.long
def test_a_loop_resumed_in_a_fresh_process_goes_on_to_the_last_bit(
    begin: Callable[[bool], tuple[RobotLoop, MotorRobot]], ahead: bool, steps: int, tmp_path: Path
) -> None:
    loop, robot = begin(ahead)
    state = loop.state
    assert state == loop.state == copy.deepcopy(state)
    heard = go_on(loop, robot, steps, 3, ahead)
    assert state != loop.state
    for name, (arrays, facts) in (("state", state.to_arrays()), ("heard", write_down(heard, KINDS))):
        np.savez(tmp_path / f"{name}.npz", **arrays, allow_pickle=False)
        (tmp_path / f"{name}.json").write_text(json.dumps(facts, allow_nan=False))
    program = [sys.executable, "-c", FRESH, str(tmp_path), str(ahead)]
    done = subprocess.run(program, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == [str(steps), loop.mode.name]


@pytest.mark.long
def test_loop_and_simulated_robot_go_on_together() -> None:
    pair = walking(False)
    states = pair[0].state, pair[1].state
    told = go_on(*pair, 150, 3, False)
    loop, robot = RobotLoop(GO2, DT), MotorRobot(GO2, DT, seed=9)
    loop.resume(states[0])
    robot.go_on(states[1])
    again = go_on(loop, robot, 150, 3, False)
    for (_, one), (_, other) in zip(told, again, strict=True):
        assert np.array(one).tobytes() == np.array(other).tobytes()
    assert alike(robot.state, pair[1].state)
    assert loop.state == pair[0].state


def test_a_loop_goes_on_from_a_state_of_its_own_make_alone() -> None:
    loop = RobotLoop(GO2, DT)
    state = loop.state
    arrays, facts = state.to_arrays()
    assert LoopState.from_arrays(arrays, json.loads(json.dumps(facts, allow_nan=False))) == state
    assert read_back(arrays, facts, KINDS) == state
    for other in (RobotLoop(GO2, 0.004), RobotLoop(GO2, DT, gait="trot"), RobotLoop(load_robot("a1"), DT)):
        with pytest.raises(ProblemError, match="the state is of another loop"):
            other.resume(state)
    wrong = copy.deepcopy(state)
    wrong.parts["watch"]["_kept"] = wrong.parts["watch"]["_kept"].astype(np.float32)
    with pytest.raises(ProblemError, match="_kept of a ReadingWatch"):
        loop.resume(wrong)
    wrong = copy.deepcopy(state)
    wrong.parts.pop("tracker")
    with pytest.raises(ProblemError, match="does not fit: KeyError 'tracker'"):
        loop.resume(wrong)
    for broken in ({"list": []}, {"kind": "LoopState", "fields": {}}, {"kind": "Other", "fields": {}}, 3):
        with pytest.raises(ProblemError, match="this is no state of a loop"):
            loop.resume(LoopState.from_arrays(arrays, broken))
