"""What a belief about the ground asks of the walk on it: where to go slowly, where to stop, and why."""

from __future__ import annotations

from surefoot.arrays import FloatArray
from surefoot.control.walking_feet import SEARCH_SPEED


class Caution:
    """How a walk goes on while the ground is not known well.

    Attributes
    ----------
    search_speed
        Largest speed with which late feet are sent down, as a share of sqrt(g h).
    unsure
        Whether there are steps and it is not known where: feet feel ahead, and the body goes on slowly.
    pace
        The share of its speed then.
    lead
        Speed with which late feet go along with the body then, over the body's.
    careful
        Whether late feet slow down on their way to the ground, and gait and body wait for them.
    standing
        Whether all feet should stay on the ground.
    leading
        A foot that is to be among the first to lift after that.
    notes
        What the walk says of its command: a line is added for what has been slowed.
    """

    search_speed: float = SEARCH_SPEED
    unsure: bool = False
    pace: float = 1.0
    lead: float = 0.0
    careful: bool = False
    standing: bool = False
    leading: int = 0

    def __init__(self) -> None:
        self.notes: list[str] = []

    def allowed(self, command: FloatArray) -> FloatArray:
        """Return what may be followed of a (3,) velocity in heading axes [m/s, m/s, rad/s]."""
        return command
