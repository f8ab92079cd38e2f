"""Films: what the legend tells, where things are in a picture, edges of the ground."""

from __future__ import annotations

import numpy as np
import pytest

import surefoot as sf
from surefoot.app.viz.film import FilmScene, Overlay
from surefoot.app.viz.video import CONE_COLOUR, PUSH_COLOUR, edge_lines

STEPS = 30


def made(pushed: bool = False) -> sf.Log:
    """Return a log of a robot that stands on one point, and may be pushed."""
    forces = np.tile([[3.0, 0.0, 100.0]], (STEPS, 1, 1))
    push = np.zeros((STEPS, 3))
    push[5:] = [30.0 * pushed, 0.0, 0.0]
    q = np.zeros((STEPS, 19))
    channels = {
        "time": 0.01 * np.arange(STEPS), "forces": forces, "forces_commanded": forces, "push": push, "q": q,
        "contact_positions": np.zeros((STEPS, 1, 3)), "mu": np.full(STEPS, 0.5),
    }  # fmt: skip
    return sf.Log(channels, {"dt": 0.01})


def test_the_legend_tells_only_what_happens() -> None:
    flat = sf.FlatTerrain()
    plain = [words for _, words in FilmScene(made(), flat, 0.01).legend()]
    assert plain == ["force of the ground", "friction cone, up to its normal part"]
    all_of_it = [words for _, words in FilmScene(made(True), flat, 0.01).legend()]
    assert all_of_it == [*plain, "push, up to 30 N"]


def test_a_push_is_an_arrow_from_the_base() -> None:
    (arrow,) = [
        a for a in FilmScene(made(pushed=True), sf.FlatTerrain(), 0.01).arrows(5) if a[2] == PUSH_COLOUR
    ]
    assert arrow[1].tolist() == pytest.approx([0.6, 0.0, 0.0])


def test_the_cone_is_as_high_as_the_normal_force() -> None:
    rim = [
        start
        for start, _, colour in FilmScene(made(), sf.FlatTerrain(), 0.002).lines(0)
        if colour == CONE_COLOUR
    ]
    highest = max(float(start[2]) for start in rim)
    assert highest == pytest.approx(0.2)
    assert max(float(np.hypot(*start[:2])) for start in rim) == pytest.approx(0.1)


def test_steps_have_edges_and_planes_have_none() -> None:
    assert edge_lines(sf.FlatTerrain()) == []
    heights = {round(float(start[2]), 6) for start, _, _ in edge_lines(sf.StairsTerrain(0.1, 0.3))}
    assert {0.1, 0.2} <= heights


@pytest.mark.parametrize("width", [400, 640, 2000])
def test_the_legend_stands_whole_on_its_strip(width: int) -> None:
    """Entries are apart by no more than two letters, and none is lost where there is little room."""
    colours = [(0.9, 0.1, 0.1), (0.1, 0.7, 0.1), (0.1, 0.1, 0.9)]
    words = ["force of the ground", "friction cone", "push, up to 30 N"]
    overlay = Overlay(width, 480, "", list(zip(colours, words, strict=True)))
    text, strip = overlay._text, np.asarray(overlay._strip)
    boxes = [
        (abs(strip[:, :, :3] - np.round(255.0 * np.array(c))) <= 1.0).all(axis=2).any(axis=0) for c in colours
    ]
    starts = [int(np.flatnonzero(box)[0]) for box in boxes]
    ends = [
        start + 1.9 * text + overlay._font.getlength(said) for start, said in zip(starts, words, strict=True)
    ]
    assert starts[0] == text
    assert ends[-1] <= width
    gaps = np.subtract(starts[1:], ends[:-1])
    assert (gaps >= 0.9 * text).all()
    assert (gaps <= 3.1 * text).all()
