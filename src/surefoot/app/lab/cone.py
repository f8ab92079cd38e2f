"""*cone*: the round friction cone, the pyramids inside and around it, and a force to try them with."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from surefoot.app.lab import drawing as draw
from surefoot.app.lab.controls import Choice, Slider, Values
from surefoot.app.lab.drawing import Drawing, Shape
from surefoot.app.lab.figure import Figure
from surefoot.app.lab.geometry import CORNERS, SIDES, cone_surface, fan, polygon_surface
from surefoot.app.lab.html_text import heading, paragraph, table, text
from surefoot.app.lab.page import Grip, Page
from surefoot.app.viz import palette
from surefoot.base.arrays import FloatArray
from surefoot.contact import Fit, FrictionCone, FrictionPyramid

SCALE = 0.01
"""Metres that stand for a newton."""
HEIGHT = 100.0
"""Normal force that the cones are drawn up to, and that the section is cut at [N]."""
LARGEST = 150.0
"""Largest component of the force along the ground [N]."""
CIRCLE = 96
"""Sides of the circle in the section."""
FITS = ("inner", "outer", "both")
INNER, OUTER = draw.GOOD, draw.PUSH


@dataclass(frozen=True)
class ConeState:
    """A cone and a force.

    Attributes
    ----------
    mu
        Friction.
    facets
        Sides of the pyramids.
    phase
        By how much they are turned about the normal [deg].
    fit
        Which of them are shown: one of `FITS`.
    force
        (x, y, normal) [N].
    """

    mu: float = 0.6
    facets: int = 4
    phase: float = 0.0
    fit: str = "both"
    force: tuple[float, float, float] = (35.0, 20.0, 80.0)

    @property
    def fits(self) -> tuple[Fit, ...]:
        """The pyramids that are shown."""
        return ("inner", "outer") if self.fit == "both" else ("inner",) if self.fit == "inner" else ("outer",)


def corners_at(state: ConeState, fit: Fit, normal: float) -> FloatArray:
    """Return the (facets, 2) corners of a pyramid's section at a normal force [N]."""
    pyramid = FrictionCone(state.mu).polyhedral(state.facets, fit, math.radians(state.phase))
    rays = pyramid.rays
    return np.asarray(normal * rays[:, :2] / rays[:, 2:])


def cone_drawing(state: ConeState) -> Drawing:
    """Return the cones in space, their section, and what they say of the force."""
    cone, force = FrictionCone(state.mu), np.array(state.force)
    shapes: dict[str, Shape] = {"/ground": _ground()}
    surface = cone_surface(state.mu, SCALE * HEIGHT, np.eye(3))
    shapes["/cone"] = draw.Mesh(surface, fan(SIDES), draw.CONE, 0.3)
    for fit, colour in (("inner", INNER), ("outer", OUTER)):
        if fit in state.fits:
            rim = np.column_stack([corners_at(state, fit, HEIGHT), np.full(state.facets, HEIGHT)]) * SCALE
            edges = np.stack([np.zeros_like(rim), rim], axis=1)
            shapes[f"/{fit}/edges"] = draw.Lines(
                np.concatenate([edges, draw.outline(rim, colour).points]), colour, 3.0
            )
    nearest = cone.project(force)
    tip = SCALE * force
    colour = draw.GOOD if bool(cone.contains(force)) else draw.BAD
    shapes["/force"] = draw.arrows(np.zeros(3), tip, draw.FORCE, 0.012)
    shapes["/tip"] = draw.Ball(tip, 0.04, colour, True)
    if not bool(cone.contains(force)):
        shapes["/nearest"] = draw.Lines(SCALE * np.array([[force, nearest]]), draw.INK, 3.0)
        shapes["/projection"] = draw.Ball(SCALE * nearest, 0.025, draw.INK)
    return Drawing(shapes, cone_text(state), section(state))


def _ground() -> Shape:
    square = 0.9 * np.array([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]])
    return draw.Mesh(polygon_surface(square), fan(CORNERS), draw.GROUND)


