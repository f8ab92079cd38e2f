"""Colours, type and line weights of everything that is drawn: plots, films, the lab and reports.

Colours that stand side by side are told apart by readers who see no red, no green or no blue as well:
`tests/app/viz/test_palette.py` looks at them with the eyes of each and measures the distances in CIELAB.
"""

from __future__ import annotations

INK, MUTED, PAPER = "#22303c", "#8a99a6", "#ffffff"
"""Text, what is beside it, and what is behind it."""
NOTE, PANEL = "#5c6b78", "#f1f3f5"
"""Small text, and what stands behind code."""
GRID = "#e3e7ea"
"""Lines behind curves."""
GOOD, WARN, BAD = "#0f7f5f", "#e08e0b", "#b3001b"
"""Verdicts and shares of friction: possible, near the limit, impossible or at it."""
FORCE, CONE, PUSH, MOTION = "#e2583e", "#1558a6", "#e6990d", "#4a1a5e"
"""In space: forces of the ground, friction cones, pushes, and a motion that is a proof."""
GROUND, GROUND_LINE, BODY = "#e8e4da", "#c4beb0", "#545e69"
"""In space: the ground, lines on it, and a robot."""
LINES = ("#0d4f9e", "#b8402c", "#57a388", "#d99a00", "#17b8f0", "#5d3a6b", "#4c1a00", "#8a83a9")
"""Curves and feet, in their order: the first four differ most."""

TEXT_FAMILY = "system-ui, sans-serif"
"""Of pages; plots have Matplotlib's DejaVu Sans, which comes with it."""
TEXT_SIZE, TITLE_SIZE, SMALL_SIZE = 9.0, 10.0, 7.5
"""Of plots, in points."""
CURVE_WIDTH, OUTLINE_WIDTH, HAIR_WIDTH = 1.3, 1.6, 0.6
"""Of plots, in points: curves, outlines of what is looked at, and what is behind."""


def rgb(colour: str) -> tuple[int, int, int]:
    """Return red, green and blue of a colour, from 0 to 255.

    Examples
    --------
    >>> rgb("#0f7f5f")
    (15, 127, 95)
    """
    red, green, blue = bytes.fromhex(colour.removeprefix("#"))
    return red, green, blue


def rgba(colour: str, opacity: float = 1.0) -> tuple[float, float, float, float]:
    """Return red, green, blue and opacity of a colour, from 0 to 1."""
    red, green, blue = (round(part / 255.0, 4) for part in rgb(colour))
    return red, green, blue, opacity


def blend(first: str, second: str, share: float) -> str:
    """Return the colour so far on the way from one to another; beyond the ends it stays there.

    Examples
    --------
    >>> blend("#000000", "#ffffff", 0.5)
    '#808080'
    """
    part = min(max(share, 0.0), 1.0)
    mixed = (round((1.0 - part) * a + part * b) for a, b in zip(rgb(first), rgb(second), strict=True))
    return "#{:02x}{:02x}{:02x}".format(*mixed)
