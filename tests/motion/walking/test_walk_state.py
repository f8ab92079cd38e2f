"""The state of a walk is a value: copied, compared, written down, and resumed to the last bit."""

from __future__ import annotations

import copy
import json
import subprocess
import sys
from collections import deque
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from surefoot.base.errors import ProblemError
from surefoot.base.memory import Remembering, alike, read_back, write_down
from surefoot.mechanics.robot import load_robot
from surefoot.mechanics.terrain import read_terrain
from surefoot.motion.control.controller import RobotState, Wrapper
from surefoot.motion.ground.terrain_knowledge import controller_ground
from surefoot.motion.standing.stand_state import StandState
from surefoot.motion.walking.gait_clock import GaitClock
from surefoot.motion.walking.walk_state import WalkState
from surefoot.motion.walking.walker import Walker
from surefoot.motion.walking.walkers import walking_controller
from surefoot.motion.walking.walking_body import VelocityCommand
from surefoot.worlds.mujoco.mujoco_world import MujocoWorld
from surefoot.worlds.running.height_scan import RangeSensor
from surefoot.worlds.running.run import run
from surefoot.worlds.running.scenario import Push, Scenario
from surefoot.worlds.running.walk_terrain import start_pose
from tests.robots import robot_of

pytest.importorskip("mujoco")
STEPS = 500
ALL = np.ones(4, dtype=bool)


def walker_of(name: str, knowledge: str, ground: str, watch: bool) -> Walker:
    """Return a controller, made in the same way by every process."""
    belief = controller_ground(knowledge, read_terrain(ground, "terrain"))
    command = VelocityCommand.constant(0.4)
    return walking_controller(load_robot(name), command, terrain=belief, watch_friction=watch)


class Recording(Wrapper):
    """Keeps the state at a step, and what is measured and commanded from it on."""

    def __init__(self, controller: Walker, at: int) -> None:
        super().__init__(controller)
        self.walker, self.at, self.count = controller, at, 0
        self.kept: WalkState | None = None
        self.measured: list[RobotState] = []
        self.torques: list[Any] = []

    def step(self, state: RobotState) -> Any:
        """Return the controller's command."""
        if self.count == self.at:
            self.kept = self.walker.state
        command = self.walker.step(state)
        if self.count >= self.at:
            self.measured.append(copy.deepcopy(state))
            self.torques.append(command.torques.copy())
        self.count += 1
        return command


def recorded(
    name: str, knowledge: str, ground: str, watch: bool, pushes: list[Push], at: int = 2000
) -> Recording:
    """Return a run of a walk with its state at a step, and `STEPS` steps from it on."""
    robot, terrain = load_robot(name), read_terrain(ground, "terrain")
    recording = Recording(walker_of(name, knowledge, ground, watch), at)
    scanner = RangeSensor() if knowledge == "map" else None
    scenario = Scenario(
        1e-3 * (at + STEPS), 0.6, tuple(pushes), start=start_pose(robot, terrain), scanner=scanner
    )
    run(MujocoWorld(robot, terrain, 0.6), recording, scenario)
    return recording


FRESH = """
import json, sys
from pathlib import Path
import numpy as np
from surefoot.motion.control.controller import HeightScan, RobotState
from surefoot.motion.walking.walk_state import WalkState
from surefoot.base.memory import read_back
from tests.motion.walking.test_walk_state import walker_of
folder, case = Path(sys.argv[1]), json.loads(sys.argv[2])

def read(name):
    return dict(np.load(folder / f"{name}.npz")), json.loads((folder / f"{name}.json").read_text())

state = WalkState.from_arrays(*read("state"))
seen = read_back(*read("run"), {"RobotState": RobotState, "HeightScan": HeightScan})
walker = walker_of(*case)
walker.resume(state)
for k, (measured, torques) in enumerate(seen):
    assert walker.step(measured).torques.tobytes() == torques.tobytes(), f"step {k}"
print(len(seen), "equal")
"""
TROT = [
    Push(1.0, (0.0, 80.0, 0.0), 0.1),
    Push(1.95, (0.0, 120.0, 0.0), 0.1),
    Push(2.2, (80.0, 0.0, 0.0), 0.1),
]
LONG = pytest.mark.long


