"""What a simulator must offer to be fitted to tosses: parameters, and poses for values of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from surefoot.arrays import FloatArray, IntArray
from surefoot.estimation.ground_plane import GroundPlane
from surefoot.estimation.tosses import Cube


@dataclass(frozen=True)
class TossParameter:
    """A number to be fitted.

    Attributes
    ----------
    name, unit
        What it is called, and its unit ("" for none).
    low, high
        Its range.
    logarithmic
        Whether the search takes ratios for distances.
    """

    name: str
    low: float
    high: float
    unit: str = ""
    logarithmic: bool = False

    def value(self, share: FloatArray) -> FloatArray:
        """Return the values (...,), in `unit`, for shares (...,) of the range in [0, 1], 0 being `low`."""
        if self.logarithmic:
            return np.asarray(self.low * (self.high / self.low) ** share)
        return np.asarray(self.low + (self.high - self.low) * share)


class TossScene(NamedTuple):
    """What is known of tosses before a model of contact is fitted.

    Attributes
    ----------
    starts
        (B, 13) position, quaternion (x, y, z, w), velocity, angular velocity, all in world axes.
    frames
        (B,) frames of each toss.
    dt
        Time between them [s].
    plane
        The ground.
    gravity
        [m/s²], along -z of the world.
    cube
        What was thrown.
    """

    starts: FloatArray
    frames: IntArray
    dt: float
    plane: GroundPlane
    gravity: float
    cube: Cube

    def subset(self, which: IntArray) -> TossScene:
        """Return the scene of the tosses with these indices (b,)."""
        return self._replace(starts=self.starts[which], frames=self.frames[which])


class TossModel(Protocol):
    """A simulator of tosses."""

    @property
    def name(self) -> str:
        """What it is called."""
        ...

    @property
    def parameters(self) -> tuple[TossParameter, ...]:
        """What can be fitted."""
        ...

    def rollout(self, values: FloatArray, scene: TossScene) -> FloatArray:
        """Return (sum of frames, 7) positions [m] and quaternions, for (d,) values of the parameters."""
        ...
