"""What a symptom is: words for people, and a function that tells how strongly an episode speaks for it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from surefoot.records.audit.episode import Episode


class Evidence(NamedTuple):
    """How strongly an episode speaks for a symptom, from 0 to 1, and the figures in words."""

    strength: float
    text: str


Judge = Callable[[Episode], Evidence | None]
"""From an episode to evidence; None where it does not speak for the symptom."""


@dataclass(frozen=True)
class Symptom:
    """A symptom.

    Attributes
    ----------
    name
        Key.
    cause, confirm, cure
        The likely cause, the check that would confirm it, the usual cure.
    judge
        From an episode to evidence; None where it does not speak for the symptom.
    checks
        Without these having failed, nothing speaks for it.
    body
        Whether it is asked of the robot as a whole; else of every contact.
    """

    name: str
    cause: str
    confirm: str
    cure: str
    judge: Judge
    checks: tuple[str, ...] = ()
    body: bool = False

    def evidence(self, episode: Episode) -> Evidence | None:
        """Return what speaks for the symptom in an episode; None if nothing does."""
        asked = self.body == episode.body and episode.has(*self.checks)
        return self.judge(episode) if asked else None


def symptom(
    name: str, *checks: str, cause: str, confirm: str, cure: str, body: bool = False
) -> Callable[[Judge], Symptom]:
    """Make a function from an episode to evidence the symptom of these words; see `Symptom`."""
    return lambda judge: Symptom(name, cause, confirm, cure, judge, checks, body)
