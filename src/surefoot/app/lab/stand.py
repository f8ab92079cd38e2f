"""*stand*: can it stand here? The answer follows centre of mass, feet, ground and friction."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from surefoot.app.lab import drawing as draw
from surefoot.app.lab.contacts import force_rows
from surefoot.app.lab.controls import Button, Checkbox, Choice, Slider, Values
from surefoot.app.lab.drawing import Drawing, Shape
from surefoot.app.lab.geometry import CORNERS, SIDES, cone_surface, fan, polygon_surface
from surefoot.app.lab.html_text import heading, paragraph, text
from surefoot.app.lab.page import Grip, Page
from surefoot.app.lab.stand_forces import pressures, sole_lines
from surefoot.app.viz import palette
from surefoot.base.arrays import BoolArray, FloatArray, IntArray
from surefoot.base.errors import ProblemError
from surefoot.base.spatial import GRAVITY, rotation_from_normal
from surefoot.contact import Fit, Sole
from surefoot.mechanics import Robot, Verdict, can_stand, friction_needed
from surefoot.mechanics.stance import Contact, PointContact, SoleContact, Stance
from surefoot.mechanics.statics.com_region import com_region
from surefoot.mechanics.statics.region import Region

WEIGHT_LENGTH = 0.3
"""Length of the arrow of a force of m g [m]."""
CONE_HEIGHT = 0.09
"""Height of the cones that are drawn [m]."""
LIFT = 0.003
"""How far above the ground the region is drawn [m]."""
TOLERANCE = 1e-3
"""Largest gap between the region that is drawn and the true one [m]."""
FURTHEST = 0.8
"""How far feet and centre of mass may be from the middle [m]."""
MOTION_LENGTH = 0.15
"""Length of the fastest arrow of the motion that no force opposes [m]."""
HIPS = 0.6
"""How far apart the hips are drawn, as a share of the feet."""
CONES: dict[str, tuple[int | None, Fit]] = {
    "exact": (None, "inner"), "4 sides inside": (4, "inner"), "8 sides inside": (8, "inner"),
    "4 sides around": (4, "outer"), "8 sides around": (8, "outer"),
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class StandState:
    """A stance on a tilted plane through the origin, and who stands.

    Attributes
    ----------
    names
        Of the feet.
    feet
        (n, 2) their places, world axes [m]; the plane says their heights.
    on
        (n,) which of them touch.
    mu
        (n,) friction under each.
    com
        (3,) centre of mass, world axes [m].
    mass
        [kg].
    slope, direction
        Angle of the plane [deg], and in which direction from +x it rises [deg].
    cones
        A name of `CONES`.
    soles
        (n,) the sole of each foot about its place, along the ground's axes; None for a point, and () for
        points only.
    """

    names: tuple[str, ...]
    feet: FloatArray
    on: BoolArray
    mu: FloatArray
    com: FloatArray
    mass: float
    slope: float = 0.0
    direction: float = 0.0
    cones: str = "exact"
    soles: tuple[Sole | None, ...] = ()

    @property
    def normal(self) -> FloatArray:
        """(3,) unit normal of the plane."""
        angle, way = math.radians(self.slope), math.radians(self.direction)
        return np.array([-math.sin(angle) * math.cos(way), -math.sin(angle) * math.sin(way), math.cos(angle)])

    def on_ground(self, places: FloatArray) -> FloatArray:
        """Return (k, 2) places [m] with the ground's heights: (k, 3) [m]."""
        n = self.normal
        return np.column_stack([places, -(places @ n[:2]) / n[2]])

    def stance(self) -> Stance:
        """Return the contacts of the feet that touch."""
        places, n = self.on_ground(self.feet), self.normal
        contacts: list[Contact] = []
        for k in np.flatnonzero(self.on).tolist():
            sole, mu, name = self.sole(k), float(self.mu[k]), self.names[k]
            contacts.append(
                PointContact(places[k], n, mu, name)
                if sole is None
                else SoleContact(places[k], sole.with_friction(mu), n, name)
            )
        return Stance(contacts)

    def sole(self, foot: int) -> Sole | None:
        """Return the sole of a foot, None for a point."""
        return self.soles[foot] if self.soles else None


