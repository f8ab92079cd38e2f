"""Plans and logs: every row can be scrubbed, violations are jumped to, and what is missing is said."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest

import surefoot as sf
from benchmarks.problems.logged_runs import CleanRun
from surefoot.app.lab.drawing import BAD, Arrows, Mesh
from surefoot.app.lab.recording import NOWHERE, RecordedMotion, RecordingPage, audit_page, plan_page
from surefoot.base.errors import ProblemError
from surefoot.motion.planning import Plan, rollout
from surefoot.motion.planning.plan import PlanSearch, plan_from
from surefoot.records.audit import audit_log


@pytest.fixture(scope="module")
def log() -> sf.Log:
    """A lawful trot with 40 ms of a force outside its cone."""
    made = CleanRun(gait="trot", velocity=(0.3, 0.0, 0.0), duration=1.5).make()
    forces = np.array(made["forces"])
    middle = len(made) // 2
    forces[middle : middle + 40, 0, 0] += 80.0
    return sf.Log({**made.arrays, "forces": forces}, made.facts, channels=made.channels)


@pytest.fixture(scope="module")
def page(log: sf.Log) -> RecordingPage:
    return audit_page(RecordedMotion(log), audit_log(log))


@pytest.mark.long
def test_the_robot_is_where_the_log_says(page: RecordingPage, log: sf.Log) -> None:
    robot = sf.load_robot(str(log.fact("robot")))
    for share in (0.0, 0.4, 1.0):
        row = int(share * (len(log) - 1))
        page.change("time", float(log["time"][row]))
        assert page.row == row
        shapes = page.drawing().shapes
        base = shapes["/robot/root_joint"]
        assert isinstance(base, Mesh)
        np.testing.assert_allclose(base.position, [0.0, 0.0, log["q"][row, 2]], atol=1e-12)
        feet = robot.foot_positions(log["q"][row]) - [*log["q"][row, :2], 0.0]
        for name, shape in shapes.items():
            if name.startswith("/cones/"):
                assert isinstance(shape, Mesh)
                place = feet[robot.foot_names.index(name.removeprefix("/cones/"))]
                assert np.linalg.norm(place - shape.position) < 0.05


def test_arrows_are_the_forces_of_the_row(page: RecordingPage, log: sf.Log) -> None:
    row = int(0.25 * len(log))
    page.change("time", float(log["time"][row]))
    shown = page.drawing().shapes
    arrows = [s for name, s in shown.items() if name.startswith("/forces/") and isinstance(s, Arrows)]
    up = sum((a.points[:, 1] - a.points[:, 0])[:, 2].sum() for a in arrows)
    mass = float(log.fact("mass"))
    assert up == pytest.approx(0.5 * log["forces"][row, :, 2].sum() / (mass * 9.81), rel=1e-3)


def test_violations_are_jumped_to(page: RecordingPage, log: sf.Log) -> None:
    report = audit_log(log)
    assert report.violations
    friction = next(v for v in report.violations if v.law == "friction")
    choice = next(c for c in page.values.controls if c.name == "jump")
    name = next(option for option in choice.options if "friction" in option)  # type: ignore[union-attr]
    page.change("jump", name)
    shown = page.drawing()
    assert name in shown.text
    assert page.values["time"] == pytest.approx(friction.start, abs=1e-9)
    assert any(s.colour == BAD for n, s in shown.shapes.items() if isinstance(s, Arrows) and "/forces/" in n)
    page.change("jump", NOWHERE)


def test_it_plays_by_the_clock_and_stops_at_the_end(log: sf.Log) -> None:
    page = RecordingPage(RecordedMotion(log), "a log")
    assert not page.live
    page.change("speed", 2.0)
    page.change("time", float(log["time"][-1]) - 0.3)
    page.change("play", True)
    assert page.live
    begin, before = time.perf_counter(), page.values["time"]
    time.sleep(0.05)
    page.drawing()
    passed = time.perf_counter() - begin
    assert 0.0 < page.values["time"] - before <= 2.0 * passed + 1e-9
    time.sleep(0.2)
    page.drawing()
    assert not page.live
    assert page.values["time"] == pytest.approx(float(log["time"][-1]))
    page.change("play", True)  # once more from the beginning
    assert page.values["time"] == float(log["time"][0])


def test_rows_that_are_not_finite_are_drawn_without(log: sf.Log) -> None:
    arrays = {name: np.array(log[name]) for name in ("time", "q", "forces", "contact_positions", "mu")}
    for name in ("q", "forces", "contact_positions", "mu"):
        arrays[name][5] = np.nan
    page = RecordingPage(RecordedMotion(sf.Log(arrays, log.facts)), "a log")
    page.change("time", float(log["time"][5]))
    shapes = page.drawing().shapes
    assert not any(name.startswith(("/robot", "/forces", "/cones")) for name in shapes)
    page.press("on")
    assert any(name.startswith("/robot") for name in page.drawing().shapes)


def test_what_a_log_lacks_is_said() -> None:
    time_ = np.arange(50) * 0.01
    page = RecordingPage(RecordedMotion(sf.Log({"time": time_, "forces": np.ones((50, 2, 3))})), "a log")
    shown = page.drawing()
    assert "names no robot" in shown.text
    assert "no contact_positions" in shown.text
    assert shown.figure.startswith("<svg")


@pytest.mark.parametrize(
    ("times", "said"), [(np.zeros(0), "no rows"), (np.array([0.0, 1.0, 0.5]), "do not rise")]
)
def test_a_log_that_cannot_be_scrubbed_is_refused(times: np.ndarray, said: str) -> None:
    with pytest.raises(ProblemError, match=said):
        RecordedMotion(sf.Log({"time": times}))


def test_a_plan_from_a_file_is_shown(tmp_path: Path) -> None:
    robot = sf.load_robot("go2")
    motion = rollout(robot, sf.place(robot), np.zeros(18), np.zeros((10, 12)), dt=0.01)
    plan_from(
        motion, robot, PlanSearch("fall", "none", cost=0.0, reached=True, iterations=0, seconds=0.0)
    ).save(tmp_path / "plan.npz")
    plan = Plan.read(tmp_path / "plan.npz")
    page = plan_page(RecordedMotion(plan), plan)
    assert page.title == "Plan: fall"
    page.change("time", 0.05)
    shown = page.drawing()
    assert "row 5 of 10" in shown.text
    assert any(name.startswith("/robot/") for name in shown.shapes)


def test_a_robot_whose_configurations_the_log_has_not_is_not_drawn(log: sf.Log) -> None:
    shown = RecordedMotion(log, sf.load_robot("bolt"))
    assert shown.robot is None
    assert any("are not those of" in note for note in shown.notes)
