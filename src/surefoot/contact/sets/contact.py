"""What a contact is: which forces it can carry, as a convex set with three operations.

A contact has rows in the order of a wrench, [force; moment], tangents before the normal; `normal` is the
row of the normal force. Its set is a stack of sections, {λ : low <= λ_n <= high, λ_t in λ_n C}, and C a
product of discs (`Factor`): what a disc limits is ||λ_b|| <= radius · λ_n. Friction discs dissipate; the
others (the centre of pressure within a sole) belong to unilateral contact.

Moments are counted over a length of the contact (`lengths`), so that all rows are newtons and all velocities
m/s: the nearest force is nearest in that metric, and so is every error.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from surefoot.base.arrays import FloatArray, real_number
from surefoot.base.errors import ProblemError

MOST_FRICTION = 1e150
"""Largest friction coefficient [-]: beyond it squares overflow, and forces outside the cone would pass."""
APPROACH = math.sqrt(0.5)
"""Least velocity error of a contact, as a share of its speed of approach [-]. The distance to K* shows
1 / sqrt(1 + mu²) of it: no less than this share where mu is at most one, nothing where mu is huge."""


@dataclass(frozen=True)
class Factor:
    """A disc of the section: rows whose norm, over their lengths, is at most radius times the normal force.

    Attributes
    ----------
    rows
        Of the contact.
    radius
        Limit per newton of normal force [-], >= 0.
    friction
        Whether what it limits is friction.
    """

    rows: tuple[int, ...]
    radius: float
    friction: bool = True


@dataclass(frozen=True, kw_only=True)
class ContactKind:
    """One contact and the forces that it can carry; see the module.

    Parameters
    ----------
    normal_min, normal_max
        Bounds of the normal force [N]; normal_max = 0 switches the contact off.

    Attributes
    ----------
    rows, normal
        Number of rows, and the one of the normal force.
    bilateral
        Whether it carries any force.

    Raises
    ------
    ProblemError
        If a parameter is out of range.
    """

    normal_min: float = 0.0
    normal_max: float = math.inf
    rows: ClassVar[int] = 3
    normal: ClassVar[int] = 2
    bilateral: ClassVar[bool] = False
    _sizes: ClassVar[tuple[str, ...]] = ()
    """Names of the parameters beside mu that are finite and >= 0."""

    def __post_init__(self) -> None:
        low = real_number("normal_min", self.normal_min, low=0.0)
        high = real_number("normal_max", self.normal_max, low=0.0)
        if not (low < math.inf and low <= high):
            raise ProblemError(f"normal_min must be finite and <= normal_max, got {low:g} and {high:g}")
        for name in ("mu", *self._sizes):
            real_number(name, getattr(self, name, 0.0), low=0.0, high=MOST_FRICTION)

    @property
    def coefficient(self) -> float:
        """The friction coefficient mu [-], 0 where there is none."""
        return float(getattr(self, "mu", 0.0))

    @property
    def polygon(self) -> tuple[int, bool] | None:
        """Sides of a polygonal section and whether it is inside the disc; None for discs."""
        return None

    @cached_property
    def lengths(self) -> FloatArray:
        """The (rows,) lengths [m] that moments are counted over; 1 for forces."""
        return np.ones(self.rows)

    @property
    def factors(self) -> tuple[Factor, ...]:
        """The discs of the section."""
        return ()

    @property
    def discs_inside(self) -> tuple[Factor, ...]:
        """Discs within the section: its own, unless it is a polygon; proofs need no more."""
        return self.factors

    @property
    def short_form(self) -> tuple[int | None, str] | None:
        """Facets and fit where `ContactProblem(G, g, mu, ...)` can say the same, else None."""
        return None

    def project(self, force: FloatArray) -> FloatArray:
        """Return the nearest force of the set: (rows,) [N, N m]."""
        return self.nearest(np.asarray(force) / self.lengths, self.normal_min, self.normal_max) * self.lengths

    def nearest(self, y: FloatArray, low: float, high: float) -> FloatArray:
        """Return the nearest point (rows,) [N] under other bounds [N], with moments counted over lengths.

        The distance to the section of height s is Σ (||y_b|| - r_b s)₊², convex in s and a parabola between
        the heights where a disc begins to hold: the discs are let in from the tightest on.
        """
        s, sizes = self._height(y, low, high)
        out = np.array(y, dtype=np.float64)
        out[self.normal] = s
        for b, size in zip(self.factors, sizes, strict=True):
            if size > b.radius * s:
                out[list(b.rows)] *= b.radius * s / size
        return out

    def _height(self, y: FloatArray, low: float, high: float) -> tuple[float, list[float]]:
        """Return the normal force of the nearest point, and the norms of the discs' rows."""
        sizes = [float(np.linalg.norm(y[list(b.rows)])) for b in self.factors]
        discs = sorted(
            (
                (size / b.radius, size, b.radius)
                for b, size in zip(self.factors, sizes, strict=True)
                if b.radius
            ),
            reverse=True,
        )
        push, slope = float(y[self.normal]), 1.0
        s = push
        for height, size, radius in discs:
            if s >= height:
                break
            push, slope = push + radius * size, slope + radius * radius
            s = push / slope
        return min(max(s, low, 0.0), high), sizes

    def support(self, direction: FloatArray) -> float:
        """Return sup of direction (rows,) · λ over the set, in the unit of both; infinite without a bound."""
        slope = float(direction[self.normal]) + self.reach(direction)
        if slope > 0.0:
            return self.normal_max * slope if self.normal_max > 0.0 else 0.0
        return self.normal_min * slope

    def reach(self, direction: FloatArray, friction: bool | None = None) -> float:
        """Return sup of direction (rows,) · λ over the section λ_n = 1, in the unit of both.

        The normal's part is left out.

        Of all discs, or of those that are friction or are not.
        """
        d = np.asarray(direction) * self.lengths
        return float(
            sum(
                b.radius * float(np.linalg.norm(d[list(b.rows)]))
                for b in self.factors
                if friction is None or b.friction == friction
            )
        )

    def shift(self, velocity: FloatArray) -> float:
        """Return De Saxcé's shift Γ(u) of u (rows,): the most power that friction takes out per newton [m/s].

        The law of maximum dissipation is that friction does: λ_t · u_t = -λ_n Γ(u).
        """
        return self.reach(-np.asarray(velocity), friction=True)

    def power(self, force: FloatArray, velocity: FloatArray, friction: bool) -> float:
        """Return the power of the rows whose discs are friction, or are not [W]: force, velocity (rows,)."""
        rows = [row for b in self.factors if b.friction == friction for row in b.rows]
        return float(np.asarray(force)[rows] @ np.asarray(velocity)[rows])

    def residual(
        self, force: FloatArray, velocity: FloatArray, weight: float, shift: float = 1.0, scale: float = 1.0
    ) -> float:
        """Return ε = w ||λ - P_K(λ - (u + θ Γ(u)) / w)|| in the contact's metric [m/s].

        Or `APPROACH` times the speed of approach, where that is more; see `contact.problem.scales`.

        Parameters
        ----------
        force, velocity
            (rows,) of the contact [N s, N m s] and [m/s, rad/s].
        weight
            w > 0, the velocity that a newton makes [m/s/N].
        shift
            θ of the law [-].
        scale
            What the normal bounds are multiplied with [-]: the forces may be given in another unit.
        """
        v = np.asarray(velocity) * self.lengths
        v[self.normal] += shift * self.shift(velocity)
        own = weight * np.asarray(force) / self.lengths
        p = own - v
        unit = weight * scale
        low, high = unit * self.normal_min, unit * self.normal_max if self.normal_max > 0.0 else 0.0
        # v - (P(p) - p): velocities are added to velocities, whatever the size of λ; w λ - P(p) for a huge Γ
        nearest = self.nearest(p, low, high)
        gap = own - nearest if np.abs(v).sum() > np.abs(own).sum() else v - (nearest - p)
        approach = APPROACH * min(-float(velocity[self.normal]), high - float(own[self.normal]))
        return max(float(np.linalg.norm(gap)), approach)
