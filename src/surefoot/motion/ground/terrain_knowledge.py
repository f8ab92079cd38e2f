"""What a controller may know of the ground that it walks on.

========  =====================================================================================
exact     the controller is given the true terrain
map       `MappedGround`: a height map from a range sensor, corrected where feet stand
blind     `TouchedGround`: a plane through the last footholds, and drops that feet find
========  =====================================================================================
"""

from __future__ import annotations

from surefoot.base.errors import check_name
from surefoot.mechanics import Terrain
from surefoot.motion.ground.mapped_ground import MappedGround
from surefoot.motion.ground.touched_ground import TouchedGround

KNOWLEDGE = ("exact", "map", "blind")
"""What a controller may know about the terrain."""


def controller_ground(knowledge: str, terrain: Terrain) -> Terrain:
    """Return what a controller plans on that has a certain knowledge of the true terrain.

    Raises
    ------
    ProblemError
        For an unknown name; the message lists `KNOWLEDGE`.

    Examples
    --------
    >>> from surefoot.mechanics.terrain import FlatTerrain
    >>> controller_ground("blind", FlatTerrain())
    TouchedGround()
    """
    check_name("terrain knowledge", knowledge, KNOWLEDGE)
    if knowledge == "exact":
        return terrain
    return MappedGround() if knowledge == "map" else TouchedGround()