@dataclass(frozen=True, eq=False)
class StandAnswer:
    """What the statics say of a state: verdict, region, forces, friction needed.

    `forces` are (k, 3) in contact frames [N]; `pressed` (k, 3) is where they press [m], a sole's centre of
    pressure.
    """

    verdict: Verdict
    region: Region
    forces: FloatArray | None
    pressed: FloatArray
    needed: float


def answer_of(state: StandState) -> StandAnswer:
    """Return what the statics say of a state."""
    stance, (facets, fit) = state.stance(), CONES[state.cones]
    verdict = can_stand(stance, state.com, state.mass, facets=facets, fit=fit)
    region = com_region(stance, state.mass, TOLERANCE, facets=facets, fit=fit)
    forces, pressed = pressures(stance, verdict.stacked)
    return StandAnswer(verdict, region, forces, pressed, friction_needed(stance, state.com, state.mass))


def stand_drawing(state: StandState) -> Drawing:
    """Return cones, forces, region and verdict of a state."""
    answer = answer_of(state)
    shapes: dict[str, Shape] = {**_ground(state), **_region(state, answer), **_body(state, answer)}
    normal = state.normal
    frame, places = rotation_from_normal(normal), state.on_ground(state.feet)
    for k, (place, above, on, mu, name) in enumerate(
        zip(places, places + 0.06 * normal, state.on, state.mu, state.names, strict=True)
    ):
        shapes[f"/names/{name}"] = draw.Label(above, name)
        shapes[f"/feet/{name}"] = draw.Ball(
            place if on else above, 0.018, draw.CONE if on else draw.BODY, True
        )
        sole = state.sole(k)
        if on and sole is not None:
            rim = np.column_stack([sole.corners, np.full(len(sole.corners), LIFT)]) @ frame.T
            shapes[f"/soles/{name}"] = draw.outline(place + rim, draw.CONE, 3.0)
        elif on:
            surface, (x, y, z) = cone_surface(float(mu), CONE_HEIGHT, frame), place.tolist()
            shapes[f"/cones/{name}"] = draw.Mesh(surface, fan(SIDES), draw.CONE, 0.3, (x, y, z))
    if answer.forces is not None and len(answer.forces):
        vectors = answer.forces @ frame.T * (WEIGHT_LENGTH / (state.mass * GRAVITY)) * state.on.sum() ** 0.5
        shapes["/forces"] = draw.arrows(answer.pressed, vectors, draw.FORCE)
    if answer.verdict.certificate is not None:
        shapes["/motion"] = _motion(state, answer.verdict.certificate, places[state.on])
    return Drawing(shapes, verdict_text(state, answer))


def _ground(state: StandState) -> dict[str, Shape]:
    """Return the plane, with a line every ten centimetres."""
    square = FURTHEST * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    ends = np.array(
        [(a, b) for s in np.linspace(-1.0, 1.0, 17) for a, b in ((s, -1.0), (s, 1.0), (-1.0, s), (1.0, s))]
    )
    grid = state.on_ground(FURTHEST * ends).reshape(-1, 2, 3) + np.array([0.0, 0.0, 0.3 * LIFT])
    return {
        "/ground": draw.Mesh(polygon_surface(state.on_ground(square)), fan(CORNERS), draw.GROUND),
        "/grid": draw.Lines(grid, draw.GRID, 1.0),
    }


def _region(state: StandState, answer: StandAnswer) -> dict[str, Shape]:
    """Return where the centre of mass may be, on the ground below it."""
    corners = answer.region.inner
    if len(corners) == 0:
        return {}
    floor = state.on_ground(corners) + np.array([0.0, 0.0, LIFT])
    colour = draw.GOOD if answer.verdict.feasible else draw.BAD
    return {
        "/region/area": draw.Mesh(polygon_surface(floor), fan(CORNERS), colour, 0.35),
        "/region/border": draw.outline(floor, colour, 3.0),
    }


