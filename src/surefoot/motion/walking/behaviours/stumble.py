"""After a stumble feet are lifted higher, and over ground whose bumps are not known, too."""

from __future__ import annotations

from surefoot.motion.ground.ground_belief import BeliefTerrain, believed
from surefoot.motion.walking.behaviours.behaviour import NOTHING, Request, WalkFacts, WalkView


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
        self.settings = walk.settings.stumble

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
        calm = max(0.0, 1.0 - (view.time - self._belief.struck_at) / self.settings.memory)
        stumble = self.settings.lift * self.height * min(2.0 * calm, 1.0)
        lift = min(max(self._belief.bumps, stumble), self.settings.highest * self.height)
        return Request(clearance=lift) if lift > 0.0 else NOTHING
