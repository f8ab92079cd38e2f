"""Replays in another world: what is known to survive, what cannot, and logs that lack what a replay needs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import surefoot as sf
from benchmarks.problems.logged_runs import CleanRun
from surefoot.base.errors import ProblemError
from surefoot.mechanics.robot import load_robot
from surefoot.mechanics.terrain import SlopeTerrain, read_terrain
from surefoot.mechanics.terrain.heightfield import HeightfieldTerrain
from surefoot.records.log import Log
from surefoot.worlds.drake import drake_python
from surefoot.worlds.replay import replay
from surefoot.worlds.replay.replay import replay_log
from surefoot.worlds.replay.replay_task import replay_task
from tests.records.audit.logs import SLOPE, STAND, TROT, changed, log_of

pytest.importorskip("mujoco")
SHORT_TROT = CleanRun(world="rigid", gait="trot", velocity=(0.4, 0.0, 0.0), duration=1.4, seed=4)


@pytest.mark.parametrize(("run", "world"), [(TROT, "rigid"), (STAND, "mujoco"), (SLOPE, "mujoco")])
def test_lawful_motions_survive_in_the_other_world(run: CleanRun, world: str) -> None:
    report = replay_log(log_of(run), world)
    assert report.verdict == "survives", report.sentence
    assert all(w.outcome == "done" and not w.broken for w in report.windows)
    if run.gait:
        assert report.progress == pytest.approx(1.0, abs=0.05)
    for log in report.logs:
        assert sf.audit_log(log).lawful


@pytest.mark.skipif(
    not drake_python.present(), reason="Drake is not here; SUREFOOT_DRAKE_PYTHON names a Python with it"
)
def test_drake_keeps_a_lawful_trot_and_loses_it_on_ice() -> None:
    """A log of the rigid world in an engine that shares no code with it."""
    log = log_of(SHORT_TROT)
    report = replay_log(log, "drake")
    assert report.verdict == "survives", report.sentence
    assert report.progress == pytest.approx(1.0, abs=0.05)
    assert report.logs[0].facts["world"] == "DrakeWorld"
    assert not np.array_equal(report.logs[0]["forces"], log["forces"][: len(report.logs[0])])
    assert replay_log(log, "drake", mu=0.03).verdict == "lost"


@pytest.mark.long
def test_the_same_world_gives_the_log_again() -> None:
    """With nothing to track, the feed-forward torques alone are the log's: the motion is the same."""
    log = log_of(SHORT_TROT)
    report = replay_log(log, "rigid")
    again = report.logs[0]
    assert report.verdict == "survives"
    assert np.abs(again["q"] - log["q"][: len(again)]).max() < 1e-3
    np.testing.assert_allclose(again["time"], log["time"][: len(again)], atol=1e-12)


@pytest.mark.long
def test_a_trot_that_needs_its_friction_is_lost_on_ice() -> None:
    log = log_of(SHORT_TROT)
    report = replay_log(log, "mujoco", mu=0.03)
    assert report.verdict == "lost"
    assert report.progress < 0.8
    assert not any(w.lost for w in report.own_windows)  # there, at the log's own friction
    assert replay_log(log, "rigid", mu=0.03).verdict == "lost"


@pytest.mark.long
def test_what_holds_only_in_its_own_world_is_lost(monkeypatch: pytest.MonkeyPatch) -> None:
    """A world that is told apart from the log's own by its gravity: the robot cannot carry itself there."""
    from surefoot.worlds.interface import world_names as worlds
    from surefoot.worlds.rigid.rigid_world import RigidWorld

    class Heavy(RigidWorld):
        def step(self, torques: np.ndarray, push: np.ndarray | None = None) -> None:
            weight = np.array([0.0, 0.0, -30.0 * self.robot.mass])
            super().step(torques, weight if push is None else push + weight)

    monkeypatch.setitem(worlds.WORLDS, "heavy", Heavy)
    report = replay_log(log_of(SHORT_TROT), "heavy")
    assert report.verdict == "lost", report.sentence
    assert "in the log's own world (rigid) the same replay holds" in report.reason
    assert not any(w.lost for w in report.own_windows)


def test_a_robot_that_floats_in_its_log_does_not_survive() -> None:
    log = log_of(STAND)
    q = np.array(log["q"])
    q[:, 2] += 0.2
    report = replay_log(changed(log, q=q), "mujoco")
    assert not report.survives


def test_a_log_that_ends_in_a_fall_has_no_success() -> None:
    log = log_of(STAND)
    q = np.array(log["q"])
    q[-50:, 2] = 0.05
    report = replay_log(changed(log, q=q), "rigid")
    assert (report.verdict, report.windows) == ("cannot tell", ())
    assert "falls in the log itself" in report.sentence


def test_a_log_of_another_world_is_not_called_lost() -> None:
    log = changed(log_of(SHORT_TROT), facts={"world": "IsaacLab"})
    report = replay_log(log, "rigid", mu=0.03)
    assert report.verdict == "cannot tell"
    assert report.own == ""


