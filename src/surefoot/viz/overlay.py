"""What is written over a film's pictures: a title, a clock, a legend, and arrows that nothing may hide."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.errors import needs

INK, PAPER = (34, 48, 60), (255, 255, 255)
TEXT_SHARE = 0.026
"""Height of the text as a share of the picture's."""


class Entry(NamedTuple):
    """Part of the legend: "arrow", "cone" or "line", its colour (red, green, blue, opacity), its words."""

    sign: str
    colour: tuple[float, ...]
    words: str


class Overlay:
    """Writes over pictures of one size.

    Parameters
    ----------
    width, height
        Of the pictures [pixels].
    title
        What stands at the bottom.
    legend
        What the drawn things are, in their order; it stands at the top.

    Raises
    ------
    MissingExtra
        If Pillow, which imageio brings, is not installed.
    """

    def __init__(self, width: int, height: int, title: str, legend: Sequence[Entry]) -> None:
        with needs("imageio", "sim"):
            from PIL import Image, ImageDraw, ImageFont
        self._image, self._draw = Image, ImageDraw
        self._size, self._title = (width, height), title
        self._text = max(round(TEXT_SHARE * height), 9)
        self._font = ImageFont.load_default(size=self._text)
        self._strip = self._legend(legend)

    def _legend(self, legend: Sequence[Entry]) -> Any:
        """Return the legend on a strip as wide as the pictures."""
        width, text = self._size[0], self._text
        strip = self._image.new("RGBA", (width, 2 * text), (*PAPER, 205))
        draw = self._draw.Draw(strip)
        lengths = [draw.textlength(entry.words, font=self._font) for entry in legend]
        room = max((width - sum(lengths) - 2.9 * text * len(legend)) / max(len(legend), 1), 0.0)
        at = float(text)
        for (sign, colour, words), length in zip(legend, lengths, strict=True):
            self._sign(draw, at, sign, colour)
            draw.text((at + 1.9 * text, text), words, fill=(*INK, 255), font=self._font, anchor="lm")
            at += length + 2.9 * text + min(room, 2.0 * text)
        return strip

    def _sign(self, draw: Any, at: float, sign: str, colour: tuple[float, ...]) -> None:
        """Draw what stands before a legend's words."""
        text = self._text
        shade = tuple(round(255 * c) for c in colour[:3])
        left, right, low, high = at, at + 1.4 * text, 1.5 * text, 0.5 * text
        if sign == "arrow":
            draw.polygon(_arrow((left, text), (right, text), 0.22 * text), fill=shade)
        elif sign == "cone":
            middle = 0.5 * (left + right)
            draw.line([(left, high), (middle, low), (right, high)], fill=shade, width=2)
            draw.ellipse([left, high - 0.2 * text, right, high + 0.2 * text], outline=shade, width=2)
        else:
            draw.line([(left, text), (right, text)], fill=shade, width=max(text // 4, 2))

    def over(
        self, picture: Any, time: float, arrows: Sequence[tuple[FloatArray, FloatArray]], colour: Any
    ) -> Any:
        """Return a (height, width, 3) picture with title, legend, clock and flat arrows over it.

        Parameters
        ----------
        picture
            (height, width, 3) pixels.
        time
            For the clock [s].
        arrows
            Start and end of each arrow [pixels].
        colour
            Of the arrows.
        """
        image = self._image.fromarray(picture)
        draw = self._draw.Draw(image)
        shade = tuple(round(255 * c) for c in colour[:3])
        for start, end in arrows:
            draw.polygon(_arrow(start, end, 0.25 * self._text), fill=shade, outline=PAPER)
        image.paste(self._strip, (0, 0), self._strip)
        corner = (self._size[0] - self._text, self._size[1] - self._text)
        draw.text((self._text, corner[1]), self._title, fill=INK, font=self._font, anchor="lm")
        draw.text(corner, f"{time:.2f} s", fill=INK, font=self._font, anchor="rm")
        return np.asarray(image)


def _arrow(start: Any, end: Any, width: float) -> list[tuple[float, float]]:
    """Return the outline of an arrow [pixels]; its shaft is twice the width, its head three times that."""
    (x, y), (u, v) = (float(start[0]), float(start[1])), (float(end[0]), float(end[1]))
    length = math.hypot(u - x, v - y) or 1.0
    a, b = (u - x) / length, (v - y) / length
    head = min(4.0 * width, 0.7 * length)
    neck = (u - head * a, v - head * b)
    sides = ((x, y, width), (*neck, width), (*neck, 2.4 * width))
    left = [(p - w * b, q + w * a) for p, q, w in sides]
    right = [(p + w * b, q - w * a) for p, q, w in reversed(sides)]
    return [*left, (u, v), *right]
