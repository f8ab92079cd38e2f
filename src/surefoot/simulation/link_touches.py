"""Which links touched what in a run, beside feet on the ground: what a walk should not do."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from surefoot.simulation.observers import Moment, Observer


class LinkTouches(Observer):
    """Counts the steps in which pairs that are no foot on the ground touched.

    Parameters
    ----------
    world
        Its method ``touching()`` gives pairs of names, if it has one.

    Attributes
    ----------
    found
        Pair of names to when it first touched [s], and in how many steps.
    """

    def __init__(self, world: Any) -> None:
        self._touching: Callable[[], list[tuple[str, str]]] | None = getattr(world, "touching", None)
        self.found: dict[tuple[str, str], tuple[float, int]] = {}

    def step(self, moment: Moment) -> None:
        """Note what touched in a step."""
        others = moment.reading.others
        if self._touching is None or others is None or not any(others.tolist()):
            return
        for a, b in {(min(pair), max(pair)) for pair in self._touching()}:
            first, steps = self.found.get((a, b), (moment.time, 0))
            self.found[a, b] = first, steps + 1

    def lines(self, dt: float) -> list[str]:
        """Return a line for every pair that touched, the first one first; steps are of length `dt` [s]."""
        pairs = sorted(self.found.items(), key=lambda item: item[1][0])
        return [
            f"{a} and {b} from {first:.3f} s on, for {1e3 * dt * steps:.0f} ms"
            for (a, b), (first, steps) in pairs
        ]
