"""Who gets what: the requests of all behaviours merged into one, by the rules of one table.

The order of the behaviours is their rank. For each quantity the log says which behaviour has got its way.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.memory import Memory, Remembering
from surefoot.motion.walking.behaviours.behaviour import NOTHING, Behaviour, Request, WalkView


def _first(new: Any, held: Any) -> bool:
    """Return whether a request takes the place of another: never, the higher rank keeps it."""
    return False


RULES: dict[str, tuple[str, Callable[[Any, Any], bool]]] = {
    "speed_cap": ("the least", operator.lt),
    "velocity": ("by rank", _first),
    "at_most": ("by rank", _first),
    "pace": ("the least", operator.lt),
    "step_times": ("by rank", _first),
    "hold": ("by rank", _first),
    "clearance": ("the greatest", operator.gt),
    "foot_goals": ("by rank", _first),
    "search": ("by rank", _first),
    "recovery": ("by rank", _first),
    "mu": ("the least", operator.lt),
    "acceleration": ("the least", operator.lt),
    "height": ("the least", operator.lt),
}
"""Of each quantity the rule, and whether a new request takes the place of the one that is held."""
LOGGED = Request._fields[: len(RULES)]
"""Quantities in the order of the channel ``asked_by``: those of `RULES`, all but the note."""
EVERYTHING: frozenset[str] = frozenset(LOGGED)
"""All that a walk may be able to do."""
NOBODY: IntArray = np.full(len(LOGGED), -1)
"""What it says where nobody asks for anything [-]."""
NOBODY.setflags(write=False)


class Arbiter(Remembering):
    """Asks the behaviours and merges what they ask for.

    Parameters
    ----------
    behaviours
        By rank, the highest first.
    radius
        Distance of the feet from the middle [m].
    notes
        Lines of the walk; theirs are added.
    honoured
        Quantities that the walk can do something about. Requests for any other are refused: they are left
        out of what is merged, and the log says that nobody has got its way.

    Attributes
    ----------
    asked
        (3,) velocity that is commanded, or asked for in its place, within the caps [m/s, m/s, rad/s].
    velocity
        (3,) that the body goes at: the same at the pace that is asked for, likewise.
    asked_by
        (13,) rank of the behaviour that has got its way with each quantity of `LOGGED`; -1 for none.
    """

    MEMORY = ("asked", "velocity", "asked_by", "_said")

    def __init__(
        self, behaviours: Sequence[Behaviour], radius: float, notes: list[str],
        honoured: frozenset[str] = EVERYTHING,
    ) -> None:  # fmt: skip
        self.behaviours, self.notes = tuple(behaviours), notes
        self.radius, self._said = radius, set[str]()
        self._places = [(at, name) for at, name in enumerate(LOGGED) if name in honoured]
        self.reset()

    def reset(self) -> None:
        """Forget the past, and take back what the behaviours have said."""
        for behaviour in self.behaviours:
            behaviour.reset()
        self.notes[:] = [note for note in self.notes if note not in self._said]
        self._said.clear()
        self.asked, self.velocity = np.zeros(3), np.zeros(3)
        self.asked_by = NOBODY

    def remembered(self) -> Memory:
        """Return what lasts: notes, and the memories of the behaviours that have any, by rank."""
        own = [one.remembered() if isinstance(one, Remembering) else {} for one in self.behaviours]
        return {**super().remembered(), "notes": list(self.notes), "behaviours": own}

    def resume(self, memory: Memory) -> None:
        """See `Remembering`; the list of notes stays the one that the walk shows."""
        own = {name: value for name, value in memory.items() if name not in ("notes", "behaviours")}
        super().resume(own)
        self.notes[:] = memory["notes"]
        for one, kept in zip(self.behaviours, memory["behaviours"], strict=True):
            if isinstance(one, Remembering):
                one.resume(kept)

    def merge(self, view: WalkView) -> Request:
        """Return what all behaviours together ask for."""
        merged, asked_by = NOTHING, NOBODY
        for rank, behaviour in enumerate(self.behaviours):
            request = behaviour.propose(view)
            if request is not NOTHING:
                asked_by = NOBODY.copy() if asked_by is NOBODY else asked_by
                merged = self._take(merged, request, rank, asked_by)
        self.asked_by, self.asked, self.velocity = asked_by, view.command, view.command
        if merged is not NOTHING:  # it seldom is
            self.asked = self._within_caps(view.command, merged)
            self.velocity = self._at_pace(self.asked, view.velocity, merged)
        return merged

    def _take(self, held: Request, new: Request, rank: int, asked_by: IntArray) -> Request:
        """Return a request with what another one of lower rank gets of its own by the rules."""
        taken: dict[str, Any] = {}
        for at, name in self._places:
            own, default = new[at], NOTHING[at]
            if own is None if default is None else own == default:
                continue
            if asked_by[at] < 0 or RULES[name][1](own, held[at]):
                taken[name], asked_by[at] = own, rank
        if new.note and new.note not in self._said:
            self._said.add(new.note)
            self.notes.append(new.note)
        return held._replace(**taken) if taken else held

    def _within_caps(self, command: FloatArray, request: Request) -> FloatArray:
        """Return the (3,) velocity that is asked for within the caps."""
        asked = command if request.velocity is None else request.velocity
        x, y, turn = asked.tolist()
        size = math.hypot(x, y) + abs(turn) * self.radius
        return np.asarray(asked * (request.speed_cap / size)) if size > request.speed_cap else asked

    @staticmethod
    def _at_pace(asked: FloatArray, now: FloatArray, request: Request) -> FloatArray:
        """Return it, not passed the velocity that the gait is not fit for yet, at the pace."""
        most = request.at_most
        if most is not None and float(asked @ asked) > float(now @ now):
            asked = most.copy()
        return asked if request.pace == 1.0 else np.asarray(request.pace * asked)
