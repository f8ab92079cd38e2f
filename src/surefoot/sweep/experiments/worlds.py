"""A box is set in motion on a slope, in any world, and held against Coulomb's law."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.errors import ProblemError, unknown_name
from surefoot.simulation.worlds import WORLDS, make_world
from surefoot.spatial import GRAVITY, quaternion_from_rotation, rotation_about
from surefoot.sweep.bodies import altered, check_ground, ground_options
from surefoot.sweep.experiments.experiment import Experiment
from surefoot.sweep.space import Sample, Space
from surefoot.terrain import SlopeTerrain, Terrain

if TYPE_CHECKING:
    from surefoot.robot import Robot

SIZE, CORNER = (0.4, 0.4, 0.1), 1e-3
"""Edges of the box, and the radius of its corners, which engines want [m]."""


@dataclass(frozen=True)
class Worlds(Experiment):
    """Slide a flat box along a slope in one world; it survives if it ends where rigid Coulomb friction says.

    The box settles on friction 2, gets its speed and is left to itself. `surefoot worlds` has more
    experiments, each at one friction and one softness.

    Attributes
    ----------
    world
        A name of `surefoot.simulation.worlds.WORLDS`.
    body_mass
        [kg]; the parameter `mass` scales it.
    start_speed
        Up the slope [m/s], negative for down.
    settle, duration, dt
        Time to settle, time on the way, and step [s].
    tolerance
        Largest distance from the closed form at the end [m].
    """

    parameters: ClassVar[tuple[str, ...]] = (
        "mu", "stiffness", "damping", "time_constant", "damping_ratio", "mass", "slope",
    )  # fmt: skip
    columns: ClassVar[Mapping[str, str]] = {
        "agrees": "bool",  # within the tolerance
        "way": "float",  # up the slope, from start to end [m]
        "exact": "float",  # of rigid Coulomb friction [m]
        "off": "float",  # distance of the two [m]
        "depth_max": "float",  # furthest that its centre sank [m]
    }
    chunk: ClassVar[int] = 4
    packages: ClassVar[tuple[str, ...]] = ("pin",)
    limits: ClassVar[Mapping[str, tuple[float, float]]] = {
        "body_mass": (1e-3, 1e6), "start_speed": (-100.0, 100.0), "settle": (0.0, 60.0),
        "duration": (1e-2, 60.0), "dt": (1e-5, 0.02), "tolerance": (0.0, 100.0),
    }  # fmt: skip

    world: str = "mujoco"
    body_mass: float = 2.0
    start_speed: float = 1.0
    settle: float = 0.5
    duration: float = 0.5
    dt: float = 0.001
    tolerance: float = 0.005

    def __post_init__(self) -> None:
        if self.world not in tuple(WORLDS):  # a list would not be hashable
            raise ProblemError(unknown_name("world", self.world, WORLDS))
        super().__post_init__()

    def check(self, space: Space) -> None:
        """Refuse what the world does not have."""
        super().check(space)
        check_ground(self.world, space)

    def run(self, sample: Sample) -> dict[str, Any]:
        """Return how far the box went, and how far it should have gone."""
        from surefoot.simulation.bodies import box

        mu, degrees = sample.number("mu", 0.6), sample.number("slope", 0.0)
        body, terrain = altered(box(self.body_mass, SIZE, CORNER), sample), SlopeTerrain(degrees)
        tilt = rotation_about(np.array([0.0, -1.0, 0.0]), math.radians(degrees))
        start = np.concatenate([0.5 * SIZE[2] * tilt[:, 2], quaternion_from_rotation(tilt)])
        path = self._path(sample, body, terrain, start) @ tilt  # along, across, above the slope
        way = float(path[-1, 0] - path[0, 0])
        exact = coulomb_way(mu, degrees, self.start_speed, self.duration)
        off, depth = abs(way - exact), 0.5 * SIZE[2] - float(path[:, 2].min())
        return {
            "agrees": off <= self.tolerance, "way": way, "exact": exact, "off": off,
            "depth_max": max(0.0, depth),
        }  # fmt: skip

    def _path(self, sample: Sample, body: Robot, terrain: Terrain, start: FloatArray) -> FloatArray:
        """Return the centre of the box (n + 1, 3) from when it gets its speed [m]."""
        from surefoot.simulation.experiments.ground import hard
        from surefoot.simulation.experiments.track import GRIP, follow

        told = {**hard(self.world, self.dt), **ground_options(self.world, sample)}
        mu, velocity = sample.number("mu", 0.6), np.zeros(6)
        velocity[0] = self.start_speed
        world = make_world(self.world, body, terrain, mu, dt=self.dt, **told)
        with contextlib.ExitStack() as stack:
            stack.callback(getattr(world, "close", lambda: None))  # of worlds with an engine of their own
            world.reset(start)
            world.set_friction(GRIP)
            follow(world, self.settle)
            world.set_friction(mu)
            world.reset(world.state()[0], velocity)
            return follow(world, self.duration).q[:, :3]


def coulomb_way(mu: float, degrees: float, speed: float, seconds: float) -> float:
    """Return how far up a slope a body gets that starts with a speed [m], by Coulomb's law.

    >>> round(coulomb_way(0.5, 0.0, 1.0, 9.0) * 2.0 * 0.5 * GRAVITY, 9)  # v^2 / (2 mu g)
    1.0
    """
    along, grip = GRAVITY * math.sin(math.radians(degrees)), mu * GRAVITY * math.cos(math.radians(degrees))
    way, left = 0.0, seconds
    if speed != 0.0:
        rate = -along - math.copysign(grip, speed)
        slows = rate * speed < 0.0
        moving = min(seconds, -speed / rate) if slows else seconds
        way, left = speed * moving + 0.5 * rate * moving**2, seconds - moving
    slips = max(0.0, abs(along) - grip)
    return way - 0.5 * math.copysign(slips, along) * left**2