def cone_text(state: ConeState) -> str:
    """Return what cone and pyramids say of the force, and how far they are apart."""
    force, cone = np.array(state.force), FrictionCone(state.mu)
    use, holds = float(cone.use(force)), bool(cone.contains(force))
    rows = [_row("round cone", cone, force, "exact")]
    for fit in state.fits:
        pyramid = cone.polyhedral(state.facets, fit, math.radians(state.phase))
        verb = "gives up" if fit == "inner" else "overshoots by"
        rows.append(_row(f"{fit} pyramid", pyramid, force, f"{verb} {100 * pyramid.fit_error.radial:.1f} %"))
    used = f"{100 * use:.0f} %" if math.isfinite(use) else "more than all"
    return text(
        heading("Sticks" if holds else "Slides or pulls", palette.GOOD if holds else palette.BAD),
        paragraph(f"Friction used: {used}. Half angle of the cone {math.degrees(math.atan(cone.mu)):.1f}°."),
        table(("", "holds the force", "margin [N]", "at worst"), rows),
    )


def _row(name: str, cone: FrictionCone | FrictionPyramid, force: FloatArray, error: str) -> tuple[str, ...]:
    holds = "yes" if bool(cone.contains(force)) else "no"
    return name, holds, f"{float(cone.margin(force)):.2f}", error


def section(state: ConeState) -> str:
    """Return the section at the force's own normal force as SVG."""
    normal = max(state.force[2], 1.0)
    reach = 1.15 * max(
        state.mu * normal / math.cos(math.pi / state.facets), abs(state.force[0]), abs(state.force[1]), 5.0
    )
    figure = Figure(np.array([-reach, -reach]), np.array([reach, reach]))
    for axis in (np.array([[-reach, 0.0], [reach, 0.0]]), np.array([[0.0, -reach], [0.0, reach]])):
        figure.line(axis, draw.GRID, 1.0)
    angle = np.linspace(0.0, 2.0 * math.pi, CIRCLE, endpoint=False)
    circle = state.mu * normal * np.column_stack([np.cos(angle), np.sin(angle)])
    figure.line(circle, draw.CONE, 2.0, closed=True, fill=0.12)
    for fit, colour in (("outer", OUTER), ("inner", INNER)):
        if fit in state.fits:
            figure.line(corners_at(state, fit, normal), colour, 2.0, closed=True)
    figure.line(np.array([[0.0, 0.0], state.force[:2]]), draw.FORCE, 2.0)
    figure.dot(state.force[:2], draw.FORCE)
    figure.words(8, 16, f"section at {normal:.0f} N; half width {reach:.0f} N", draw.INK)
    figure.words(8, figure.height - 8, "blue: circle", draw.CONE)
    figure.words(90, figure.height - 8, "green: inner", INNER)
    figure.words(175, figure.height - 8, "orange: outer", OUTER)
    return figure.svg()


class ConePage(Page):
    """The page of a friction cone.

    Parameters
    ----------
    state
        To begin with.
    """

    title = "Friction cones"
    about = "Drag the **tip of the force** with the mouse; it moves at its height."
    eye, look_at = (2.2, -2.2, 1.5), (0.0, 0.0, 0.4)

    def __init__(self, state: ConeState | None = None) -> None:
        s = state or ConeState()
        self.values = Values(
            [
                Slider("mu", "friction", 0.0, 1.5, 0.01, s.mu),
                Slider("facets", "sides of the pyramids", 3, 24, 1, s.facets),
                Slider("phase", "turned by [deg]", 0.0, 120.0, 1.0, s.phase),
                Choice("fit", "pyramids", FITS, s.fit),
                Slider("x", "x [N]", -LARGEST, LARGEST, 0.5, s.force[0], "Force"),
                Slider("y", "y [N]", -LARGEST, LARGEST, 0.5, s.force[1], "Force"),
                Slider("z", "normal [N]", -40.0, LARGEST, 0.5, s.force[2], "Force"),
            ]
        )

    @property
    def state(self) -> ConeState:
        """What the controls say."""
        v = self.values
        return ConeState(v["mu"], round(v["facets"]), v["phase"], v["fit"], (v["x"], v["y"], v["z"]))

    def grip(self, grip: Grip) -> None:
        """Move the tip of the force in the plane of its normal force."""
        if grip.name != "/tip":
            super().grip(grip)
        tip = SCALE * np.array(self.state.force)
        place = grip.on_plane(tip, np.array([0.0, 0.0, 1.0]))
        if place is not None:
            self.values.within("x", place[0] / SCALE)
            self.values.within("y", place[1] / SCALE)

    def drawing(self) -> Drawing:
        """Return what there is to see now."""
        return cone_drawing(self.state)
