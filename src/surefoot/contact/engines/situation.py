"""The situation in which contact parameters are translated."""

from __future__ import annotations

from dataclasses import dataclass

from surefoot.spatial import GRAVITY


@dataclass(frozen=True)
class Situation:
    """The situation in which a translation is asked.

    Attributes
    ----------
    mass
        Effective mass of the contact, 1 / G_nn [kg]: of a robot on four feet about a quarter of its own.
    gravity
        [m/s²].
    speed
        Impact speed at which bounces are compared [m/s].
    dt
        The engine's step [s].
    area, thickness
        Of a flat compliant layer, for hydroelastic moduli [m²], [m]; 0 if unknown.
    keep
        What is kept where rest depth and motion cannot both be: "motion" or "rest".
    impedance
        MuJoCo's d of the translated contact.
    """

    mass: float
    gravity: float = GRAVITY
    speed: float = 1.0
    dt: float = 1e-3
    area: float = 0.0
    thickness: float = 0.0
    keep: str = "motion"
    impedance: float = 1e-3

    @property
    def weight(self) -> float:
        """Return what the contact carries at rest [N]."""
        return self.mass * self.gravity
