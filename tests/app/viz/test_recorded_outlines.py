"""Outlines of a body without joints: each shape's own size, and the crate of a story where it is."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

import surefoot as sf
from surefoot.app.viz.recorded_outlines import outline, shape_points
from surefoot.app.viz.story_plots import draw_story
from tests.worlds.mujoco.strangers import thrown_crate


@pytest.mark.parametrize(
    ("shape", "half"),
    [
        ("type='box' size='.1 .2 .3'", (0.1, 0.2, 0.3)),
        ("type='sphere' size='.2'", (0.2, 0.2, 0.2)),
        ("type='ellipsoid' size='.1 .2 .3'", (0.1, 0.2, 0.3)),
        ("type='capsule' size='.1 .3'", (0.1, 0.1, 0.4)),
        ("type='cylinder' size='.1 .3'", (0.1, 0.1, 0.3)),
    ],
)
def test_points_of_a_shape_reach_as_far_as_it_does(shape: str, half: tuple[float, float, float]) -> None:
    model = mujoco.MjModel.from_xml_string(
        f"<mujoco><worldbody><geom type='plane' size='1 1 1'/><body pos='0 0 1'><freejoint/>"
        f"<geom {shape} pos='.5 0 0' mass='1'/></body></worldbody></mujoco>"
    )
    data = mujoco.MjData(model)
    with sf.record(model, data) as log:
        mujoco.mj_step(model, data, 3)
    (points,) = shape_points(log)
    np.testing.assert_allclose(np.ptp(points, axis=0), 2.0 * np.array(half), rtol=1e-9)
    np.testing.assert_allclose(points.mean(axis=0), (0.5, 0.0, 0.0), atol=1e-9)
    corners = outline(points[:, :2])
    assert np.abs(corners - [0.5, 0.0]).max() == pytest.approx(max(half[:2]))


def test_points_on_a_line_are_their_own_outline() -> None:
    line = np.array([[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]])
    np.testing.assert_array_equal(outline(line), line)


def test_a_story_of_a_crate_is_drawn(tmp_path: Path) -> None:
    log = thrown_crate(12.0)
    assert len(shape_points(log)) == 1
    assert draw_story(sf.audit_log(log), tmp_path / "story.png").stat().st_size > 10_000
    assert shape_points(sf.Log({"time": np.zeros(3)}, {})) == []
