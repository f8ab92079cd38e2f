"""Coulomb friction under a soft law: exact, or regularised so that it has a slope at rest."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from surefoot.arrays import FloatArray, real_number
from surefoot.errors import ProblemError


@dataclass(frozen=True)
class Friction(ABC):
    """Friction force as a share of the normal force, from the sliding velocity.

    Attributes
    ----------
    mu
        Friction coefficient [-], >= 0.
    exact
        Whether it is Coulomb's law itself, which a contact problem solves.
    """

    exact: ClassVar[bool] = False
    mu: float = 0.6

    def __post_init__(self) -> None:
        real_number("mu", self.mu, low=0.0, high=1e12)

    @abstractmethod
    def ratio(self, sliding: FloatArray) -> FloatArray:
        """Return f_t / f_n for (..., 2) sliding velocities [m/s]; (..., 2), of norm <= mu."""

    @abstractmethod
    def slope(self, sliding: FloatArray) -> FloatArray:
        """Return the derivative of `ratio`, (..., 2, 2) [s/m]."""


@dataclass(frozen=True)
class ExactFriction(Friction):
    """Coulomb's law: -mu v_t / ||v_t|| where it slides.

    A foot that rests may take any force in the disc: as a function of the velocity the law then gives the
    least one, zero, and which one it is must be asked of a contact problem (`surefoot.solve`).
    """

    exact: ClassVar[bool] = True

    def ratio(self, sliding: FloatArray) -> FloatArray:
        """Return f_t / f_n for (..., 2) sliding velocities [m/s]; zero at rest."""
        speed = np.linalg.norm(sliding, axis=-1, keepdims=True)
        moving = speed > 0.0
        return np.where(moving, -self.mu * sliding / np.where(moving, speed, 1.0), 0.0)

    def slope(self, sliding: FloatArray) -> FloatArray:
        """Return the derivative of `ratio`, (..., 2, 2) [s/m].

        Raises
        ------
        ProblemError
            At rest, where there is none.
        """
        speed = np.linalg.norm(sliding, axis=-1)
        if self.mu == 0.0:
            return np.zeros((*speed.shape, 2, 2))
        if not (speed > 0.0).all():
            raise ProblemError(
                "exact friction has no derivative at zero sliding velocity; use RegularisedFriction, or the "
                "derivative of a contact problem's solution"
            )
        along = sliding / speed[..., None]
        across = np.eye(2) - along[..., :, None] * along[..., None, :]
        slope: FloatArray = -self.mu * across / speed[..., None, None]
        return slope


@dataclass(frozen=True)
class RegularisedFriction(Friction):
    """-mu v_t / sqrt(||v_t||² + v_s²): smooth, never above mu, and it creeps.

    A foot that holds the share r < 1 of its friction moves at v_s r / sqrt(1 - r²): 1.3 v_s at 80 %.

    Attributes
    ----------
    slip_speed
        v_s [m/s], > 0.
    """

    slip_speed: float = 1e-3

    def __post_init__(self) -> None:
        super().__post_init__()
        if not 0.0 < real_number("slip_speed", self.slip_speed) < np.inf:
            raise ProblemError(f"slip_speed must be a finite speed > 0 [m/s], got {self.slip_speed:g}")

    def ratio(self, sliding: FloatArray) -> FloatArray:
        """Return f_t / f_n for (..., 2) sliding velocities [m/s]."""
        ratio: FloatArray = -self.mu * sliding / self._speed(sliding)[..., None]
        return ratio

    def slope(self, sliding: FloatArray) -> FloatArray:
        """Return the derivative of `ratio`, (..., 2, 2) [s/m]."""
        speed = self._speed(sliding)[..., None, None]
        outer = sliding[..., :, None] * sliding[..., None, :]
        slope: FloatArray = -self.mu * (np.eye(2) - outer / speed**2) / speed
        return slope

    def creep(self, use: float) -> float:
        """Return the sliding speed of a foot that holds a share `use` of its friction [m/s].

        >>> round(RegularisedFriction(slip_speed=1e-3).creep(0.8), 6)
        0.001333
        """
        share = real_number("use", use, low=0.0, high=1.0)
        return float(np.inf) if share == 1.0 else self.slip_speed * share / float(np.sqrt(1.0 - share**2))

    def _speed(self, sliding: FloatArray) -> FloatArray:
        speed: FloatArray = np.hypot(np.linalg.norm(sliding, axis=-1), self.slip_speed)
        return speed


def as_friction(friction: Friction | ArrayLike) -> Friction:
    """Return a friction law; a number is the coefficient of exact friction, see `ExactFriction`."""
    return friction if isinstance(friction, Friction) else ExactFriction(real_number("friction", friction))  # type: ignore[arg-type]
