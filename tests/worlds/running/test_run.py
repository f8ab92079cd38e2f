"""One loop for every controller: what it hands over, who watches, how it ends, and that it repeats."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import surefoot as sf
from surefoot.mechanics.terrain.terrain import Terrain
from surefoot.motion.control.controller import Command, JointTargets, RobotState
from surefoot.motion.standing.standing_plan import Lift
from surefoot.records.log import Ending
from surefoot.records.log.reading import read_log
from surefoot.worlds.running.faults import Faults
from surefoot.worlds.running.observers import Moment, Observer, RunProgress
from surefoot.worlds.running.run import run
from surefoot.worlds.running.scenario import Fall


class Watcher(Observer):
    """Keeps every moment, and the log."""

    def __init__(self) -> None:
        self.moments: list[Moment] = []
        self.log: sf.Log | None = None

    def step(self, moment: Moment) -> None:
        self.moments.append(moment)

    def end(self, log: sf.Log) -> None:
        self.log = log


class Told(sf.StandingController):
    """A standing controller that keeps what it is told, and can be made to fail."""

    states: list[RobotState]
    fails: Any = None

    def step(self, state: RobotState) -> Any:
        if not hasattr(self, "states"):
            self.states = []
        self.states.append(state)
        if self.fails is not None and state.time > 0.05:
            return self.fails(super().step(state))
        return super().step(state)


def standing(robot: sf.Robot, terrain: Terrain | None = None, **more: Any) -> Told:
    ground = terrain or sf.FlatTerrain()
    q = sf.place(robot, ground)
    plan = sf.StandingPlan(robot, ground, q, more.pop("lifts", ()))
    return Told(robot, plan, ground, q, **more)


def same(one: sf.Log, two: sf.Log) -> None:
    assert one.facts["outcome"] == two.facts["outcome"]
    for name in one.arrays:
        if name != "controller_time":
            np.testing.assert_array_equal(one[name], two[name], err_msg=name)


@pytest.mark.parametrize("kind", ["stand", "walk"])
@pytest.mark.long
def test_a_second_run_of_the_same_controller_is_the_first_again(kind: str, robot: sf.Robot) -> None:
    scenario = sf.Scenario(
        0.9, 0.6, [sf.Push(0.5, (0.0, 80.0, 0.0), 0.1)], [sf.Ice(0.6, 0.3)], 5, Faults(noise=0.3, delay=0.002)
    )
    controller: Any = sf.WalkingController(robot, sf.VelocityCommand.constant(0.5, 0.0, 0.3))
    if kind == "stand":
        controller = standing(robot, lifts=[Lift("FL", 0.4, 0.7)])
    logs = [sf.run(sf.MujocoWorld(robot, mu=0.6), controller, scenario) for _ in range(2)]
    same(*logs)
    assert logs[0].facts["kind"] == kind
    assert len(logs[0]) == 900


def test_the_controller_is_told_the_state_the_time_and_the_feet(robot: sf.Robot) -> None:
    controller, watcher, ticks = standing(robot), Watcher(), []
    lifted = np.array([0.0, 0.0, 0.01] + [0.0] * (robot.model.nq - 3))
    scenario = sf.Scenario(0.2, 0.6, start=sf.place(robot) + lifted)
    log = run(sf.MujocoWorld(robot, mu=0.6), controller, scenario, [watcher, RunProgress(ticks.append)])
    told = controller.states[-200:]
    assert [state.time for state in told] == pytest.approx(log["time"])
    np.testing.assert_array_equal([state.q for state in told], log["q"])
    np.testing.assert_array_equal([state.v for state in told], log["v"])
    sensed = np.array([state.contact for state in told])
    assert not sensed[:5].any()  # it starts a centimetre above the ground
    assert sensed[-1].all()
    np.testing.assert_array_equal(sensed[1:], log["forces"][:-1, :, 2] > 0.02 * log.facts["mass"] * 9.81)
    assert watcher.log is log
    assert [m.time for m in watcher.moments] == pytest.approx(log["time"])
    np.testing.assert_array_equal([m.reading.forces for m in watcher.moments], log["forces"])
    np.testing.assert_array_equal([m.command.torques for m in watcher.moments], log["torques"])
    assert ticks == pytest.approx(0.02 * np.arange(10), abs=1.1e-3)


def test_a_lost_state_a_fall_and_an_error_end_a_run_each_in_its_way(
    robot: sf.Robot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)  # where MuJoCo writes its warnings
    scenario, watcher = sf.Scenario(0.6, 0.6), Watcher()

    def lose(command: Command) -> Command:
        command.torques[:] = 1e12
        return command

    def spoil(command: Command) -> Command:
        command.torques[3] = np.nan
        return command

    def limp(command: Command) -> Command:
        command.torques[:] = 0.0
        return command

    def fail(command: Command) -> Command:
        raise ArithmeticError("by zero")

    controller = standing(robot)
    controller.fails = lose
    log = run(sf.MujocoWorld(robot, mu=0.6), controller, scenario, [watcher])
    assert log.facts["outcome"] == Ending.INVALID
    assert "became non-finite" in log.facts["error"]
    assert 50 <= len(log) < 60
    assert watcher.log is log
    controller.fails = spoil
    log = run(sf.MujocoWorld(robot, mu=0.6), controller, scenario)
    assert (log.facts["outcome"], log.facts["error"]) == (Ending.INVALID, "torques[3] is NaN")
    assert len(log) == 51
    controller.fails = limp
    log = run(sf.MujocoWorld(robot, mu=0.6), controller, scenario)
    assert log.facts["outcome"] == Ending.FELL
    assert len(log) < 600
    controller.fails = fail
    with pytest.raises(ArithmeticError):
        run(sf.MujocoWorld(robot, mu=0.6), controller, scenario, folder=tmp_path / "rows")
    assert len(read_log(tmp_path / "rows")) == 51  # what was made before is kept


def test_an_observer_can_stop_a_run(robot: sf.Robot) -> None:
    class Enough(Observer):
        def step(self, moment: Moment) -> None:
            if moment.time > 0.0295:
                raise KeyboardInterrupt

    log = run(sf.MujocoWorld(robot, mu=0.6), standing(robot), sf.Scenario(0.6, 0.6), [Enough()])
    assert log.facts["outcome"] == Ending.INTERRUPTED
    assert len(log) == 31


@pytest.mark.parametrize("degrees", [0.0, 25.0])
def test_a_fall_is_seen_from_the_ground_below(degrees: float, robot: sf.Robot) -> None:
    slope, fall = sf.SlopeTerrain(degrees), Fall(0.5, np.radians(40.0))
    q = sf.place(robot, slope)
    height = float(q[2] - slope.height(q[:2]))
    assert fall.happened(q, height, slope) is None
    far = q.copy()
    far[0] += 3.0
    assert (fall.happened(far, height, slope) is Ending.FELL) == (
        degrees > 0.0
    )  # the slope has risen above it
    far[2] += float(slope.height(far[:2]) - slope.height(q[:2]))
    assert fall.happened(far, height, slope) is None
    assert fall.happened(far * np.nan, height, slope) is Ending.INVALID


def test_it_starts_where_the_scenario_says_and_as_deep(robot: sf.Robot) -> None:
    slope = sf.SlopeTerrain(10.0)
    world = sf.RigidWorld(robot, slope, 0.6)
    q, v = sf.Scenario(1.0, 0.6, depth=1e-3).begin(world)
    assert v is None
    np.testing.assert_allclose(q[:3], sf.place(robot, slope)[:3] - 1e-3 * slope.normal(q[:2]), atol=1e-15)
    start = robot.nominal
    q, v = sf.Scenario(1.0, 0.6, seed=2, start=start).begin(world)
    np.testing.assert_array_equal(q, start)
    assert v is not None
    assert 0.0 < np.abs(v[:3]).max() < 0.05


def test_any_function_of_the_state_is_a_controller(go2: sf.Robot) -> None:
    """Torques, joint targets or a command; what the command says nothing of is unknown in the log."""
    q = sf.place(go2)
    gains = np.full(12, 100.0), np.full(12, 3.0)

    def torques(state: RobotState) -> Any:
        return gains[0] * (q[7:] - state.q[7:]) - gains[1] * state.v[6:]

    ways = (
        torques,
        lambda state: sf.Command(torques(state)),
        lambda state: JointTargets(q[7:], np.zeros(12), *gains, np.zeros(12)),
    )
    world = sf.MujocoWorld(go2, mu=0.4)
    logs = [sf.run(world, way, sf.Scenario(0.2)) for way in ways]
    for log in logs:
        assert log["q"] == pytest.approx(logs[0]["q"], abs=1e-9)
        assert np.isnan(log["forces_commanded"]).all()
        assert log["active"].all()
        assert (log["mu"] == 0.4).all()  # the world's own
        assert sf.audit_log(log).verdict == "lawful"
    assert logs[0].facts["kind"] == "torques"


@pytest.mark.parametrize(
    ("parts", "said"),
    [
        (("world", None), "controller must be an sf.Controller .* got None"),
        (("world", 3.0), "int|float, which lacks step, reset, warm_up, channels, facts"),
        (("world", sf.StandingController), "is a class, not an object"),
        (("world", lambda state: np.zeros(3)), r"returns \(joints,\) = \(12,\) torques"),
        (("world", lambda state: None), "returns .* got None"),
        (("world", lambda state: np.zeros(12), 5.0), r"scenario must be a Scenario, as sf.Scenario\(5.0\)"),
        ((None, lambda state: np.zeros(12)), "world must be one as .* NoneType lacks robot, terrain"),
    ],
)
def test_what_is_missing_for_a_run_is_named(go2: sf.Robot, parts: tuple[Any, ...], said: str) -> None:
    with pytest.raises(sf.ProblemError, match=said):
        sf.run(*(sf.MujocoWorld(go2) if part == "world" else part for part in parts))
