"""What a symptom is: words for people, and a function that tells how strongly an episode speaks for it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from surefoot.audit.episode import Episode


class Evidence(NamedTuple):
    """How strongly an episode speaks for a symptom, from 0 to 1, and the figures in words."""

    strength: float
    text: str


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
    body
        Whether it is asked of the robot as a whole; else of every contact.
    """

    name: str
    cause: str
    confirm: str
    cure: str
    judge: Callable[[Episode], Evidence | None]
    body: bool = False