def _body(state: StandState, answer: StandAnswer) -> dict[str, Shape]:
    """Return the centre of mass, its weight, the plumb line and a stick for every leg."""
    com, below = state.com, state.on_ground(state.com[None, :2])[0]
    colour = draw.GOOD if answer.verdict.feasible else draw.BAD
    places = state.on_ground(state.feet)
    hips = com + np.column_stack([HIPS * (state.feet - state.feet.mean(axis=0)), np.zeros(len(places))])
    trunk = draw.outline(hips[around(hips[:, :2])], draw.BODY).points
    legs = np.stack([hips, places], axis=1)[state.on]
    down = np.array([[0.0, 0.0, -0.5 * WEIGHT_LENGTH]])
    return {
        "/com": draw.Ball(com, 0.03, colour, True),
        "/weight": draw.arrows(com[None], down, draw.INK, 0.006),
        "/plumb/line": draw.Lines(np.array([[com, below]]), colour, 2.0),
        "/plumb/foot": draw.Ball(below, 0.012, colour),
        "/body": draw.Lines(np.concatenate([trunk, legs]), draw.BODY, 4.0),
    }


def around(places: FloatArray) -> IntArray:
    """Return the order (n,) in which (n, 2) places stand around their middle."""
    middle = places - places.mean(axis=0)
    return np.asarray(np.argsort(np.arctan2(middle[:, 1], middle[:, 0])))


def _motion(state: StandState, certificate: FloatArray, places: FloatArray) -> Shape:
    """Return the proof as a motion: gravity drives it, and no force within the cones can oppose it.

    The certificate y has y . (grasp_map f) >= 0 for all forces f of the cones and y . load < 0. As a velocity
    [linear; angular] of the robot about its centre of mass it is one along which every contact force does
    work that is not negative, and the weight, minus the load, positive work.
    """
    linear, angular = certificate[:3], certificate[3:]
    points = np.vstack([state.com, places])
    speeds = linear + np.cross(angular, points - state.com)
    fastest = float(np.linalg.norm(speeds, axis=1).max())
    return draw.arrows(points, MOTION_LENGTH / max(fastest, 1e-12) * speeds, draw.MOTION, 0.005)


def verdict_text(state: StandState, answer: StandAnswer) -> str:
    """Return the verdict, the margin or the certificate, and the forces as HTML."""
    verdict = answer.verdict
    if verdict.feasible:
        parts = [
            heading("It can stand", palette.GOOD),
            paragraph(f"Margin {verdict.margin:.2f} N: so far is every force from its cone's border."),
        ]
    elif verdict.certificate is not None:
        y = ", ".join(f"{value:.3g}" for value in verdict.certificate.round(4) + 0.0)
        parts = [
            heading("It cannot stand", palette.BAD),
            paragraph(
                "Proof: the motion of the violet arrows. The weight drives it, no force within the cones "
                "opposes it."
            ),
            paragraph(f"y = [{y}], y . load = {float(verdict.certificate @ verdict.load):.3g} < 0"),
        ]
    else:
        parts = [heading("Undecided", palette.NOTE), paragraph("Rounding leaves neither forces nor a proof.")]
    needed = f"{answer.needed:.3f}" if math.isfinite(answer.needed) else "no friction is enough"
    parts.append(paragraph(f"Friction needed, the same under every foot: {needed}."))
    if not answer.region.empty:
        distance = answer.region.distance(state.com)
        side = "inside" if distance <= 0.0 else "outside"
        area = f"region {1e4 * answer.region.area:.0f} cm²"
        parts.append(
            paragraph(f"Centre of mass {1e3 * abs(distance):.0f} mm {side} the region's border ({area}).")
        )
    if answer.forces is not None and len(answer.forces):
        contacts = verdict.stance.contacts
        mu = np.array([contact.mu for contact in contacts])
        parts.append(force_rows([contact.name for contact in contacts], answer.forces, mu))
        parts.extend(sole_lines(verdict))
    return text(*parts)


def start_state(robot: Robot) -> StandState:
    """Return a robot's nominal stance on flat ground.

    Raises
    ------
    ProblemError
        For a robot with fewer than two feet.
    """
    if len(robot.feet) < 2:
        raise ProblemError(f"the page needs two feet or more; {robot.name} has {len(robot.feet)}")
    q = robot.nominal
    stance, com = robot.stance(q), robot.com(q)
    places = np.array([contact.position for contact in stance.contacts])
    com = (com - [*places[:, :2].mean(axis=0), float(places[:, 2].mean())]).round(3) + 0.0
    feet, n = places[:, :2] - places[:, :2].mean(axis=0), len(places)
    soles = tuple(c.sole if isinstance(c, SoleContact) else None for c in stance.contacts)
    return StandState(
        robot.foot_names, feet, np.ones(n, dtype=bool), np.full(n, 0.6), com, robot.mass, soles=soles
    )


