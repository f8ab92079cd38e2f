"""Coming to stairs that are known: slowly, until the gait is in step with them and in phase to set off."""

from __future__ import annotations

from surefoot.motion.ground.ground_belief import believed
from surefoot.motion.walking.behaviours.behaviour import NOTHING, FootSearch, Request, WalkFacts, WalkView


class SeenStairs:
    """Waits for gait and body to be in step with stairs.

    Parameters
    ----------
    walk
        What it is for.
    """

    name = "seen stairs"

    def __init__(self, walk: WalkFacts) -> None:
        self.schedule = walk.schedule
        self.settings = walk.settings.stair_approach
        self._belief = believed(walk.terrain)
        seen = self._belief is not None and self._belief.seen
        self._usual = Request(search=FootSearch(self.settings.search_speed)) if seen else NOTHING
        self._slowly = self._usual._replace(pace=self.settings.approach)

    @classmethod
    def of(cls, walk: WalkFacts) -> SeenStairs | None:
        """Return the behaviour for gaits that get in step with the ground."""
        return cls(walk) if walk.schedule.adapts or walk.terrain.learns else None

    def reset(self) -> None:
        """Forget nothing: it knows the present alone."""

    def propose(self, view: WalkView) -> Request:
        """Ask for little speed while the gait turns into step or waits for its phase."""
        if self._belief is not None and self._belief.unsure:
            return self._usual
        return self._slowly if view.waiting or self.schedule.turning else self._usual
