"""The friction of the ground in a run: as it changes with time, and where patches lie on it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from surefoot.base.errors import ProblemError
from surefoot.base.memory import Remembering
from surefoot.records import CHANNELS, Channel
from surefoot.worlds.interface.world import ContactReading, World
from surefoot.worlds.running.scenario import Scenario


class GroundFriction(Remembering):
    """Sets the friction of a world step by step.

    Parameters
    ----------
    world
        Whose ground it is; patches need one with `set_point_friction`.
    scenario
        Its `mu`, `ice` and `patches`.

    Attributes
    ----------
    mu
        Friction of the ground beside the patches now [-].
    channels
        What it adds to a log; `rows` gives the values.

    Raises
    ------
    ProblemError
        For patches in a world that has one friction everywhere.
    """

    MEMORY = ("mu", "_changes", "_under")

    def __init__(self, world: World, scenario: Scenario) -> None:
        if scenario.patches and not hasattr(world, "set_point_friction"):
            raise ProblemError(
                f"a {type(world).__name__} has one friction everywhere: patches of ice take the world mujoco"
            )
        mu = getattr(world, "mu", None) if scenario.mu is None else scenario.mu
        if mu is None:
            raise ProblemError(f"a {type(world).__name__} does not tell its friction: give the scenario mu")
        self._world: Any = world
        self.mu = float(mu)
        self._patches = tuple(scenario.patches)
        self._changes = sorted(scenario.ice, key=lambda change: change.start)
        self.channels: tuple[Channel, ...] = (CHANNELS["contact_friction"],) if self._patches else ()
        self._under = np.full(len(world.contact_foot), self.mu)
        world.set_friction(self.mu)

    def advance(self, now: float, reading: ContactReading) -> None:
        """Set the friction of the step that begins now [s], the contact points being where they were read."""
        while self._changes and now >= self._changes[0].start - 1e-9:
            self.mu = self._changes.pop(0).mu
            self._world.set_friction(self.mu)
        if self._patches:
            self._under = np.full(len(reading.positions), self.mu)
            for patch in self._patches:
                xy = reading.positions[:, :2]
                self._under[(xy >= patch.lower).all(axis=1) & (xy < patch.upper).all(axis=1)] = patch.mu
            self._world.set_point_friction(self._under)

    def rows(self) -> Mapping[str, Any]:
        """Return the values of its channels at this step."""
        return {"contact_friction": self._under} if self._patches else {}
