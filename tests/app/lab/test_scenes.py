"""Logs, plans, motions, stances and verdicts as scenes of rerun and viser."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import surefoot as sf
from surefoot.app.lab.drawing import Arrows, Mesh
from surefoot.app.lab.scenes import RATE, frames_of
from surefoot.base.errors import MissingExtra, ProblemError

pytest.importorskip("trimesh", reason="viser brings it")


@pytest.fixture(scope="module")
def answers() -> dict[str, Any]:
    robot = sf.load_robot("go2")
    q = sf.place(robot)
    stance = robot.stance(q, mu=0.6)
    controller = sf.StandingController(
        robot, sf.StandingPlan(robot, sf.FlatTerrain(), q), sf.FlatTerrain(), q
    )
    return {
        "log": sf.run(sf.RigidWorld(robot), controller, sf.Scenario(0.2, start=q)),
        "plan": sf.plan(None, "ball"),
        "motion": sf.Motion(robot, np.tile(q, (30, 1)), 30.0, "still"),
        "stance": stance,
        "verdict": sf.can_stand(stance, robot.com(q), robot.mass),
        "proof": sf.can_stand(stance, [2.0, 0.0, 0.3], robot.mass),
    }


def test_a_log_has_its_robot_its_forces_and_its_time(answers: dict[str, Any]) -> None:
    log = answers["log"]
    frames = list(frames_of(log))
    assert len(frames) == pytest.approx(0.2 * RATE, abs=1.0)
    assert frames[0][0] == 0.0
    assert frames[-1][0] <= log.duration
    time, shapes = frames[-1]
    arrows = [shape for name, shape in shapes.items() if name.startswith("/forces/")]
    assert len(arrows) == 4
    assert any(isinstance(shape, Mesh) for name, shape in shapes.items() if name.startswith("/robot"))
    row = int(np.searchsorted(log["time"], time + log["time"][0]))
    places = [shape.position for shape in arrows if isinstance(shape, Arrows)]
    np.testing.assert_allclose(places, log["contact_positions"][row], atol=1e-9)


def test_a_robot_that_goes_moves_in_the_scene() -> None:
    robot = sf.load_robot("go2")
    q = np.tile(sf.place(robot), (60, 1))
    q[:, 0] += np.linspace(0.0, 1.0, 60)
    first, *_, last = frames_of(sf.Motion(robot, q, 30.0))
    base = next(name for name in first[1] if name.startswith("/robot"))
    moved = np.subtract(last[1][base].position, first[1][base].position)  # type: ignore[union-attr]
    np.testing.assert_allclose(moved, [1.0, 0.0, 0.0], atol=0.05)


@pytest.mark.parametrize("name", ["log", "plan", "motion", "stance", "verdict", "proof"])
def test_a_scene_of_viser(name: str, answers: dict[str, Any], tmp_path: Path) -> None:
    pytest.importorskip("viser")
    path = sf.picture(answers[name], tmp_path / "scene.viser")
    assert path.stat().st_size > 1000
    with pytest.raises(ProblemError, match="exists already"):
        sf.picture(answers[name], path)


@pytest.mark.parametrize("name", ["log", "plan", "motion", "stance", "verdict", "proof"])
def test_a_scene_of_rerun(name: str, answers: dict[str, Any], tmp_path: Path) -> None:
    pytest.importorskip("rerun")
    path = sf.picture(answers[name], tmp_path / "scene.rrd")
    assert path.read_bytes()[:3] == b"RRF"
    assert path.stat().st_size > 1000


def test_what_has_no_scene_or_no_viewer_says_so(
    answers: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(ProblemError, match=r"a picture is one of \.png, \.svg, \.pdf, got '\.rrd'"):
        sf.picture(sf.FrictionCone(0.6), tmp_path / "cone.rrd")
    with pytest.raises(ProblemError, match="scenes are of logs, plans, motions, stances and verdicts"):
        list(frames_of(3.0))
    monkeypatch.setitem(__import__("sys").modules, "rerun", None)
    with pytest.raises(MissingExtra, match=r"rerun-sdk is not installed; run: pip install -e '\.\[rerun\]'"):
        sf.picture(answers["stance"], tmp_path / "stance.rrd")
    assert not [*tmp_path.iterdir()]
