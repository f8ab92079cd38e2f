"""What a soft contact law is: a force from gap and velocity, its Jacobian, its energy; friction under it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, finite_array, real_number
from surefoot.base.errors import ProblemError


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


class ForceJacobian(NamedTuple):
    """Derivatives of a contact force.

    Attributes
    ----------
    gap
        (..., 3) of the force with respect to the gap [N/m].
    velocity
        (..., 3, 3) of the force with respect to the contact velocity [N s/m].
    """

    gap: FloatArray
    velocity: FloatArray


@dataclass(frozen=True)
class SoftLaw(ABC):
    """A compliant contact: never a pull, no force across a gap, friction as a share of the normal force.

    In contact axes (tangent, tangent, normal), forces on the robot, velocities of the robot's point relative
    to the ground; the gap is negative where they overlap.

    Attributes
    ----------
    friction
        A `Friction`, or a coefficient for exact friction.
    """

    friction: Friction = field(default_factory=ExactFriction, kw_only=True)

    def __post_init__(self) -> None:
        object.__setattr__(self, "friction", as_friction(self.friction))

    @abstractmethod
    def pressed(self, depth: FloatArray, rate: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the law's formula where bodies overlap, before a pull is cut off.

        Parameters
        ----------
        depth
            (...,) overlap, >= 0 [m].
        rate
            (...,) its rate of growth [m/s].

        Returns
        -------
        (...,) the normal force [N], its derivative with respect to depth [N/m] and to rate [N s/m].
        """

    @abstractmethod
    def stored(self, depth: FloatArray) -> FloatArray:
        """Return the energy that (...,) overlap [m] stores [J]; its derivative is the force at rest."""

    def normal(self, gap: ArrayLike, speed: ArrayLike) -> FloatArray:
        """Return the normal force [N] from (...,) gaps [m] and separation speeds [m/s], broadcast."""
        return self._normal(gap, speed)[0]

    def _normal(self, gap: ArrayLike, speed: ArrayLike) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return force, d/dgap, d/dspeed; zero where there is a gap or the formula would pull."""
        apart, parting = np.broadcast_arrays(finite_array("gap", gap), finite_array("speed", speed))
        force, by_depth, by_rate = self.pressed(np.maximum(-apart, 0.0), -parting)
        on = (apart < 0.0) & (force > 0.0)
        return np.where(on, force, 0.0), np.where(on, -by_depth, 0.0), np.where(on, -by_rate, 0.0)

    def force(self, gap: ArrayLike, velocity: ArrayLike) -> FloatArray:
        """Return the contact force on the robot.

        Parameters
        ----------
        gap
            (...,) signed distance [m].
        velocity
            (..., 3) velocity of the robot's point relative to the ground [m/s].

        Returns
        -------
        (..., 3) force in contact axes [N].
        """
        moving = _velocities(velocity)
        normal = self.normal(gap, moving[..., 2])
        tangential = normal[..., None] * self.friction.ratio(moving[..., :2])
        return np.concatenate([tangential, normal[..., None]], axis=-1)

    def jacobian(self, gap: ArrayLike, velocity: ArrayLike) -> ForceJacobian:
        """Return the derivatives of `force`; at touchdown and at the onset of a pull those without contact.

        Gaps (...,) [m] and velocities (..., 3) [m/s] are those of `force`.

        Raises
        ------
        ProblemError
            Where exact friction is at rest: there is no derivative.
        """
        moving = _velocities(velocity)
        force, by_gap, by_speed = self._normal(gap, moving[..., 2])
        sliding = np.broadcast_to(moving, (*force.shape, 3))[..., :2]
        ratio = self.friction.ratio(sliding)
        ones = np.ones((*force.shape, 1))
        direction = np.concatenate([ratio, ones], axis=-1)
        by_velocity = np.zeros((*force.shape, 3, 3))
        on = force > 0.0
        if on.any():
            by_velocity[on, :2, :2] = force[on][:, None, None] * self.friction.slope(sliding[on])
        by_velocity[..., :, 2] = direction * by_speed[..., None]
        return ForceJacobian(direction * by_gap[..., None], by_velocity)

    def energy(self, gap: ArrayLike) -> FloatArray:
        """Return the stored energy [J] at (...,) gaps [m]."""
        return self.stored(np.maximum(-finite_array("gap", gap), 0.0))

    def over_step(
        self, gap: FloatArray, speed: FloatArray, arriving: FloatArray, dt: float
    ) -> tuple[FloatArray, FloatArray]:
        """Return the formula at the end of an implicit step, and how steeply it falls with the speed there.

        Parameters
        ----------
        gap
            (...,) at the beginning of the step [m].
        speed, arriving
            (...,) normal velocities over the step and before it [m/s]; only a law that speaks of
            accelerations (MuJoCo's) asks for the second.
        dt
            Step [s].

        Returns
        -------
        (...,) the normal force [N], a pull not cut off, and minus its derivative by `speed` [N s/m]; where
        the step ends above the ground, those at the surface.
        """
        force, by_depth, by_rate = self.pressed(np.maximum(-(gap + dt * speed), 0.0), -speed)
        return force, dt * by_depth + by_rate

    def words(self, engine: str) -> dict[str, Any] | None:
        """Return this law's parameters where it is an engine's own law, None otherwise."""
        return None

    def rest_depth(self, load: float) -> float:
        """Return the overlap at which the law carries a load at rest [m].

        Parameters
        ----------
        load
            Normal force [N], > 0.
        """
        from scipy.optimize import brentq

        weight = real_number("load", load, low=np.finfo(float).tiny, high=1e300)
        high = 1e-9
        while self._at_rest(high) < weight:
            high *= 2.0
            if high > 1e6:
                raise ProblemError(f"no overlap below 1000 km carries {weight:g} N")
        low = 0.0 if high == 1e-9 else high / 2.0
        if self._at_rest(low) >= weight:
            return low
        return float(brentq(lambda depth: self._at_rest(depth) - weight, low, high, xtol=1e-300, rtol=1e-14))

    def _at_rest(self, depth: float) -> float:
        return float(self.pressed(np.array(depth), np.array(0.0))[0])


def _velocities(velocity: ArrayLike) -> FloatArray:
    """Return (..., 3) velocities."""
    array = finite_array("velocity", velocity)
    if array.ndim == 0 or array.shape[-1] != 3:
        raise ProblemError(f"velocity must have shape (..., 3), got {array.shape}")
    return array
