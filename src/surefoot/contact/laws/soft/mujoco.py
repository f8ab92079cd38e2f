"""MuJoCo's soft contact as a law: what solref and solimp mean for one body.

MuJoCo's documentation, "Solver parameters": the constraint wants the acceleration -b v - k r and yields by
the impedance d(r). For one normal contact its convex program has the solution f = d m (-b v - k r - a0), a0
the acceleration without the contact (see docs/translate.md for the derivation, tests/worlds for the engine).
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray, finite_array, real_number
from surefoot.base.errors import ProblemError
from surefoot.base.spatial import GRAVITY
from surefoot.contact.laws.soft.soft_law import SoftLaw

IMPEDANCE_RANGE = (0.0001, 0.9999)
"""Bounds that MuJoCo puts on the impedance (mjMINIMP, mjMAXIMP)."""


@dataclass(frozen=True)
class MujocoLaw(SoftLaw):
    """f_n = max(0, -mass d(r) (b v + k r + free_acceleration)).

    Attributes
    ----------
    solref
        (time constant [s], damping ratio), both > 0; or (-stiffness [1/s²], -damping [1/s]), both <= 0.
    solimp
        (d_min, d_max, width [m], midpoint, power), or fewer: MuJoCo's defaults fill the rest.
    mass
        Effective mass of the contact, 1 / G_nn [kg]: MuJoCo's force is proportional to it.
    free_acceleration
        Normal acceleration that the body would have without the contact [m/s²], -g for a body that rests.
    dt
        Step [s]: MuJoCo raises a positive time constant to two of them (`refsafe`); 0 leaves it alone.

    Examples
    --------
    >>> round(1e3 * MujocoLaw(mass=4.0).rest_depth(4.0 * 9.81), 6)
    0.367182
    """

    solref: tuple[float, float] = (0.02, 1.0)
    solimp: tuple[float, ...] = (0.9, 0.95, 0.001, 0.5, 2.0)
    mass: float = 1.0
    free_acceleration: float = -GRAVITY
    dt: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        ref = finite_array("solref", self.solref, (2,))
        if not ((ref[0] > 0.0 and ref[1] > 0.0) or (ref <= 0.0).all()):
            raise ProblemError(
                f"solref must be (time constant, damping ratio), both > 0, or (-stiffness, -damping), both "
                f"<= 0, got {tuple(self.solref)}"
            )
        imp = finite_array("solimp", self.solimp)
        if imp.ndim != 1 or not 1 <= imp.size <= 5:
            raise ProblemError(f"solimp must hold 1 to 5 numbers, got {self.solimp}")
        whole = (*map(float, imp), *(0.9, 0.95, 0.001, 0.5, 2.0)[imp.size :])
        object.__setattr__(self, "solimp", whole)
        object.__setattr__(self, "solref", (float(ref[0]), float(ref[1])))
        real_number("mass", self.mass, low=1e-12, high=1e12)
        real_number("free_acceleration", self.free_acceleration, low=-1e12, high=1e12)
        real_number("dt", self.dt, low=0.0, high=1e3)

    @property
    def stiffness_and_damping(self) -> tuple[float, float]:
        """Return k / d(r) [1/s²] and b [1/s] of the reference acceleration."""
        # Standard form: b = 2 / (d_max T), k = 1 / (d_max T ζ)², so that a unit mass under d_max has the time
        # constant T and the damping ratio ζ; direct form: the numbers over d_max² and d_max.
        largest = _limit_impedance(self.solimp[1])
        first, second = self.solref
        if first > 0.0:
            time = max(first, 2.0 * self.dt)
            return 1.0 / (largest * time * second) ** 2, 2.0 / (largest * time)
        return -first / largest**2, -second / largest

    @property
    def bounded_solimp(self) -> tuple[float, float, float, float, float]:
        """Return solimp [-, -, m, -, -] within the bounds that MuJoCo puts on it."""
        low, high, width, middle, power = self.solimp
        return _limit_impedance(low), _limit_impedance(high), width, _limit_impedance(middle), max(power, 1.0)

    def impedance(self, depth: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return d(r) and its derivative by depth [1/m] at (...,) depths [m]."""
        low, high, width, middle, power = self.bounded_solimp
        if low == high or width <= 1e-15:
            return np.full(np.shape(depth), 0.5 * (low + high)), np.zeros(np.shape(depth))
        # Two powers that meet at (middle, middle) with one slope: y = m (x / m)^p below the midpoint m, and
        # y = 1 - (1 - m) ((1 - x) / (1 - m))^p above; dy/dx = p (...)^(p-1) on both sides.
        x = np.clip(np.abs(depth) / width, 0.0, 1.0)
        before = x <= middle
        rise, fall = np.where(before, x, middle) / middle, np.where(before, middle, 1.0 - x) / (1.0 - middle)
        share = np.where(before, middle * rise**power, 1.0 - (1.0 - middle) * fall**power)
        slope = power * np.where(before, rise ** (power - 1.0), fall ** (power - 1.0))
        slope = np.where(x < 1.0, slope, 0.0)  # constant beyond the width
        return low + share * (high - low), slope * (high - low) / width

    def pressed(self, depth: FloatArray, rate: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the force, its derivative by depth and by rate; see `SoftLaw.pressed`."""
        stiff, damp = self.stiffness_and_damping
        d, slope = self.impedance(depth)
        wanted = damp * rate + stiff * d * depth - self.free_acceleration
        # product rule on d(r) (b v + k d(r) r - a0): the reference's stiffness k itself carries a factor d(r)
        by_depth = self.mass * (slope * wanted + d * stiff * (d + slope * depth))
        return self.mass * d * wanted, by_depth, self.mass * d * damp

    def over_step(
        self, gap: FloatArray, speed: FloatArray, arriving: FloatArray, dt: float
    ) -> tuple[FloatArray, FloatArray]:
        """Return MuJoCo's force from the acceleration that the step really makes; see `SoftLaw.over_step`.

        Its program says f (1 - d) / (d mass) = -b v - k r - a with a the acceleration *with* all contacts;
        for one contact of effective mass `mass` that is the class's formula. `free_acceleration` is not used.
        """
        stiff, damp = self.stiffness_and_damping
        depth = np.maximum(-(gap + dt * speed), 0.0)
        d, rise = self.impedance(depth)
        wanted = -damp * speed + stiff * d * depth - (speed - arriving) / dt
        # f (1 - d) / (d m) = wanted solved for f; its derivative by d is m / (1 - d)²
        gain = self.mass * d / (1.0 - d)
        by_depth = self.mass * rise / (1.0 - d) ** 2 * wanted + gain * stiff * (rise * depth + d)
        return gain * wanted, dt * by_depth + gain * (damp + 1.0 / dt)

    def stored(self, depth: FloatArray) -> FloatArray:
        """Return the work that a slow overlap (...,) [m] takes [J], by quadrature: the force at rest."""
        deep = np.asarray(depth, dtype=float)
        stiff, _ = self.stiffness_and_damping
        node, weight = np.polynomial.legendre.leggauss(24)
        marks = self.solimp[2] * np.array([0.0, self.solimp[3], 1.0])
        edges = [np.minimum(deep, mark) for mark in marks] + [
            deep
        ]  # the impedance is smooth between its marks
        total = np.zeros(deep.shape)
        for low, high in itertools.pairwise(edges):
            half = 0.5 * (high - low)[..., None]
            at = low[..., None] + half * (node + 1.0)
            d = self.impedance(at)[0]
            force = np.maximum(self.mass * d * (stiff * d * at - self.free_acceleration), 0.0)
            total = total + (half * weight * force).sum(axis=-1)
        return total

    def words(self, engine: str) -> dict[str, Any] | None:
        """Return solref, solimp, and the mass and gravity for which they mean this law."""
        own = {
            "mass": self.mass,
            "gravity": -self.free_acceleration,
            "solref": self.solref,
            "solimp": self.solimp,
        }
        return own if engine == "mujoco" else None


def _limit_impedance(impedance: float) -> float:
    """Return an impedance within `IMPEDANCE_RANGE`, as MuJoCo takes it."""
    return min(max(impedance, IMPEDANCE_RANGE[0]), IMPEDANCE_RANGE[1])
