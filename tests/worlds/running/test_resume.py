"""A run goes on from a kept state to the last bit, in a fresh process and in closed loop."""

from __future__ import annotations

import copy
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.errors import ProblemError
from surefoot.base.memory import alike
from surefoot.mechanics.terrain import read_terrain
from surefoot.motion.control.controller import Command, Controller, RobotState, Wrapper
from surefoot.motion.drive.joint_targets import JointTargetController
from surefoot.motion.drive.latency_compensation import LatencyCompensation
from surefoot.motion.drive.watchdog import Watchdog
from surefoot.motion.ground.terrain_knowledge import controller_ground
from surefoot.motion.walking.walkers import walking_controller
from surefoot.records.log.kept_states import KeptState, keep_state, read_kept_state
from surefoot.worlds.running.faults import Faults
from surefoot.worlds.running.height_scan import RangeSensor
from surefoot.worlds.running.run_state import RunState, StateKeeper
from surefoot.worlds.running.scenario import Ice, IcePatch
from surefoot.worlds.running.sensors import ImuModel, SensorModel, TouchModel

pytest.importorskip("mujoco")
CLOCKS = {"controller_time", "estimator_time"}
"""Channels of wall time, which no state keeps."""
PUSHES = ((1.0, (0.0, 80.0, 0.0), 0.1), (1.95, (0.0, 120.0, 0.0), 0.1), (2.2, (80.0, 0.0, 0.0), 0.1))

CASES: dict[str, dict[str, Any]] = {
    "trot": {},
    "sensors": {"sensors": SensorModel(touch=TouchModel(missed=0.1, false=2.0)), "seed": 3},
    "g1": {"robot": "g1", "sensors": SensorModel(), "seed": 1, "pushes": ((1.9, (0.0, 60.0, 0.0), 0.2),)},
    "rigid-full-real": {"world": "rigid", "pushes": PUSHES[1:], "collision": "full", "actuators": "real"},
    "soft-full-real": {"solref": (0.03, 0.9), "actuators": "real", "collision": "full"},
    "dropouts": {
        "sensors": SensorModel(), "seed": 2, "wired": True, "actuators": "real",
        "faults": Faults(delay=0.004, strength=0.97, dropouts=((1.97, 0.06), (2.2, 0.015))),
    },
    "noise": {"faults": Faults(noise=0.3, delay=0.003), "seed": 5, "watch": True, "ice": (Ice(1.5, 0.5),)},
    "patches": {"patches": (IcePatch((0.2, -1.0), (0.6, 1.0), 0.3),), "watch": True},
    "stairs": {"terrain": "stairs:0.1,0.3"},
    "map": {"terrain": "stairs:0.1,0.3", "knowledge": "map", "scanner": RangeSensor(), "seed": 7},
    "blind": {"terrain": "rough:3,0.06", "knowledge": "blind", "substeps": 8},
    "exact-full": {"world": "exact", "collision": "full", "actuators": "real", "substeps": 2},
    "exact-g1": {"world": "exact", "robot": "g1"},
}  # fmt: skip


def made(name: str) -> tuple[Any, Any, sf.Scenario]:
    """Return world, controller and scenario of a case, made in the same way by every process."""
    case = dict(CASES[name])
    robot = sf.load_robot(case.pop("robot", "go2"))
    terrain, knowledge = case.pop("terrain", "flat"), case.pop("knowledge", "exact")
    wired, watch, substeps = case.pop("wired", False), case.pop("watch", False), case.pop("substeps", 1)
    pushes = tuple(sf.Push(*push) for push in case.pop("pushes", PUSHES))
    kind = {"mujoco": sf.MujocoWorld, "rigid": sf.RigidWorld, "exact": partial(sf.MujocoWorld, exact=True)}[
        case.pop("world", "mujoco")
    ]
    given = {key: case.pop(key) for key in ("collision", "actuators", "solref") if key in case}
    world = kind(robot, read_terrain(terrain, "terrain"), 0.6, **given)
    if substeps > 1:
        world.divide(substeps)
    ground = controller_ground(knowledge, read_terrain(terrain, "terrain"))
    motors, dt = getattr(world, "actuators", None), 0.002 if wired else 1e-3
    controller: Controller = walking_controller(
        robot, sf.VelocityCommand.constant(0.4), terrain=ground, actuators=motors, dt=dt, watch_friction=watch
    )
    if wired:
        controller = LatencyCompensation(JointTargetController(controller, robot, 1e-3, 2), robot, 1e-3)
        controller = Watchdog(controller, robot, 1e-3)
    return world, controller, sf.Scenario(2.5, 0.6, pushes, **case)


