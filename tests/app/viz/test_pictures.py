"""Pictures are drawn, hold what they should, and their absence is survivable."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import surefoot as sf
from surefoot.app.viz import meshes, report
from surefoot.app.viz.film import write_video
from surefoot.app.viz.plots import draw_run
from surefoot.base.errors import ProblemError, SurefootError
from surefoot.motion.standing.standing_controller import StandingController
from surefoot.motion.standing.standing_plan import StandingPlan
from surefoot.records.log import Log
from surefoot.worlds.mujoco.mujoco_world import MujocoWorld
from surefoot.worlds.running.run import Ice, Push, Scenario, run


@pytest.fixture(scope="module")
def log() -> Log:
    robot, terrain = sf.load_robot("g1"), sf.FlatTerrain()
    q = sf.place(robot, terrain)
    controller = StandingController(robot, StandingPlan(robot, terrain, q), terrain, q)
    scenario = Scenario(0.3, 0.6, [Push(0.1, (20.0, 0.0, 0.0), 0.1)], [Ice(0.2, 0.4)])
    return run(MujocoWorld(robot), controller, scenario)


def test_every_plot_is_a_picture(log: Log, tmp_path: Path) -> None:
    from matplotlib.image import imread

    for path in draw_run(log, tmp_path):
        pixels = imread(path)
        assert min(pixels.shape[:2]) > 200
        assert pixels.std() > 0.02  # something is on it


@pytest.mark.long
def test_a_run_is_filmed(log: Log, tmp_path: Path) -> None:
    try:
        path = write_video(log, sf.load_robot("g1"), sf.FlatTerrain(), tmp_path / "film.mp4")
    except SurefootError as error:
        pytest.skip(str(error))
    assert path.stat().st_size > 2000


def test_parts_of_a_mesh_are_separated_and_turned_outwards() -> None:
    corners = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
    box = np.array(
        [[0, 1, 2], [1, 3, 2], [4, 6, 5], [5, 6, 7], [0, 4, 1], [1, 4, 5],
         [2, 3, 6], [3, 7, 6], [0, 2, 4], [2, 6, 4], [1, 5, 3], [3, 5, 7]]
    )  # fmt: skip
    both = np.vstack([corners, corners + 5.0])
    numbered_from_zero = np.vstack([box, box[:, ::-1]])
    numbered_from_zero[12] = [0, 1, 2]
    mended = meshes._separate_parts(numbered_from_zero, 16)
    np.testing.assert_array_equal(mended[12:].min(), 8)
    outward = meshes._face_outwards(both, np.vstack([box, box[:, ::-1] + 8]))
    for part in (outward[:12], outward[12:]):
        a, b, c = (both[part[:, k]] - both[part].mean(axis=(0, 1)) for k in range(3))
        assert np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0 == pytest.approx(1.0)


def test_report_holds_everything_and_overwrites_nothing(log: Log, tmp_path: Path) -> None:
    plots = draw_run(log, tmp_path)
    sections = [("A <b>", report.table(["x"], [["1 & 2"]])), ("P", report.embed_picture(plots[0]))]
    path = report.write_report(tmp_path / "report.html", "Title", ("fine", True), sections, "surefoot stand")
    text = path.read_text()
    assert "A &lt;b&gt;" in text
    assert "1 &amp; 2" in text
    assert "data:image/png;base64," in text
    assert "http" not in text  # needs nothing from elsewhere
    with pytest.raises(ProblemError, match="exists already"):
        report.write_report(path, "Title", ("fine", True), [], "x")
