"""What a page draws, as values: shapes by name, a text and a figure; nothing here knows a browser.

A shape that keeps its kind from one drawing to the next is changed in place, one that is missing is hidden.
Colours are (red, green, blue) from 0 to 255.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from surefoot.app.viz import palette
from surefoot.base.arrays import FloatArray, IntArray

Colour: TypeAlias = tuple[int, int, int]

FORCE, CONE, PUSH, MOTION, BODY = map(
    palette.rgb, (palette.FORCE, palette.CONE, palette.PUSH, palette.MOTION, palette.BODY)
)
GROUND, GRID, INK = map(palette.rgb, (palette.GROUND, palette.GROUND_LINE, palette.INK))
GOOD, WARN, BAD = map(palette.rgb, (palette.GOOD, palette.WARN, palette.BAD))

UPRIGHT = (1.0, 0.0, 0.0, 0.0)
"""The quaternion (w, x, y, z) that turns nothing."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """A surface of triangles.

    Attributes
    ----------
    vertices, faces
        (n, 3) [m] and (m, 3) indices. Arrays that are the very same objects as before are not sent again.
    colour, opacity
        What it looks like; from 0 to 1 the opacity.
    position, wxyz
        Where its own axes are in the world: [m] and a quaternion (w, x, y, z).
    held
        Whether it can be taken with the mouse.
    """

    vertices: FloatArray
    faces: IntArray
    colour: Colour
    opacity: float = 1.0
    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    wxyz: tuple[float, float, float, float] = UPRIGHT
    held: bool = False


@dataclass(frozen=True, eq=False)
class Lines:
    """Straight lines: (n, 2, 3) starts and ends [m], `width` in pixels."""

    points: FloatArray
    colour: Colour
    width: float = 2.0


@dataclass(frozen=True, eq=False)
class Arrows:
    """Arrows: (n, 2, 3) tails and tips [m] from `position` [m], the shaft's radius `width` [m].

    A browser moves positions at once, but shows new points a picture or more later: what travels with a
    moving shape has its place in `position`.
    """

    points: FloatArray
    colour: Colour
    width: float = 0.008
    position: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class Ball:
    """A ball at a (3,) position [m], of a radius [m]; `held` if it can be taken with the mouse."""

    position: FloatArray
    radius: float
    colour: Colour
    held: bool = False


@dataclass(frozen=True, eq=False)
class Label:
    """A text at a (3,) position [m]."""

    position: FloatArray
    text: str


Shape: TypeAlias = Mesh | Lines | Arrows | Ball | Label


@dataclass(frozen=True, eq=False)
class Drawing:
    """What a page shows at one moment.

    Attributes
    ----------
    shapes
        By name.
    text
        HTML beside the picture: the verdict and its figures, see `surefoot.app.lab.html_text`.
    figure
        A plane picture as SVG; empty for none.
    """

    shapes: Mapping[str, Shape]
    text: str = ""
    figure: str = ""


def arrows(starts: FloatArray, vectors: FloatArray, colour: Colour, width: float = 0.008) -> Arrows:
    """Return arrows from (n, 3) starts along (n, 3) vectors [m]; those of no length are left out."""
    starts, vectors = np.atleast_2d(starts), np.atleast_2d(vectors)
    long = np.linalg.norm(vectors, axis=1) > 1e-6
    return Arrows(np.stack([starts, starts + vectors], axis=1)[long], colour, width)


def arrow_at(place: FloatArray, vector: FloatArray, colour: Colour, width: float = 0.008) -> Arrows:
    """Return one arrow that travels with a (3,) place [m], its tail there, along a (3,) vector [m]."""
    x, y, z = np.asarray(place, dtype=np.float64).tolist()
    return Arrows(np.stack([np.zeros(3), np.asarray(vector)])[None], colour, width, (x, y, z))


def outline(corners: FloatArray, colour: Colour, width: float = 2.0) -> Lines:
    """Return the closed outline of (k, 3) corners [m]."""
    if len(corners) < 2:
        return Lines(np.zeros((0, 2, 3)), colour, width)
    return Lines(np.stack([corners, np.roll(corners, -1, axis=0)], axis=1), colour, width)