def differing(whole: Any, part: Any, first: int) -> list[str]:
    """Return the channels of a log that are not, bit by bit, the last rows of the whole one."""
    return [
        name
        for name in whole
        if name not in CLOCKS
        and np.asarray(whole[name][first:]).tobytes() != np.asarray(part[name]).tobytes()
    ]


FRESH = """
import sys
from pathlib import Path
import numpy as np
import surefoot as sf
from surefoot.records.log.kept_states import read_kept_state
from surefoot.worlds.running.run_state import RunState
from tests.worlds.running.test_resume import made
kept = read_kept_state(Path(sys.argv[1]), 2.0, 1e-3)
world, controller, scenario = made(sys.argv[2])
log = sf.run(world, controller, scenario, resume=RunState.from_arrays(kept.arrays, kept.facts))
np.savez(sys.argv[3], **{name: log[name] for name in log})
print(kept.time, len(log))
"""


@pytest.mark.parametrize("name", CASES)
@pytest.mark.long
def test_a_run_resumed_in_a_fresh_process_goes_on_to_the_last_bit(name: str, tmp_path: Path) -> None:
    kept: list[RunState] = []
    world, controller, scenario = made(name)
    whole = sf.run(world, controller, scenario, keep=StateKeeper(1.0, kept.append))
    assert [state.step for state in kept] == [0, 1000, 2000]
    for state in kept:
        keep_state(tmp_path, KeptState(state.step, state.time, *state.to_arrays(), None))
    program = [sys.executable, "-c", FRESH, str(tmp_path), name, str(tmp_path / "log.npz")]
    done = subprocess.run(program, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == ["2.0", str(len(whole) - 2000)]
    assert len(whole) == 2500
    with np.load(tmp_path / "log.npz") as log:
        assert differing(whole, {name: log[name] for name in log.files}, 2000) == []


Make = Callable[..., Any]


def short(walker: Make | None = None, world: Make = sf.MujocoWorld, **happens: Any) -> Make:
    """Return what runs 0.25 s of a walk of the Go2, always made in the same way but for what it is given."""
    robot = sf.load_robot("go2")

    def again(duration: float = 0.25, speed: float = 0.4, **given: Any) -> Any:
        controller: Any = walking_controller(robot, sf.VelocityCommand.constant(speed))
        controller = controller if walker is None else walker(controller)
        other = {**happens, **given.pop("happens", {})}
        return sf.run(world(robot), controller, sf.Scenario(duration, 0.6, **other), **given)

    return again


@pytest.fixture(scope="module")
def walk() -> tuple[Any, list[RunState], Make]:
    """Return a log, the states kept in it each 0.1 s, and what makes such runs."""
    kept, again = list[RunState](), short(sensors=SensorModel(), seed=4)
    return again(keep=StateKeeper(0.1, kept.append)), kept, again


def test_keeping_states_changes_nothing_and_a_run_that_went_on_keeps_the_same(
    walk: tuple[Any, list[RunState], Make],
) -> None:
    whole, kept, again = walk
    assert differing(whole, again(), 0) == []
    more: list[RunState] = []
    log = again(resume=kept[1], keep=StateKeeper(0.1, more.append))
    assert differing(whole, log, 100) == []
    assert log["time"][0] == 0.1
    assert more == kept[1:]
    assert kept[1] != kept[2]
    assert differing(whole, again(resume=kept[0]), 0) == []  # the start is a state, too


def test_a_state_survives_writing_and_reading(walk: tuple[Any, list[RunState], Make], tmp_path: Path) -> None:
    state = walk[1][1]
    again = copy.deepcopy(state)
    assert again == state
    again.parts["sensing"]["sensors"]["_memory"][0] += 1e-12
    assert again != state
    file = keep_state(tmp_path, KeptState(state.step, state.time, *state.to_arrays(), {"a": 1}))
    kept = read_kept_state(tmp_path, 0.19, 1e-3)
    assert (kept.step, kept.about, file.stem) == (100, {"a": 1}, "000000100")
    assert RunState.from_arrays(kept.arrays, kept.facts) == state
    with np.load(file, allow_pickle=False) as plain:  # arrays of numbers, and text
        assert not any(plain[name].dtype.hasobject for name in plain.files)


def test_a_state_that_was_changed_or_cut_is_refused(
    walk: tuple[Any, list[RunState], Make], tmp_path: Path
) -> None:
    state = walk[1][1]
    file = keep_state(tmp_path, KeptState(state.step, state.time, *state.to_arrays(), None))
    whole = file.read_bytes()
    with np.load(file) as opened:
        held = {name: opened[name] for name in opened.files}
    array = next(name for name in held if held[name].dtype == float and held[name].size)

    def written(**changes: Any) -> bytes:
        np.savez_compressed(tmp_path / "other.npz", **{**held, **changes})
        return (tmp_path / "other.npz").read_bytes()

    text = str(held["text"])
    for contents, told in (
        (written(**{array: np.nextafter(held[array], 9.0)}), "was changed"),
        (written(**{array: held[array].astype(np.float32)}), "was changed"),
        (written(text=np.array(text.replace('"step": 100', '"step": 101'))), "was changed"),
        (written(text=np.array(text.replace('"form": 1', '"form": 2'))), "has form 2, this version reads 1"),
        (whole[:-400], "is no state that a run has kept"),
        (b"", "is no state that a run has kept"),
        (np.random.default_rng(0).bytes(3000), "is no state that a run has kept"),
    ):
        file.write_bytes(contents)
        with pytest.raises(ProblemError, match=told):
            read_kept_state(tmp_path, 0.1, 1e-3)


def changed(state: RunState, change: Callable[[RunState], None]) -> RunState:
    """Return a copy of a state with something wrong in it."""
    out = copy.deepcopy(state)
    change(out)
    return out


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda s: s.world.own.update(physics=np.zeros(3)), r"physics of the world's state must be \(\d+,\)"),
        (lambda s: s.world.own.update(geom_friction=s.world.own["geom_friction"].astype("f4")), "float64"),
        (lambda s: s.world.own.pop("physics"), "physics of the world's state"),
        (lambda s: s.parts["sensing"].update(heard=0, more=1), "does not remember 'more'"),
        (lambda s: s.parts["sensing"]["sensors"].update(_memory=np.zeros((2, 2))), "1 axes of float64"),
        (lambda s: s.parts.pop("faults"), "does not fit this run: KeyError 'faults'"),
        (lambda s: s.parts.update(exteroception=None), "memory of a ExteroceptiveSensing must name"),
        (lambda s: s.parts["faults"].update(generator={"bit_generator": "MT19937"}), "does not fit this run"),
        (
            lambda s: s.controller.parts.pop("mpc"),
            "the state is of another walk: .* not 4 and .*schedule, mpc,",
        ),
    ],
)
def test_a_state_that_does_not_fit_is_refused(
    walk: tuple[Any, list[RunState], Make], change: Callable[[RunState], None], told: str, tmp_path: Path
) -> None:
    with pytest.raises(ProblemError, match=told):
        walk[2](resume=changed(walk[1][1], change), folder=tmp_path / "parts")
    assert not (tmp_path / "parts").exists()


