"""*push*: a simulated robot walks; kick it, take its friction away, load it, and see its forces and cones."""

from __future__ import annotations

import time as clock
from dataclasses import replace

import numpy as np

from surefoot.app.lab import drawing as draw
from surefoot.app.lab.body import RobotBody
from surefoot.app.lab.contacts import contact_shapes, force_rows
from surefoot.app.lab.controls import Button, Choice, Slider, Values
from surefoot.app.lab.drawing import Drawing, Shape
from surefoot.app.lab.figure import strip
from surefoot.app.lab.geometry import MovingGround
from surefoot.app.lab.html_text import heading, paragraph, text
from surefoot.app.lab.page import Grip, Page
from surefoot.app.lab.push_run import HARDEST, KICK, WalkRun
from surefoot.base.arrays import FloatArray
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics import FlatTerrain

PULL = 500.0
"""Force of a kick for a pull of a metre with the mouse [N/m]."""
ARROW = 1.0 / PULL
"""Length of a newton of push [m/N]."""
SPEED = 1.0
"""Fastest speed to choose [m/s]."""
LONGEST = 0.1
"""Time between two pictures beyond which the robot falls behind the clock [s]."""


class PushPage(Page):
    """The page of a robot that walks by the clock, while somebody looks.

    Parameters
    ----------
    run
        That is stepped.
    """

    title = "Push it"
    about = (
        "**Pull the robot** with the mouse and let go: it is kicked along the arrow. A click kicks it away "
        "from you."
    )
    live = True
    eye, look_at = (1.5, -1.5, 0.9), (0.0, 0.0, 0.2)

    def __init__(self, run: WalkRun) -> None:
        self._run, self._names = run, run.contact_names
        self._robot = RobotBody(run.robot)
        self._ground = MovingGround(FlatTerrain(), np.zeros((1, 2)))
        self._pull: tuple[FloatArray, FloatArray] | None = None
        self._shown, self._speed = clock.perf_counter(), 1.0
        w = run.choices
        self.values = Values(
            [
                Slider("mu", "friction of the ground", 0.0, 1.2, 0.01, w.mu),
                Slider("payload", "payload [kg]", 0.0, 10.0, 0.1, w.payload),
                Choice("gait", "gait", run.names, w.gait),
                Slider("forward", "forward [m/s]", -SPEED, SPEED, 0.05, w.velocity[0], "Velocity"),
                Slider("left", "left [m/s]", -0.5, 0.5, 0.05, w.velocity[1], "Velocity"),
                Slider("turn", "turn [rad/s]", -1.0, 1.0, 0.05, w.velocity[2], "Velocity"),
                Slider("force", "kick of a click [N]", 0.0, HARDEST, 5.0, 100.0),
                Button("restart", "stand up again"),
            ]
        )

    def change(self, name: str, raw: object) -> None:
        """Take a value, and tell the run."""
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
        self._run.choose(replace(self._run.choices, **changes))

    def press(self, name: str) -> None:
        """Stand the robot up."""
        if name != "restart":
            super().press(name)
        self._run.restart()

    def grip(self, grip: Grip) -> None:
        """Pull the robot with the mouse; letting go kicks it."""
        if not grip.name.startswith("/robot/"):
            super().grip(grip)
        self._pull = None
        if grip.phase == "click":
            way = (grip.point - grip.eye) * [1.0, 1.0, 0.0]
            self._run.kick(self.values["force"] * way / max(float(np.linalg.norm(way)), 1e-9))
        elif grip.phase == "end":
            self._run.kick(PULL * (grip.point - grip.start))
        else:
            self._pull = grip.start, grip.point

    def drawing(self) -> Drawing:
        """Return what there is to see now."""
        self._go_on()
        run, n = self._run, len(self._names)
        q = run.world.q_v()[0].copy()
        origin = q[:2].copy()
        q[:2] = 0.0
        weight = (run.robot.mass + run.choices.payload) * GRAVITY
        reading, push = run.reading, run.push
        places = reading.positions - [*origin, 0.0]
        mu = np.full(n, run.choices.mu)
        frames = np.broadcast_to(np.eye(3), (n, 3, 3))
        shapes: dict[str, Shape] = {
            **self._ground.shapes(origin),
            **self._robot.shapes(q, held=True),
            **contact_shapes(self._names, places, frames, reading.forces, mu, weight),
        }
        if push.any():
            vector = ARROW * push
            shapes["/push"] = draw.arrow_at(q[:3] - vector, vector, draw.PUSH, 0.015)
        if self._pull is not None:
            shapes["/pull"] = draw.arrows(self._pull[0], self._pull[1] - self._pull[0], draw.PUSH, 0.008)
        return Drawing(shapes, self._text(mu), strip(*run.strip(), self._names, weight))

    def _go_on(self) -> None:
        """Let the robot walk as far as the clock went on since the last picture."""
        now = clock.perf_counter()
        passed, self._shown = now - self._shown, now
        made = self._run.go_on(min(passed, LONGEST))
        self._speed += 0.1 * (made / max(passed, 1e-6) - self._speed)

    def _text(self, mu: FloatArray) -> str:
        """Return state, speed and forces as HTML."""
        run = self._run
        does = "It walks" if run.choices.gait != "stand" else "It stands"
        state = "It has fallen" if run.fallen else does
        speed = f"{run.time:.1f} s, {100.0 * self._speed:.0f} % of real time."
        return text(
            heading(state),
            paragraph(f"{speed} A kick lasts {1e3 * KICK:.0f} ms."),
            force_rows(self._names, run.reading.forces, mu),
            *(paragraph(note) for note in run.controller.notes),
        )
