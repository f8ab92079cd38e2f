"""After a stumble feet are lifted higher, and over ground whose bumps are not known, too."""

from __future__ import annotations

from surefoot.motion.ground.ground_belief import BeliefTerrain, believed
from surefoot.motion.walking.behaviours.behaviour import NOTHING, Request, WalkFacts, WalkView

MEMORY = 4.0
"""How long a stumble is remembered [s]: for half of it feet are lifted as high as right after it."""
LIFT = 0.2
"""By how much feet are lifted more after a stumble, in heights of the centre of mass: over a step of 6 cm for
a robot of Go2's size, which blind walks over rubble met."""
HIGHEST = 0.25
"""Most that feet are lifted more, likewise: more takes a trot's swing more joint speed than motors have."""


class Stumble:
    """Lifts feet over what they have struck.

    Parameters
    ----------
    walk
        What it is for.
    belief
        The ground, which knows when a foot has struck an edge and how far bumps may stick out.
    """

    name = "stumble"

    def __init__(self, walk: WalkFacts, belief: BeliefTerrain) -> None:
        self._belief, self.height = belief, walk.height

    @classmethod
    def of(cls, walk: WalkFacts) -> Stumble | None:
        """Return the behaviour on ground that is only believed."""
        belief = believed(walk.terrain)
        return None if belief is None else cls(walk, belief)

    def reset(self) -> None:
        """Forget nothing: what was struck is the belief's to know."""

    def propose(self, view: WalkView) -> Request:
        """Ask for a higher swing."""
        if self._belief.unsure:  # near a drop feet are lifted over what is known of it
            return NOTHING
        calm = max(0.0, 1.0 - (view.time - self._belief.struck_at) / MEMORY)
        stumble = LIFT * self.height * min(2.0 * calm, 1.0)
        lift = min(max(self._belief.bumps, stumble), HIGHEST * self.height)
        return Request(clearance=lift) if lift > 0.0 else NOTHING
