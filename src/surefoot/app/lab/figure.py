"""Plane pictures as SVG: they are sent as text, and drawn by any browser without a library."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from xml.sax.saxutils import escape

import numpy as np

from surefoot.app.lab.drawing import BAD, GRID, INK, Colour
from surefoot.app.viz import palette
from surefoot.base.arrays import FloatArray

SIZE = 340
"""Width of a figure [pixels]."""
WIDE = 7.0
"""Of a letter [pixels], so that names beside each other do not overlap."""
STRIP_HEIGHT = 130
"""Height of a strip of curves [pixels]."""
CURVES: tuple[Colour, ...] = tuple(palette.rgb(colour) for colour in palette.LINES[:6])


def css(colour: Colour) -> str:
    """Return a colour as style sheets write it."""
    return "#{:02x}{:02x}{:02x}".format(*colour)


@dataclass
class Figure:
    """A picture of a rectangle of the plane.

    Attributes
    ----------
    low, high
        (2,) its corners, in the unit of what is drawn.
    width, height
        [pixels].
    """

    low: FloatArray
    high: FloatArray
    width: int = SIZE
    height: int = SIZE
    parts: list[str] = field(default_factory=list)

    def place(self, points: FloatArray) -> FloatArray:
        """Return (n, 2) points as pixels, y downwards."""
        share = (np.asarray(points, dtype=np.float64) - self.low) / (self.high - self.low)
        return np.asarray(np.column_stack([share[:, 0] * self.width, (1.0 - share[:, 1]) * self.height]))

    def line(
        self, points: FloatArray, colour: Colour, width: float = 1.5, closed: bool = False, fill: float = 0.0
    ) -> None:
        """Draw a line through (n, 2) points; `fill` is the opacity of what it encloses."""
        text = " ".join(f"{x:.1f},{y:.1f}" for x, y in self.place(points))
        kind = "polygon" if closed else "polyline"
        shade = f'fill="{css(colour)}" fill-opacity="{fill:g}"' if fill > 0.0 else 'fill="none"'
        self.parts.append(
            f'<{kind} points="{text}" stroke="{css(colour)}" stroke-width="{width:g}" {shade}/>'
        )

    def dot(self, point: Sequence[float] | FloatArray, colour: Colour) -> None:
        """Draw a dot at a (2,) point."""
        ((x, y),) = self.place(np.array([point]))
        self.parts.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4" fill="{css(colour)}"/>')

    def words(self, x: float, y: float, text: str, colour: Colour, size: int = 11) -> None:
        """Write at a place in pixels from the upper left corner."""
        self.parts.append(
            f'<text x="{x:g}" y="{y:g}" font-size="{size}" fill="{css(colour)}">{escape(text)}</text>'
        )

    def svg(self) -> str:
        """Return the picture."""
        head = (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {self.width} {self.height}" '
            'width="100%" style="max-height: 180px" font-family="sans-serif">'
        )
        return head + "".join(self.parts) + "</svg>"


def strip(
    times: FloatArray,
    rows: FloatArray,
    names: Sequence[str],
    least: float,
    cursor: float | None = None,
    marks: Sequence[tuple[float, float]] = (),
) -> str:
    """Return curves over time as SVG.

    Parameters
    ----------
    times, rows
        (k,) [s] and (k, n) [N].
    names
        Of the n curves.
    least
        The axis begins at zero and ends here at least [N]; nothing is cut off.
    cursor
        A time that is marked with a line [s].
    marks
        Spans (start, end) that are shaded [s].
    """
    if len(times) < 2:
        return ""
    top = max(least, float(rows.max(initial=0.0)))
    low, high = float(times[0]), max(float(times[-1]), float(times[0]) + 1e-6)
    figure = Figure(np.array([low, -0.04 * top]), np.array([high, 1.25 * top]), SIZE, STRIP_HEIGHT)
    for start, end in marks:
        wide = max(end, start + (high - low) / SIZE)
        box = np.array([[start, 0.0], [wide, 0.0], [wide, top], [start, top]])
        figure.line(box, BAD, 0.5, closed=True, fill=0.25)
    figure.line(np.array([[low, 0.0], [high, 0.0]]), GRID, 1.0)
    figure.line(np.array([[low, top], [high, top]]), GRID, 1.0)
    room = (SIZE - 16) / max(min(len(names), len(CURVES)), 1)
    for k, name in enumerate(names):
        colour = CURVES[k % len(CURVES)]
        figure.line(np.column_stack([times, rows[:, k]]), colour, 1.3)
        if k < len(CURVES):
            figure.words(8 + k * room, 12, name[: int(room / WIDE)], colour)
    if cursor is not None:
        figure.line(np.array([[cursor, 0.0], [cursor, top]]), INK, 1.5)
    figure.words(8, STRIP_HEIGHT - 2, f"{low:.2f} s", INK, 10)
    figure.words(SIZE - 60, STRIP_HEIGHT - 2, f"{high:.2f} s", INK, 10)
    figure.words(SIZE - 60, 32, f"{top:.0f} N", INK, 10)
    return figure.svg()
