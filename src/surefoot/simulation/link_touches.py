"""Which links touched what in a run, beside feet on the ground: what a walk should not do."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from surefoot.simulation.world import ContactReading


class LinkTouches:
    """Counts the steps in which pairs that are no foot on the ground touched; call `look` after every step.

    Parameters
    ----------
    world
        Its method ``touching()`` gives pairs of names, if it has one.
    """

    def __init__(self, world: Any) -> None:
        self._touching: Callable[[], list[tuple[str, str]]] | None = getattr(world, "touching", None)
        self._found: dict[tuple[str, str], tuple[float, int]] = {}

    def look(self, time: float, reading: ContactReading) -> None:
        """Note what touched in the step that began at a time [s]."""
        if self._touching is None or reading.others is None or not any(reading.others.tolist()):
            return
        for a, b in {(min(pair), max(pair)) for pair in self._touching()}:
            first, steps = self._found.get((a, b), (time, 0))
            self._found[a, b] = first, steps + 1

    def lines(self, dt: float) -> list[str]:
        """Return a line for every pair that touched, the first one first; steps are of length `dt` [s]."""
        pairs = sorted(self._found.items(), key=lambda item: item[1][0])
        return [
            f"{a} and {b} from {first:.3f} s on, for {1e3 * dt * steps:.0f} ms"
            for (a, b), (first, steps) in pairs
        ]
