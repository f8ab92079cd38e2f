"""What every page is: controls and a mouse in, a drawing out."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Literal

import numpy as np

from surefoot.app.lab.controls import Values
from surefoot.app.lab.drawing import Drawing
from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError, shown

FURTHEST = 1e3
"""A mouse that points further away than this points nowhere [m]."""


@dataclass(frozen=True)
class Grip:
    """A shape that is taken with the mouse.

    Attributes
    ----------
    name
        Of the shape.
    phase
        "start", "update" while the mouse moves, "end"; "click" for one that did not move.
    start, point
        (3,) where the shape was taken, and where the mouse is now, in the plane through it that faces the
        viewer [m].
    eye
        (3,) where the viewer is [m].
    """

    name: str
    phase: Literal["start", "update", "end", "click"]
    start: FloatArray
    point: FloatArray
    eye: FloatArray

    def __post_init__(self) -> None:
        for what in (self.start, self.point, self.eye):
            if np.shape(what) != (3,) or not np.isfinite(what).all() or np.abs(what).max() > FURTHEST:
                raise ProblemError("the mouse points nowhere")

    def on_plane(self, origin: FloatArray, normal: FloatArray) -> FloatArray | None:
        """Return the (3,) place of a plane that the mouse points at [m]; None where it points past it.

        Parameters
        ----------
        origin, normal
            (3,) a point of the plane [m], and its normal.
        """
        ray = self.point - self.eye
        slant = float(ray @ normal)
        if abs(slant) < 1e-6 * max(float(np.linalg.norm(ray)), 1e-12):
            return None
        share = float((origin - self.eye) @ normal) / slant
        place = self.eye + share * ray
        return np.asarray(place) if share > 0.0 and np.abs(place).max() < FURTHEST else None


class Page(ABC):
    """One viewer's page. Its methods are called by one thread at a time.

    Attributes
    ----------
    title, about
        The heading, and what can be done here, in Markdown.
    values
        Its controls and what they say.
    live
        Whether it changes by itself: then it is drawn again and again.
    eye, look_at
        Where the viewer is at first, and what at [m].
    """

    title: str
    about: str
    values: Values
    live: bool = False
    eye: tuple[float, float, float] = (1.3, -1.3, 0.9)
    look_at: tuple[float, float, float] = (0.0, 0.0, 0.15)

    def change(self, name: str, raw: object) -> None:
        """Take a value of a control; raises `ProblemError` for one that it cannot have."""
        self.values.change(name, raw)

    def press(self, name: str) -> None:
        """Take a press of a button."""
        raise ProblemError(f"there is no button {shown(name)}")

    def grip(self, grip: Grip) -> None:
        """Take a move of the mouse with a shape."""
        raise ProblemError(f"{shown(grip.name)} cannot be moved")

    @abstractmethod
    def drawing(self) -> Drawing:
        """Return what there is to see now."""
