"""Run one body, or anything without motors, in a world and keep its path."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.mechanics import Robot, Terrain
from surefoot.worlds.experiments.ground import hard
from surefoot.worlds.interface.world import World
from surefoot.worlds.interface.world_names import make_world

SETTLE = 0.1
"""How long a body lies still before it is set in motion [s], so that it starts in the world's own rest."""

GRIP = 2.0
"""Friction meanwhile."""


@dataclass(frozen=True)
class BodyTrack:
    """A path.

    Attributes
    ----------
    q, v
        (n + 1, nq), (n + 1, nv) in Pinocchio's order.
    forces
        (n, p, 3) of each step in the terrain's frames [N].
    """

    q: FloatArray
    v: FloatArray
    forces: FloatArray


@dataclass(frozen=True)
class BodyRun:
    """A body that is put on a terrain and set in motion.

    Attributes
    ----------
    body
        From `worlds.rigid.bodies`.
    duration
        [s].
    mu
        Friction.
    terrain
        None for flat ground.
    velocity
        (6,) at the start, in the body's axes.
    start
        (nq,) where it starts; None for its nominal pose on the terrain.
    settle
        Whether it first lies still for `SETTLE`.
    """

    body: Robot
    duration: float
    mu: float = 0.5
    terrain: Terrain | None = None
    velocity: tuple[float, ...] = (0.0,) * 6
    start: FloatArray | None = None
    settle: bool = True

    def run(self, world: str, dt: float, options: Mapping[str, Any] | None = None) -> BodyTrack:
        """Return the path in a world; its own options are those of hard ground unless given."""
        chosen = hard(world, dt) if options is None else options
        made = make_world(world, self.body, self.terrain, self.mu, dt=dt, **chosen)
        try:
            q = self.body.nominal if self.start is None else self.start
            made.reset(q)
            if self.settle:
                made.set_friction(GRIP)
                follow(made, SETTLE)
                made.set_friction(self.mu)
                q = made.q_v()[0]
            made.reset(q, np.array(self.velocity, dtype=np.float64))
            return follow(made, self.duration)
        finally:
            getattr(made, "close", lambda: None)()  # of those with a process of their own


def fall(
    body: Robot, height: float, seconds: float, world: str, dt: float,
    options: Mapping[str, Any] | None = None,
) -> BodyTrack:  # fmt: skip
    """Return the path of a body from a height over its nominal pose [m], negative for one pressed in."""
    start = body.nominal.copy()
    start[2] += height
    return BodyRun(body, seconds, start=start, settle=False).run(world, dt, options)


def follow(world: World, seconds: float) -> BodyTrack:
    """Return the path of a world that is left to itself for a time [s]."""
    steps, still = round(seconds / world.dt), np.zeros(world.robot.joints)
    states, forces = [world.q_v()], []
    for _ in range(steps):
        world.step(still)
        states.append(world.q_v())
        forces.append(world.contacts().forces)
    q, v = (np.array([state[k] for state in states]) for k in (0, 1))
    shape = (steps, len(world.contact_foot), 3)
    return BodyTrack(q, v, np.array(forces).reshape(shape))
