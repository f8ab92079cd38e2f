"""The numbered examples on standing, walking and planning run, and their claims hold."""

from __future__ import annotations

import runpy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from surefoot.base.spatial import GRAVITY

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


def script(name: str) -> dict[str, Any]:
    """Run an example as a script and return its names."""
    return runpy.run_path(str(EXAMPLES / f"{name}.py"))


@pytest.mark.long
def test_a_quarter_of_the_weight_on_every_foot(tmp_path: Path) -> None:
    normal = script("01_stand")["main"](tmp_path / "stand.png")
    share = 16.085 * GRAVITY * np.cos(np.radians(20.0)) / 4
    np.testing.assert_allclose(normal, share, rtol=0.01)


@pytest.mark.parametrize(("name", "more"), [("01_stand", ()), ("02_pushed_on_a_slope", (0.5,))])
def test_a_picture_that_exists_is_kept(name: str, more: tuple[float, ...], tmp_path: Path) -> None:
    path = tmp_path / "mine.webp"
    path.write_text("mine")
    script(name)["main"](path, *more)
    assert path.read_text() == "mine"


@pytest.mark.long
def test_the_animation_has_the_pictures_of_the_walk(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "pushed.webp"
    log = script("02_pushed_on_a_slope")["main"](path, 0.8)
    assert log.facts["outcome"] == "done"
    if not path.exists():
        pytest.skip(capsys.readouterr().out)
    from PIL import Image

    with Image.open(path) as animation:
        assert animation.size == (720, 405)
        assert animation.n_frames in (11, 12)  # rounding decides on the last


def test_a_thrown_cube_slides_to_rest_under_coulombs_law(tmp_path: Path) -> None:
    path = tmp_path / "mine.webp"
    path.write_text("mine")
    runs = script("27_two_ground_laws")["main"](path)
    assert path.read_text() == "mine"
    assert runs["sf.MujocoStepper"][-1, 0] == pytest.approx(3.664, abs=1e-3)
    assert runs["sf.MujocoStepper"][:, 2].max() < 0.05 + 1e-6


def test_can_it_stand(capsys: pytest.CaptureFixture[str]) -> None:
    script("10_can_it_stand")
    text = capsys.readouterr().out
    assert "20 deg, mu 0.6: It can stand" in text
    assert "friction needed 0.700" in text
    assert "no force works against the motion" in text


@pytest.mark.long
def test_a_trot_over_bumps_takes_a_push(tmp_path: Path, load) -> None:
    facts = load("30_trot").main(tmp_path, duration=4.0)
    assert facts["walked"] == 1.0
    assert facts["forward"] == pytest.approx(0.4, rel=0.1)
    assert facts["commanded_excess"] == 0.0
    assert facts["cone_use"] <= 1.001
    assert len(list(tmp_path.rglob("*.png"))) == 2


@pytest.mark.long
def test_an_own_gait_walks_from_phases_and_from_mode_numbers(load) -> None:
    speeds = load("31_own_gait").main(duration=3.5)
    assert speeds["phases"] == pytest.approx(0.4, rel=0.1)
    assert speeds["modes"] == pytest.approx(speeds["phases"], abs=0.01)
    assert speeds["refused"] == 1.0


def test_whole_body_control_gives_what_friction_allows(tmp_path: Path, load) -> None:
    facts = load("32_whole_body_step").main(tmp_path)
    assert 0.7 * facts["friction"] < facts["largest"] <= facts["friction"] + 1e-6
    assert facts["use"] == pytest.approx(1.0, abs=1e-6)


def test_a_kick_on_a_slope_is_planned_away(tmp_path: Path, load) -> None:
    facts = load("33_plan_on_a_slope").main(tmp_path, kick=0.4)
    assert facts["left"] < 0.4 * 0.4
    assert 0.99 < facts["use"] < 1.0 + 1e-9
    assert facts["error"] < 1e-2
    assert (tmp_path / "33_plan_on_a_slope" / "plan.png").stat().st_size > 10_000