def test_windows_begin_where_the_log_is(monkeypatch: pytest.MonkeyPatch) -> None:
    log = log_of(TROT)
    monkeypatch.setattr(replay, "WINDOW", 0.3)
    report = replay_log(log, "mujoco")
    assert [round(w.start, 3) for w in report.windows] == [0.0, 0.3, 0.6, 0.9]
    assert report.windows[-1].end == pytest.approx(log["time"][-1])
    assert report.survives


def test_slower_rows_are_replayed_in_steps() -> None:
    log = log_of(STAND).rows(slice(None, None, 5))
    task = replay_task(log)
    assert (task.steps, task.dt) == (5, pytest.approx(1e-3))
    assert replay_log(log, "mujoco").survives


def test_joints_in_another_order_are_the_same_replay() -> None:
    log = log_of(STAND)
    order = np.random.default_rng(3).permutation(12)
    q, v = np.array(log["q"]), np.array(log["v"])
    q[:, 7:], v[:, 6:] = q[:, 7 + order], v[:, 6 + order]
    names = [log.facts["joints"][k] for k in order]
    mixed = changed(log, facts={"joints": names}, q=q, v=v, torques=log["torques"][:, order])
    one, two = replay_task(log), replay_task(mixed)
    for name in ("q", "v", "torques"):
        np.testing.assert_array_equal(getattr(one, name), getattr(two, name))


def test_gains_are_the_logs_or_made_from_the_robot() -> None:
    log, robot = log_of(STAND), load_robot("go2")
    made = replay_task(log)
    assert (made.stiffness <= robot.mass * 9.81 * robot.nominal[2] + 1e-9).all()
    assert (made.damping > 0.0).all()
    given = replay_task(changed(log, facts={"joint_stiffness": [20.0] * 12, "joint_damping": [0.5] * 12}))
    np.testing.assert_array_equal(given.stiffness, 20.0)
    np.testing.assert_array_equal(given.damping, 0.5)


def _without(log: Log, *facts: str) -> Log:
    return Log(log.arrays, {k: v for k, v in log.facts.items() if k not in facts}, channels=log.channels)


@pytest.mark.parametrize(
    ("spoil", "told"),
    [
        (lambda log: _without(log, "terrain", "robot"), r"no fact robot \(give robot\), no fact terrain"),
        (lambda log: changed(log, keep=("q", "v", "mu")), "it has no channel torques"),
        (lambda log: changed(log, keep=("q", "v", "torques")), "it has no friction mu"),
        (lambda log: changed(log, torques=log["torques"] * np.nan), "torques is not finite in row 0"),
        (lambda log: changed(log, time=log["time"][::-1]), "not evenly spaced"),
        (lambda log: changed(log, time=log["time"] * 100.0), "rows are 0.1 s apart"),
        (lambda log: changed(log, q=log["q"] * 1.1), "row 0 is no unit quaternion"),
        (lambda log: changed(log, facts={"robot": "a1", "joints": ["x"] * 12}), "joints are not those of a1"),
        (lambda log: changed(log, facts={"robot": "solo8"}), "the log cannot be replayed: solo8 has"),
        (lambda log: changed(log, facts={"terrain": "moon"}), "the log cannot be replayed: terrain 'moon'"),
        (lambda log: changed(log, facts={"payload": -1.0}), "the fact payload must be a number between"),
        (lambda log: log.rows(slice(0, 2)), "fewer than three rows"),
    ],
)
def test_what_cannot_be_replayed_is_told_in_a_line(spoil: object, told: str) -> None:
    with pytest.raises(ProblemError, match=told) as caught:
        replay_log(spoil(log_of(STAND)), "rigid")  # type: ignore[operator]
    assert "\n" not in str(caught.value)


def test_worlds_are_checked() -> None:
    with pytest.raises(
        ProblemError, match="unknown world 'moon'; valid names: bullet, drake, mujoco, mujoco-exact, rigid"
    ):
        replay_log(log_of(STAND), "moon")


def test_the_command_line(tmp_path: Path, printed: Any, answer: Any) -> None:
    from surefoot.app.cli.main import main

    path = log_of(STAND).save(tmp_path / "stand.npz")
    assert replay_log(path, "rigid").verdict == "survives"
    assert "the success survives in the world mujoco" in printed("audit", path, "--replay", "mujoco")
    assert answer("audit", path, "--replay", "mujoco")["replay"]["verdict"] == "survives"
    bare = _without(log_of(STAND), "terrain").save(tmp_path / "bare.npz")
    assert "no fact terrain" in printed("audit", bare, "--replay", "rigid", code=2)
    assert main(["audit", str(bare), "--replay", "rigid", "--terrain", "flat"]) == 0


def test_terrains_say_themselves() -> None:
    places = np.random.default_rng(0).uniform(-2.0, 2.0, (50, 2))
    for text in ("flat", "slope:12.345678901", "stairs:0.12,0.3", "rough:3,0.04", "pit:1,0.3,0.05"):
        ground = read_terrain(text)
        np.testing.assert_array_equal(read_terrain(ground.text).height(places), ground.height(places))
    assert sf.StairsTerrain(steps=3).text == HeightfieldTerrain(np.zeros((2, 2)), 1.0).text == ""
    assert SlopeTerrain(-3.5).text == "slope:-3.5"
