"""What Pinocchio's data of a model hold, as arrays that follow them: made once, read at every step."""

from __future__ import annotations

from functools import cache
from typing import Any

from surefoot.base.arrays import FloatArray
from surefoot.base.live_arrays import live_parts

PARTS = "rotation", "translation"
"""Of a pose."""


@cache
def pinocchio_module() -> Any:
    """Return Pinocchio, which takes long to load: called in every step this is faster than an import."""
    import pinocchio

    return pinocchio


class ModelViews:
    """Arrays on the memory of one `pinocchio.Data`: its next computation changes them.

    Getting an array off Pinocchio's data costs a third of a microsecond every time, as much as the arithmetic
    that follows. A copy of this has views of the copied data.

    Parameters
    ----------
    model, data
        Pinocchio's; the data stay alive with this.

    Attributes
    ----------
    mass_matrix
        (nv, nv) after `crba`, symmetric [kg, kg m²].
    bias
        (nv,) after `nonLinearEffects` [N, N m].
    twists, twist_rates
        (6, nv) after `computeJointJacobiansTimeVariation`: data.J and data.dJ.
    rotation, place
        (3, 3), (3,) of the base [-, m].
    com, com_velocity
        (3,) after `centerOfMass` [m], [m/s].
    frame_rotations, frame_places
        (frames, 3, 3), (frames, 3) after `updateFramePlacements` [-, m].
    """

    def __init__(self, model: Any, data: Any) -> None:
        self.model, self.data = model, data
        self.mass_matrix: FloatArray = data.M.T  # symmetric: Pinocchio's columns are our rows
        self.bias: FloatArray = data.nle
        self.twists: FloatArray = data.J
        self.twist_rates: FloatArray = data.dJ
        self.rotation: FloatArray = data.oMi[1].rotation
        self.place: FloatArray = data.oMi[1].translation
        self.com: FloatArray = data.com[0]
        self.com_velocity: FloatArray = data.vcom[0]
        self.frame_rotations, self.frame_places = (live_parts(data.oMf, part) for part in PARTS)

    def __reduce__(self) -> tuple[Any, ...]:
        """Return how a copy is made: from copied data."""
        return type(self), (self.model, self.data)
