"""Pictures of a stance: what is drawn is where it should be, inside its axes, and of the right size."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import surefoot as sf
from surefoot.app.viz import stance_plots
from surefoot.app.viz.shapes import bones
from surefoot.app.viz.stance_plots import draw_check, draw_regions
from surefoot.app.viz.stance_scene import AROUND, surfaces
from surefoot.app.viz.style import BAD, friction_colour
from surefoot.base.spatial import GRAVITY
from surefoot.contact import Sole
from surefoot.mechanics.stance import PointContact, SoleContact, Stance
from surefoot.mechanics.stance.files import StanceQuestion
from surefoot.mechanics.statics.com_region import com_region, support_polygon, zmp_region
from surefoot.mechanics.statics.statics import can_stand

pytest.importorskip("matplotlib")
LENGTH, WIDTH, MASS = 0.5, 0.3, 12.0


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """Return the list that figures go to in place of a file."""
    figures: list[Any] = []

    def keep(figure: Any, path: Path) -> Path:
        figures.append(figure)
        return path

    monkeypatch.setattr(stance_plots, "save", keep)
    return figures


def question(com: tuple[float, float, float] = (0.05, 0.02, 0.3)) -> StanceQuestion:
    """Return four feet in a rectangle on level ground."""
    corners = [(x * LENGTH, y * WIDTH, 0.0) for x, y in ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5))]
    feet = [PointContact(p, mu=1.5, name=f"{k}_foot") for k, p in enumerate(corners)]
    return StanceQuestion("four feet", Stance(feet), MASS, np.array(com))


def places(axis: Any) -> Iterator[np.ndarray]:
    """Yield the points (k, 2) of an axis' lines and marks."""
    for line in axis.lines:
        yield np.column_stack(line.get_data())


def assert_inside(axis: Any) -> None:
    """Check that every line of an axis is within what it shows, with a margin around."""
    low, high = np.transpose([axis.get_xlim(), axis.get_ylim()])
    points = np.vstack(list(places(axis)))
    assert (points > low).all()
    assert (points < high).all()


def test_regions_of_a_rectangle_are_the_rectangle(drawn: list[Any], tmp_path: Path) -> None:
    """On level ground with enough friction, the centre of mass may be anywhere between the feet.

    So may the zero-moment point: it is at most 0.35 m off the centre, and friction times height is 0.45 m.
    """
    asked = question()
    regions = com_region(asked.stance, MASS), zmp_region(asked.stance, asked.com, MASS)
    draw_regions(asked, *regions, support_polygon(asked.stance), tmp_path / "regions.png")
    axes = drawn[0].axes
    assert len(axes) == 3
    for axis, name in zip(axes, ("CoM region", "support polygon", "ZMP region"), strict=True):
        assert_inside(axis)
        said = re.fullmatch(rf"{name}, (\d+) cm²", axis.get_title())
        assert said is not None
        assert float(said[1]) == pytest.approx(1e4 * LENGTH * WIDTH, rel=0.01)
        filled = [patch.get_xy() for patch in axis.patches]
        assert len(filled) == 1
        np.testing.assert_allclose(np.ptp(filled[0], axis=0), [LENGTH, WIDTH], rtol=0.01)


def test_forces_of_a_stance_carry_its_weight(drawn: list[Any], tmp_path: Path) -> None:
    asked = question()
    verdict = can_stand(asked.stance, asked.com, MASS)
    draw_check(asked, verdict, "possible: it stands", tmp_path / "stance.png")
    space, above = drawn[0].axes
    said = [re.search(r"(\d+) N, \d+ %", text.get_text()) for text in space.texts]
    forces = [float(one[1]) for one in said if one is not None]
    assert len(forces) == 4
    # lengths of forces, each rounded to a newton: together they are the weight and what pulls sideways
    assert MASS * GRAVITY - 2.0 < sum(forces) < 1.2 * MASS * GRAVITY
    assert_inside(above)
    for limits, low, high in zip(
        (space.get_xlim(), space.get_ylim(), space.get_zlim()),
        (-0.5 * LENGTH, -0.5 * WIDTH, 0.0),
        (0.5 * LENGTH, 0.5 * WIDTH, 0.3),
        strict=True,
    ):
        assert limits[0] < low < high < limits[1]
        assert limits[1] - limits[0] == pytest.approx(1.44 * LENGTH)  # equal axes around the largest extent
    assert {text.get_text() for text in above.texts} >= {"0", "1", "2", "3"}
    assert drawn[0].get_suptitle() == "four feet\npossible: it stands"


