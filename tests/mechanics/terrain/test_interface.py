"""Every terrain of the table keeps the interface's word: gradients, frames, shapes, places to start from."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.base.errors import ProblemError
from surefoot.mechanics.terrain import (
    TERRAINS,
    Grid,
    GroundBox,
    HeightfieldTerrain,
    LevelsTerrain,
    Plane,
    Terrain,
    read_terrain,
    terrain_forms,
)
from surefoot.mechanics.terrain.frames import surface_frames

NUMBERS = {
    "flat": ["flat"],
    "slope": ["slope:20", "slope:-35"],
    "stairs": ["stairs:0.12,0.25", "stairs:-0.1,0.3"],
    "rough": ["rough:3,0.05"],
    "pit": ["pit:0.5,0.3,0.1", "pit:-60,0.3,0.1", "pit:70,1,0.2"],
}
TEXTS = [text for texts in NUMBERS.values() for text in texts]


class Bowl(Terrain):
    """A terrain that writes its height and nothing else."""

    def height(self, xy: object) -> np.ndarray:
        return 0.2 * np.sum(np.square(np.asarray(xy, dtype=float)), axis=-1)


def top_of(shape: object, places: np.ndarray) -> np.ndarray:
    """Return the height of a shape over (k, 2) places, -inf beside it."""
    if isinstance(shape, Plane):
        n = shape.rotation[:, 2]
        return shape.point[2] - (places - shape.point[:2]) @ n[:2] / n[2]
    if isinstance(shape, GroundBox):
        inside = (np.abs(places - shape.centre[:2]) < 0.5 * shape.size[:2]).all(axis=1)
        return np.where(inside, shape.centre[2] + 0.5 * shape.size[2], -np.inf)
    assert isinstance(shape, Grid)
    inside = ((places > shape.origin) & (places < shape.origin + shape.size)).all(axis=1)
    return np.where(inside, shape.height(places), -np.inf)


def test_every_name_of_the_table_is_tried() -> None:
    assert NUMBERS.keys() == TERRAINS.keys()
    assert {text.partition(":")[0] for text in TEXTS} == set(TERRAINS)


@pytest.mark.parametrize("text", TEXTS)
def test_gradient_normal_and_frame_agree(text: str) -> None:
    ground, rng = read_terrain(text), np.random.default_rng(0)
    places = rng.uniform(-2.0, 2.0, (60, 2))
    if isinstance(ground, LevelsTerrain):  # differences across a jump say nothing
        edges = ground.levels()[0]
        places = places[np.abs(places[:, :1] - edges).min(axis=1) > 1e-3]
    gradient, normals = ground.gradient(places), ground.normal(places)
    assert gradient == pytest.approx(Terrain.gradient(ground, places), abs=1e-8)
    assert normals == pytest.approx(Terrain.normal(ground, places), abs=1e-12)
    assert ground.gradient(places.reshape(-1, 1, 2)).shape == (len(places), 1, 2)
    assert ground.gradient([0.3, 0.1]).shape == (2,)
    frames = np.zeros((len(places), 3, 3))
    surface_frames(normals, frames)
    for place, frame, normal in zip(places, frames, normals, strict=True):
        assert ground.frame(place) == pytest.approx(frame, abs=1e-12)
        assert frame[:, 2] == pytest.approx(normal, abs=1e-15)
    if ground.planar:
        assert np.ptp(normals, axis=0) == pytest.approx(np.zeros(3), abs=1e-15)


@pytest.mark.parametrize("text", TEXTS)
def test_shapes_end_where_the_height_says(text: str) -> None:
    ground = read_terrain(text)
    places = np.random.default_rng(1).uniform([-4.0, -3.0], [4.0, 3.0], (300, 2))
    tops = np.max([top_of(shape, places) for shape in ground.shapes()], axis=0)
    assert tops == pytest.approx(ground.height(places), abs=1e-12)


@pytest.mark.parametrize("text", TEXTS)
def test_steps_and_places_to_start_from(text: str) -> None:
    ground = read_terrain(text)
    x = np.linspace(-80.0, 80.0, 200_001)
    rise = np.abs(np.diff(ground.height(np.column_stack([x, 0.0 * x])))).max()
    jumps = rise if isinstance(ground, LevelsTerrain) else 0.0
    assert ground.highest_step >= jumps - 1e-12
    start = ground.approach(0.9)
    around = start + np.random.default_rng(2).uniform(-0.89, 0.89, (200, 2))
    if isinstance(ground, LevelsTerrain) and start.any():
        assert np.ptp(ground.height(around[around[:, 0] < start[0] + 0.9])) == 0.0


def test_a_grid_is_sampled_within_its_ends() -> None:
    grid = Grid(lambda xy: xy[..., 0] + 10.0 * xy[..., 1], np.array([1.0, -2.0]), np.array([0.5, 1.0]))
    assert grid.counts(0.25).tolist() == [3, 5]
    assert grid.counts(0.2).tolist() == [4, 6]
    assert grid.counts(9.0).tolist() == [2, 2]
    heights = grid.heights(0.25)
    assert heights[0, 0] == pytest.approx(-19.0)
    assert heights[-1, -1] == pytest.approx(1.5 - 10.0)
    assert heights[1, 0] - heights[0, 0] == pytest.approx(0.25)


def test_height_alone_is_enough() -> None:
    ground, places = Bowl(), np.random.default_rng(3).normal(size=(20, 2))
    assert ground.gradient(places) == pytest.approx(0.4 * places, abs=1e-9)
    normals = ground.normal(places)
    assert np.linalg.norm(normals, axis=1) == pytest.approx(1.0)
    assert ground.gap([0.0, 0.0, 0.1]) == pytest.approx(0.1)
    assert ground.highest_step == 0.0
    with pytest.raises(ProblemError, match="the terrain has no shapes"):
        ground.shapes()


def test_gradient_of_a_heightfield_is_level_outside() -> None:
    ground = HeightfieldTerrain(np.random.default_rng(4).normal(size=(4, 5)), 0.2)
    assert (ground.gradient([[9.0, 0.0], [-9.0, 9.0]]) == 0.0).all()
    assert ground.highest_step == pytest.approx(np.ptp(ground.heights))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("moon", "terrain 'moon' is not one of: flat, slope:DEG"),
        ("flat:1", "is not one of"),
        ("slope", "is not one of"),
        ("slope:1,2", "is not one of"),
        ("stairs:0.1,", "terrain: '' is not a finite number"),
        ("slope:nan", "'nan' is not a finite number"),
        ("slope:90", "slope must be"),
        ("rough:-1,0.1", "seed must be a whole number"),
        ("rough:1,inf", "'inf' is not a finite number"),
        ("pit:0,0,0.1", "length must be positive"),
        ("pit:0,1,-0.1", "depth must be"),
        ("", "is not one of"),
        ("slope:", "is not one of"),
    ],
)
def test_wrong_texts_are_named(text: str, message: str) -> None:
    with pytest.raises(ProblemError, match=message):
        read_terrain(text)


def test_forms_name_every_terrain() -> None:
    assert [form.partition(":")[0] for form in terrain_forms().split(", ")] == list(TERRAINS)