@pytest.mark.long
def test_a_run_goes_on_in_its_own_setting_alone(walk: tuple[Any, list[RunState], Make]) -> None:
    whole, kept, again = walk
    for given, told in (
        ({"duration": 0.1}, "the state is of 0.100 s, the run ends before that"),
        ({"happens": {"sensors": None}}, "another sensors"),
        ({"happens": {"scanner": RangeSensor()}}, "another range sensor"),
        ({"happens": {"faults": Faults(delay=0.01)}}, "another faults"),
        ({"happens": {"ice": (Ice(0.2, 0.1),)}}, "another ice"),
    ):
        with pytest.raises(ProblemError, match=told):
            again(**given, resume=kept[1])
    for changes in ({"payload": 1.0}, {"collision": "full"}, {"terrain": sf.SlopeTerrain(1.0)}):
        world = partial(sf.MujocoWorld, **changes)
        with pytest.raises(ProblemError, match="the state is one of another MujocoWorld: robot, load"):
            short(world=world, sensors=SensorModel(), seed=4)(resume=kept[1])
    with pytest.raises(ProblemError, match="another world: MujocoWorld, now it is RigidWorld"):
        short(world=sf.RigidWorld, sensors=SensorModel(), seed=4)(resume=kept[1])
    pushed = again(resume=kept[1], happens={"pushes": (sf.Push(0.15, (0.0, 90.0, 0.0), 0.05),)})
    assert differing(whole.rows(slice(100, 150)), pushed.rows(slice(0, 50)), 0) == []
    assert pushed["v"][:, 1].max() > whole["v"][:, 1].max() + 0.1