class StandPage(Page):
    """The page of a stance.

    Parameters
    ----------
    state
        To begin with.
    robot_shapes
        The robot's shapes on a stance, none where it does not reach; None for sticks alone.
    """

    title = "Can it stand here?"
    about = (
        "Drag the **ball of the centre of mass**, or a **foot**, with the mouse. The green area is where the "
        "centre of mass may be."
    )

    def __init__(
        self, state: StandState, robot_shapes: Callable[[StandState], Mapping[str, Shape]] | None = None
    ) -> None:
        self.start, self._robot_shapes = state, robot_shapes
        self._begin()

    def _begin(self) -> None:
        self._feet = self.start.feet.copy()
        self.values = Values(_controls(self.start))

    @property
    def state(self) -> StandState:
        """What the controls say."""
        v, names = self.values, self.start.names
        return replace(
            self.start,
            feet=self._feet.copy(),
            on=np.array([v[f"on {name}"] for name in names]),
            mu=np.array([v[f"mu {name}"] for name in names]),
            com=np.array([v["x"], v["y"], v["z"]]),
            slope=v["slope"], direction=v["direction"], cones=v["cones"],
        )  # fmt: skip

    def change(self, name: str, raw: object) -> None:
        """Take a value; the friction of all feet is that of each."""
        super().change(name, raw)
        if name == "mu":
            for foot in self.start.names:
                self.values.change(f"mu {foot}", self.values["mu"])

    def press(self, name: str) -> None:
        """Begin anew."""
        if name != "reset":
            super().press(name)
        self._begin()

    def grip(self, grip: Grip) -> None:
        """Move the centre of mass at its height, or a foot on the ground."""
        state = self.state
        if grip.name == "/com":
            place = grip.on_plane(state.com, np.array([0.0, 0.0, 1.0]))
            if place is not None:
                self.values.within("x", place[0])
                self.values.within("y", place[1])
            return
        name = grip.name.removeprefix("/feet/")
        if name not in state.names:
            super().grip(grip)
        place = grip.on_plane(np.zeros(3), state.normal)
        if place is not None:
            self._feet[state.names.index(name)] = np.clip(place[:2], -FURTHEST, FURTHEST)

    def drawing(self) -> Drawing:
        """Return what there is to see now."""
        state = self.state
        drawing = stand_drawing(state)
        robot = {} if self._robot_shapes is None else self._robot_shapes(state)
        if not robot:
            return drawing
        shapes = {name: shape for name, shape in drawing.shapes.items() if name != "/body"} | dict(robot)
        return replace(drawing, shapes=shapes)


def _controls(state: StandState) -> list[Any]:
    """Return the controls of a stance."""
    x, y, z = state.com.tolist()
    common = [
        Slider("mu", "friction", 0.0, 1.5, 0.01, float(state.mu[0])),
        Slider("slope", "slope [deg]", 0.0, 60.0, 0.5, state.slope),
        Slider("direction", "rises towards [deg]", -180.0, 180.0, 1.0, state.direction, hint="0 is along +x"),
        Slider("x", "x [m]", -FURTHEST, FURTHEST, 0.001, x, "Centre of mass"),
        Slider("y", "y [m]", -FURTHEST, FURTHEST, 0.001, y, "Centre of mass"),
        Slider("z", "z [m]", 0.02, round(2.0 * max(z, 0.2), 1), 0.001, z, "Centre of mass"),
        Choice("cones", "cones", tuple(CONES), state.cones, "What is asked"),
    ]
    feet: list[Any] = []
    for name, on, mu in zip(state.names, state.on, state.mu, strict=True):
        feet.append(Checkbox(f"on {name}", f"{name} touches", bool(on), "Feet"))
        feet.append(Slider(f"mu {name}", f"{name} friction", 0.0, 1.5, 0.01, float(mu), "Feet"))
    return [*common, *feet, Button("reset", "begin anew")]