def test_a_stance_that_falls_is_drawn_with_its_proof(drawn: list[Any], tmp_path: Path) -> None:
    asked = question(com=(0.5, 0.0, 0.3))  # a quarter of a metre in front of the front feet
    verdict = can_stand(asked.stance, asked.com, MASS)
    assert not verdict.feasible
    draw_check(asked, verdict, "impossible", tmp_path / "stance.png")
    space, above = drawn[0].axes
    assert "proof" in {text.get_text() for text in space.texts}
    assert not any(text.get_text().endswith(" N") for text in space.texts)
    assert drawn[0]._suptitle.get_color() == BAD
    assert_inside(above)
    marks = [points[0] for points in places(above) if len(points) == 1]
    assert any(np.allclose(mark, [0.5, 0.0]) for mark in marks)


def test_a_hand_on_a_wall_has_a_wall_and_the_feet_one_ground() -> None:
    feet = [PointContact((x, y, 0.0), mu=0.6) for x in (-0.1, 0.1) for y in (-0.1, 0.1)]
    hand = PointContact((0.5, 0.0, 1.0), (-1.0, 0.0, 0.0), 0.6)
    ground, wall = surfaces(Stance([*feet, hand]), 1.0)
    np.testing.assert_allclose(ground[:, 2], 0.0, atol=1e-12)
    assert np.ptp(ground[:, 0]) == pytest.approx(0.2 + 2 * AROUND)
    np.testing.assert_allclose(wall[:, 0], 0.5, atol=1e-12)
    stairs = Stance([PointContact((0.3 * k, 0.0, 0.1 * k), mu=0.6) for k in range(3)])
    assert len(surfaces(stairs, 1.0)) == 3
    soles = Stance([SoleContact([0.0, y, 0.0], Sole(0.2, 0.1, 0.6)) for y in (-0.2, 0.2)])
    (under,) = surfaces(soles, 1.0)
    assert np.ptp(under[:, 0]) == pytest.approx(0.2 + 2 * AROUND)  # corners count, not middles
    assert surfaces(Stance([]), 1.0) == []


def test_labels_are_behind_the_surface_and_forces_in_colours_of_their_friction() -> None:
    verdict = can_stand(question().stance, [0.05, 0.02, 0.3], MASS, external_wrench=[40.0, 0, 0, 0, 0, 0])
    axes = verdict.plot()
    labels = [text for text in axes.texts if " N, " in text.get_text()]
    assert len(labels) == 4
    for label in labels:
        assert label._z < 0.0  # cones are above the ground
    shares = [float(text.get_text().split(",")[1].strip(" %")) / 100 for text in labels]
    colours = [text.get_color() for text in labels]
    assert len({*colours}) > 1
    for share, colour in zip(shares, colours, strict=True):
        near = [friction_colour(share + step) for step in np.linspace(-0.005, 0.005, 41)]
        assert colour in near


def test_the_robot_stands_in_its_picture() -> None:
    robot = sf.load_robot("go2")
    q = sf.place(robot, sf.FlatTerrain())
    verdict = sf.can_stand(robot.stance(q), robot.com(q), robot.mass)
    alone, there = verdict.plot(), verdict.plot(robot=robot, q=q)
    assert len(there.lines) - len(alone.lines) == len(bones(robot, q))
    with pytest.raises(sf.ProblemError, match="q"):
        verdict.plot(robot=robot, q=q[:3])
