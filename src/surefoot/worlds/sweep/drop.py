"""A ball or a box falls on rigid or soft ground, and comes to rest or not."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError, check_name, shown
from surefoot.base.spatial import GRAVITY, quaternion_from_rotation, rotation_about
from surefoot.worlds.sweep.ground_settings import GroundExperiment
from surefoot.worlds.sweep.sample_experiment import number

BODIES = ("ball", "box")
REST_SPEED = 0.02
"""A body counts as at rest below this speed of its centre [m/s] ..."""
REST_SPIN = 0.2
"""... and this turn rate [rad/s] ..."""
REST_LENGTH = 0.2
"""... for this long [s]; the run then ends."""
NO_TORQUES = np.zeros(0)


@dataclass(frozen=True)
class DropExperiment(GroundExperiment):
    """Drop a body in the rigid world; it survives if it comes to rest.

    Attributes
    ----------
    body
        "box" or "ball".
    size
        Edge of the box, or the ball's diameter [m].
    body_mass
        [kg]; the setting `mass` scales it.
    height
        Free fall before the first touch, at least [m].
    speed
        At the start, along +x [m/s].
    tumble
        Whether each sample starts with another orientation and a spin (standard deviation 3 rad/s).
    duration, dt
        Simulated time and step [s].
    """

    columns: ClassVar[Mapping[str, str]] = {
        "rested": "bool",  # for 0.2 s, before the time was over
        "rest_time": "float",  # from when on [s]
        "distance": "float",  # from the start, along the ground [m]
        "bounce": "float",  # highest that the centre rose over where it was at its lowest before [m]
        "force_max": "float",  # of the ground, m g
        "depth_max": "float",  # deepest overlap [m]
    }
    chunk: ClassVar[int] = 16

    body: str = "box"
    size: float = number(0.1, 1e-3, 100.0, "m")
    body_mass: float = number(1.0, 1e-3, 1e6, "kg")
    height: float = number(0.1, 0.0, 100.0, "m")
    speed: float = number(0.0, -100.0, 100.0, "m/s")
    tumble: bool = True
    duration: float = number(1.0, 1e-2, 600.0, "s")
    dt: float = number(0.002, 1e-5, 0.05, "s")

    def __post_init__(self) -> None:
        super().__post_init__()
        check_name("body", self.body, BODIES)
        if not isinstance(self.tumble, bool):
            raise ProblemError(f"tumble must be true or false, got {shown(self.tumble)}")

    def run(self, seed: int) -> dict[str, Any]:
        """Return how the body came to rest."""
        from surefoot.worlds.rigid.bodies import ball, box
        from surefoot.worlds.rigid.rigid_world import RigidWorld

        edges = (self.size, self.size, self.size)
        nominal = ball(self.body_mass, 0.5 * self.size) if self.body == "ball" else box(self.body_mass, edges)
        body, terrain = self.alter_masses(nominal), self.ground(seed)
        world = RigidWorld(body, terrain, self.mu, self.dt, **self.ground_options())
        world.reset(*self._start(seed, float(terrain.height([0.0, 0.0])), body.model.nv))
        return self._results(world, body.mass * GRAVITY)

    def _start(self, seed: int, level: float, nv: int) -> tuple[FloatArray, FloatArray]:
        """Return where the body starts: clear of the ground however it is turned."""
        reach = 0.5 * self.size * (1.0 if self.body == "ball" else math.sqrt(3.0) if self.tumble else 1.0)
        q, v = np.array([0.0, 0.0, level + reach + self.height, 0.0, 0.0, 0.0, 1.0]), np.zeros(nv)
        heading = np.array([self.speed, 0.0, 0.0])
        if self.tumble:
            random = np.random.default_rng(seed)
            axis = random.normal(size=3)
            turn = rotation_about(axis / np.linalg.norm(axis), random.uniform(0.0, math.pi))
            q[3:7] = quaternion_from_rotation(turn)
            v[3:6] = 3.0 * random.normal(size=3)
            heading = turn.T @ heading
        v[:3] = heading
        return q, v

    def _results(self, world: Any, weight: float) -> dict[str, Any]:
        """Step the world until the body rests or the time is over, and return what happened."""
        start = world.q_v()[0][:3]
        force, depth, lowest, bounce, moving = 0.0, 0.0, math.inf, 0.0, 0.0
        rested = False
        for _ in range(max(1, round(self.duration / self.dt))):
            world.step(NO_TORQUES)
            q, v = world.q_v()
            height, pushed = float(q[2] - world.terrain.height(q[:2])), world.last.forces.sum(axis=0)
            if pushed.any():
                force = max(force, math.hypot(*pushed))
                depth = max(depth, -float(world.last.gaps.min()))
            if force > 0.0:
                lowest = min(lowest, height)
                bounce = max(bounce, height - lowest)
            if float(v[:3] @ v[:3]) > REST_SPEED**2 or float(v[3:6] @ v[3:6]) > REST_SPIN**2:
                moving = world.time
            elif rested := world.time - moving >= REST_LENGTH:
                break
        return {
            "rested": rested,
            "rest_time": moving if rested else None,
            "distance": float(np.linalg.norm((q[:3] - start)[:2])),
            "bounce": bounce,
            "force_max": force / weight,
            "depth_max": depth,
        }
