"""*push*: a simulated robot walks; kick it, take its friction away, load it, and see its forces and cones."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.lab import drawing as draw
from surefoot.lab.body import RobotBody
from surefoot.lab.contacts import contact_shapes, force_rows
from surefoot.lab.controls import Button, Choice, Slider, Values
from surefoot.lab.drawing import Drawing, Shape
from surefoot.lab.figure import strip
from surefoot.lab.geometry import MovingGround
from surefoot.lab.page import Grip, Page
from surefoot.lab.push_run import HARDEST, KICK, SharedRun, Snapshot
from surefoot.lab.words import heading, paragraph, text
from surefoot.spatial import GRAVITY
from surefoot.terrain import FlatTerrain

PULL = 500.0
"""Force of a kick for a pull of a metre with the mouse [N/m]."""
ARROW = 1.0 / PULL
"""Length of a newton of push [m/N]."""
SPEED = 1.0
"""Fastest speed to choose [m/s]."""


class PushPage(Page):
    """The page of a robot that all viewers share.

    Parameters
    ----------
    shared
        The run.
    names
        Of the contact points.
    gaits
        That the robot has.
    """

    title = "Push it"
    about = (
        "**Pull the robot** with the mouse and let go: it is kicked along the arrow. A click kicks it away "
        "from you. All viewers see the same robot."
    )
    live = True
    eye, look_at = (1.5, -1.5, 0.9), (0.0, 0.0, 0.2)

    def __init__(self, shared: SharedRun, names: tuple[str, ...], gaits: tuple[str, ...]) -> None:
        self._shared, self._names = shared, names
        self._robot = RobotBody(shared.robot)
        self._ground = MovingGround(FlatTerrain(), np.zeros((1, 2)))
        self._pull: tuple[FloatArray, FloatArray] | None = None
        moment, _ = shared.look()
        w = moment.choices
        self.values = Values(
            [
                Slider("mu", "friction of the ground", 0.0, 1.2, 0.01, w.mu),
                Slider("payload", "payload [kg]", 0.0, 10.0, 0.1, w.payload),
                Choice("gait", "gait", gaits, w.gait),
                Slider("forward", "forward [m/s]", -SPEED, SPEED, 0.05, w.velocity[0], "Velocity"),
                Slider("left", "left [m/s]", -0.5, 0.5, 0.05, w.velocity[1], "Velocity"),
                Slider("turn", "turn [rad/s]", -1.0, 1.0, 0.05, w.velocity[2], "Velocity"),
                Slider("force", "force [N]", 0.0, HARDEST, 5.0, 100.0, "Kick"),
                Slider(
                    "direction",
                    "towards [deg]",
                    -180.0,
                    180.0,
                    5.0,
                    90.0,
                    "Kick",
                    "0 is along +x, 90 along +y",
                ),
                Button("kick", "kick", "Kick"),
                Button("restart", "stand up again"),
            ]
        )
        shared.enter()

    def change(self, name: str, raw: object) -> None:
        """Take a value; what concerns the robot holds for all viewers."""
        before = self.values.get(name)
        super().change(name, raw)
        try:
            self._choose(name)
        except Exception:
            self.values.change(name, before)
            raise

    def _choose(self, name: str) -> None:
        """Tell the run what a control says."""
        v = self.values
        if name in ("mu", "payload", "gait"):
            changes = {name: v[name]}
        elif name in ("forward", "left", "turn"):
            changes = {"velocity": (v["forward"], v["left"], v["turn"])}
        else:
            return
        with self._shared.held() as run:
            run.choose(replace(run.choices, **changes))

    def press(self, name: str) -> None:
        """Kick the robot, or stand it up."""
        if name == "restart":
            with self._shared.held() as run:
                run.restart()
        elif name == "kick":
            angle = math.radians(self.values["direction"])
            self._kick(self.values["force"] * np.array([math.cos(angle), math.sin(angle), 0.0]))
        else:
            super().press(name)

    def _kick(self, force: FloatArray) -> None:
        with self._shared.held() as run:
            run.kick(force)

    def grip(self, grip: Grip) -> None:
        """Pull the robot with the mouse; letting go kicks it."""
        if not grip.name.startswith("/robot/"):
            super().grip(grip)
        self._pull = None
        if grip.phase == "click":
            way = (grip.point - grip.eye) * [1.0, 1.0, 0.0]
            self._kick(self.values["force"] * way / max(float(np.linalg.norm(way)), 1e-9))
        elif grip.phase == "end":
            self._kick(PULL * (grip.point - grip.start))
        else:
            self._pull = grip.start, grip.point

    def drawing(self) -> Drawing:
        """Return what there is to see now."""
        moment, (times, normal) = self._shared.look()
        self._follow(moment)
        q, origin = moment.q.copy(), moment.q[:2].copy()
        q[:2] = 0.0
        weight = (self._robot.robot.mass + moment.choices.payload) * GRAVITY
        reading, n = moment.reading, len(self._names)
        places = reading.positions - [*origin, 0.0]
        mu = np.full(n, moment.choices.mu)
        frames = np.broadcast_to(np.eye(3), (n, 3, 3))
        shapes: dict[str, Shape] = {
            **self._ground.shapes(origin),
            **self._robot.shapes(q, held=True),
            **contact_shapes(self._names, places, frames, reading.forces, mu, weight),
        }
        if moment.push.any():
            vector = ARROW * moment.push
            shapes["/push"] = draw.arrow_at(q[:3] - vector, vector, draw.PUSH, 0.015)
        if self._pull is not None:
            shapes["/pull"] = draw.arrows(self._pull[0], self._pull[1] - self._pull[0], draw.PUSH, 0.008)
        return Drawing(shapes, self._text(moment, mu), strip(times, normal, self._names, weight))

    def _follow(self, moment: Snapshot) -> None:
        """Show what other viewers choose."""
        w = moment.choices
        for name, value in (
            ("mu", w.mu), ("payload", w.payload), ("gait", w.gait),
            ("forward", w.velocity[0]), ("left", w.velocity[1]), ("turn", w.velocity[2]),
        ):  # fmt: skip
            self.values.change(name, value)

    def _text(self, moment: Snapshot, mu: FloatArray) -> str:
        """Return state, speed and forces as HTML."""
        state = (
            "It has fallen"
            if moment.fallen
            else "It walks"
            if moment.choices.gait != "stand"
            else "It stands"
        )
        clock = f"{moment.time:.1f} s, {100.0 * moment.speed:.0f} % of real time."
        return text(
            heading(state),
            paragraph(f"{clock} A kick lasts {1e3 * KICK:.0f} ms."),
            force_rows(self._names, moment.reading.forces, mu),
            *(paragraph(note) for note in moment.notes),
        )

    def close(self) -> None:
        """Leave the run; without viewers it waits."""
        self._shared.leave()