@pytest.mark.parametrize(
    ("case", "pushes", "at"),
    [
        (("go2", "exact", "flat", False), TROT, 2000),
        pytest.param(("go2", "exact", "flat", False), [Push(1.0, (0.0, 260.0, 0.0), 0.1)], 1150,
                     marks=LONG, id="leap"),
        pytest.param(("go2", "exact", "flat", True), TROT, 2000, marks=LONG, id="slip"),
        pytest.param(("go2", "exact", "stairs:0.1,0.3", False), [], 2000, marks=LONG, id="stairs"),
        pytest.param(("go2", "blind", "stairs:-0.12,0.9", False), [], 2600, marks=LONG, id="drop"),
        pytest.param(("go2", "blind", "rough:3,0.08", False), [], 2000, marks=LONG, id="rough"),
        pytest.param(("go2", "map", "stairs:0.1,0.3", False), [], 2000, marks=LONG, id="map"),
        pytest.param(("g1", "exact", "flat", False), [Push(1.9, (0.0, 60.0, 0.0), 0.1)], 2000,
                     marks=LONG, id="g1"),
    ],
)  # fmt: skip
@pytest.mark.long
def test_a_walk_resumed_in_a_fresh_process_goes_on_to_the_last_bit(
    case: tuple[str, str, str, bool], pushes: list[Push], at: int, tmp_path: Path
) -> None:
    recording = recorded(*case, pushes, at)
    assert recording.kept is not None
    arrays, facts = recording.kept.to_arrays()
    np.savez(tmp_path / "state.npz", **arrays, allow_pickle=False)
    (tmp_path / "state.json").write_text(json.dumps(facts, allow_nan=False))
    kinds = {type(one).__name__: type(one) for one in (recording.measured[0], *recording.measured[0])}
    kinds = {name: kind for name, kind in kinds.items() if hasattr(kind, "_asdict")}
    scans = (one.scan for one in recording.measured if one.scan is not None)
    kinds |= {type(scan).__name__: type(scan) for scan in scans}
    seen, rest = write_down(list(zip(recording.measured, recording.torques, strict=True)), kinds)
    np.savez(tmp_path / "run.npz", **seen, allow_pickle=False)
    (tmp_path / "run.json").write_text(json.dumps(rest))
    program = [sys.executable, "-c", FRESH, str(tmp_path), json.dumps(case)]
    done = subprocess.run(program, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == [str(len(recording.torques)), "equal"]


def walked(steps: int) -> tuple[Walker, RobotState]:
    """Return a controller after some steps of a robot that stands, and the next state."""
    robot = robot_of("go2")
    walker = walking_controller(robot, VelocityCommand.constant(0.4))
    still = np.zeros(robot.model.nv)
    for k in range(steps):
        walker.step(RobotState(robot.nominal, still, 0.004 * k, ALL))
    return walker, RobotState(robot.nominal, still, 0.004 * steps, ALL)


def test_a_state_is_a_copy_that_can_be_compared_and_written_down() -> None:
    walker, measured = walked(100)
    state = walker.state
    assert state is not None
    again = copy.deepcopy(state)
    assert again == state == walker.state
    arrays, facts = state.to_arrays()
    assert WalkState.from_arrays(arrays, json.loads(json.dumps(facts, allow_nan=False))) == state
    walker.step(measured)
    assert again == state != walker.state
    again.feet.foot["share"][0] += 1e-16 + 0.1
    assert again != state
    walker.resume(state)
    assert walker.state == state


@pytest.mark.parametrize("other", ["hyq", "g1"])
def test_a_state_of_another_walk_is_refused_and_the_walk_goes_on(other: str) -> None:
    """Sizes that fit nothing here would make compiled code reach beyond its arrays."""
    walker, measured = walked(20)
    before = walker.state
    robot = robot_of(other)
    stranger = walking_controller(robot, VelocityCommand.constant(0.3))
    still, contact = np.zeros(robot.model.nv), np.ones(len(robot.feet), dtype=bool)
    stranger.step(RobotState(robot.nominal, still, 0.0, contact))
    given = stranger.state
    assert given is not None
    if other == "hyq":  # as many feet and joints: only sizes of parts can tell
        parts = dict(given.parts or {})
        parts["whole_body"] = {**parts["whole_body"], "_v": np.zeros(30)}
        given = given._replace(parts=parts)
    with pytest.raises(ProblemError, match="another"):
        walker.resume(given)
    assert walker.state == before
    same, _ = walked(20)
    assert walker.step(measured).torques.tolist() == same.step(measured).torques.tolist()


def test_the_beginning_is_no_state_and_can_be_resumed() -> None:
    walker, measured = walked(0)
    assert walker.state is None
    first = walker.step(measured).torques
    walker.step(measured._replace(time=0.02))
    walker.resume(None)
    assert walker.state is None
    assert walker.step(measured).torques.tolist() == first.tolist()


@pytest.mark.parametrize("kind", [WalkState, StandState])
@pytest.mark.parametrize("facts", [None, {"tuple": [1]}, {"kind": "None", "fields": {}}, {"array": "gone"}])
def test_what_is_no_state_is_refused(kind: Any, facts: Any) -> None:
    with pytest.raises(ProblemError, match="this is no state of a "):
        kind.from_arrays({}, facts)


def test_a_steered_walk_goes_on_at_the_pace_of_its_new_speed() -> None:
    """Beside the command, the hurry that its speed needs is kept: the cycles to come depend on it."""
    robot, still = robot_of("go2"), np.zeros(18)
    walker, fresh = (walking_controller(robot, VelocityCommand.constant(0.0)) for _ in range(2))

    def go_on(one: Walker, begin: int, end: int) -> list[list[float]]:
        states = (RobotState(robot.nominal, still, 0.004 * k, ALL) for k in range(begin, end))
        return [one.step(state).torques.tolist() for state in states]

    go_on(walker, 0, 60)
    walker.steer([1.6, 0.0, 0.0])
    go_on(walker, 60, 200)
    state = walker.state
    assert state is not None
    arrays, facts = state.to_arrays()
    fresh.resume(WalkState.from_arrays(arrays, json.loads(json.dumps(facts))))
    assert fresh.state == state
    assert go_on(fresh, 200, 500) == go_on(walker, 200, 500)


def test_a_walk_that_begins_again_plans_in_its_own_steps() -> None:
    """Whatever the steps of the MPC were, as they are longer in step with stairs."""
    walker, measured = walked(0)
    first = walker.step(measured).torques
    walker.mpc.pace(1.7 * walker.mpc.dt)
    walker.reset()
    assert walker.step(measured).torques.tolist() == first.tolist()


def parts_of(one: Any, path: str = "", seen: set[int] | None = None) -> list[tuple[str, Any]]:
    """Return the parts of a controller that remember something, by path."""
    out = [(path, one)] if isinstance(one, Remembering) else []
    for name in one.lasting_names() if isinstance(one, Remembering) else ():
        inner = getattr(one, name, None)
        if isinstance(inner, Remembering):
            out += parts_of(inner, f"{path}.{name}")
    for inner in getattr(one, "behaviours", ()):
        out += parts_of(inner, f"{path}.{inner.name}")
    return out


@pytest.mark.parametrize("knowledge", ["exact", "map", "blind"])
def test_what_changes_in_a_part_is_named_in_its_memory(knowledge: str) -> None:
    """No part keeps anything that a resumed walk would not know of."""
    robot = robot_of("go2")
    belief = controller_ground(knowledge, read_terrain("flat", "terrain"))
    walker = walking_controller(robot, VelocityCommand.constant(0.4), terrain=belief, watch_friction=True)
    weight = np.tile([0.0, 0.0, 40.0], (4, 1))
    still, q = np.zeros(robot.model.nv), robot.nominal

    def go_on(start: int, steps: int) -> None:
        for k in range(start, start + steps):
            pushed = still.copy()
            pushed[1] = 0.9 if k % 150 > 120 else 0.0
            walker.step(RobotState(q, pushed, 0.004 * k, ALL if k % 7 else ~ALL, forces=weight))

    go_on(0, 100)
    parts = [
        pair for name, part in walker._parts().items() if part is not None for pair in parts_of(part, name)
    ]
    before = {path: copy.deepcopy(plain(part)) for path, part in parts}
    go_on(100, 200)
    for path, part in parts:
        moved = {name for name, value in plain(part).items() if not alike(value, before[path].get(name))}
        unknown = moved - set(part.lasting_names()) - DERIVED
        assert not unknown, f"{path}: {unknown}"


DERIVED = {"notes", "behaviours", "_problem", "_seen", "_moved", "_noted"}
"""Notes and behaviours, which the arbiter looks after itself, and views of `WholeBodyController._memory`."""
PLAIN = (int, float, str, bytes, tuple, list, dict, set, deque, np.ndarray, type(None))


def plain(part: Remembering) -> dict[str, Any]:
    """Return the attributes that may change without being parts."""
    return {name: value for name, value in vars(part).items() if isinstance(value, PLAIN)}


def test_values_are_alike_to_the_last_bit() -> None:
    value = {
        "a": (1, 2.5, None, True),
        "b": [np.arange(3.0), {4, 5}],
        "c": deque([1.0], maxlen=3),
        "d": b"\x01",
    }
    other = copy.deepcopy(value)
    assert alike(value, other)
    arrays, facts = write_down(value, {})
    assert alike(read_back(arrays, json.loads(json.dumps(facts)), {}), value)
    other["b"][0][1] = np.nextafter(1.0, 2.0)  # type: ignore[index]
    assert not alike(value, other)
    with pytest.raises(TypeError, match="GaitClock"):
        write_down([GaitClock(0.0)], {})