@pytest.mark.long
def test_a_robot_that_has_lost_its_estimate_goes_on_standing_to_the_same_end() -> None:
    broken = replace(SensorModel(), imu=ImuModel(accelerometer_range=6.0))
    kept, again = list[RunState](), short(sensors=broken, seed=4)
    whole = again(2.5, keep=StateKeeper(0.1, kept.append))
    lost = next(state for state in kept if np.isfinite(state.stopped))
    assert (whole.facts["outcome"], lost.time < 1.5) == ("lost", True)
    log = again(2.5, resume=RunState.from_arrays(*lost.to_arrays()))
    assert differing(whole, log, lost.step) == []
    assert (log.facts["outcome"], log.facts["error"]) == ("lost", whole.facts["error"])


class Counting(Wrapper):
    """Keeps something that it does not name."""

    count = 0

    def step(self, state: RobotState) -> Command:
        """Return the controller's command."""
        self.count += 1
        return self.controller.step(state)


class Naming(Counting):
    """Names what it keeps."""

    MEMORY = ("count",)


@pytest.mark.long
def test_what_cannot_tell_its_state_is_refused_before_anything_moves(tmp_path: Path) -> None:
    keep = StateKeeper(0.1, print)
    robot = sf.load_robot("go2")

    class Plain:
        """A world without a state."""

        def __init__(self) -> None:
            self._world = sf.RigidWorld(robot)
            self.robot, self.terrain, self.dt = robot, self._world.terrain, self._world.dt
            self.contact_foot, self.reset, self.q_v = (
                self._world.contact_foot,
                self._world.reset,
                self._world.q_v,
            )
            self.step, self.contacts = self._world.step, self._world.contacts
            self.set_friction, self.mu = self._world.set_friction, 0.6

    for run, told in (
        (short(lambda _: lambda state: np.zeros(12)), "a FunctionController does not tell its state"),
        (short(Counting), "a Counting does not name what lasts in it"),
        (short(world=lambda _: Plain()), "a Plain does not tell its whole state"),
    ):
        with pytest.raises(ProblemError, match=told):
            run(keep=keep, folder=tmp_path / "parts")
        assert not (tmp_path / "parts").exists()
    for every in (0.0, -1.0, np.nan, 1e-4):
        with pytest.raises(ProblemError, match="time between kept states"):
            short()(keep=StateKeeper(every, print), folder=tmp_path / "parts")
        assert not (tmp_path / "parts").exists()
    kept: list[RunState] = []
    short(Naming)(keep=StateKeeper(0.1, kept.append))
    assert kept[2].controller["own"] == {"count": 200}


@pytest.mark.long
def test_a_rigid_world_that_went_on_says_of_its_last_step_what_the_first_one_does() -> None:
    robot = sf.load_robot("go2")
    worlds = [sf.RigidWorld(robot, collision="full", tol=1e-4) for _ in range(2)]
    q = robot.nominal.copy()
    q[2] += 0.02
    worlds[0].reset(q)
    for _ in range(90):
        worlds[0].step(np.zeros(12))
    state = worlds[0].state
    worlds[1].resume(state)
    assert alike(worlds[1].state, state)
    assert worlds[0].touching() == worlds[1].touching()
    assert worlds[0].energy() == worlds[1].energy()
    assert worlds[0].time == worlds[1].time
    for _ in range(40):
        for world in worlds:
            world.step(np.zeros(12))
        assert alike(worlds[0].state, worlds[1].state)
    with pytest.raises(ProblemError, match="another RigidWorld"):
        sf.RigidWorld(robot, collision="full", tol=1e-5).resume(state)
