"""A flat sole: the wrenches that Coulomb friction at its corners can give, exactly.

Coulomb's law in every point of a flat sole allows the pressures and tangential forces whose sum is a sum of
forces in the friction cones of its corners: a force at a point within is one of forces at the corners in the
same cone (S. Caron, Q.-C. Pham, Y. Nakamura, "Stability of surface contacts for humanoid robots", ICRA 2015).
The set is a cone, the Minkowski sum of the corners' cones, with the normal force pressing at the centre
inside it.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import BoolArray, FloatArray, finite_array, numbers, positive_number, real_number
from surefoot.base.drawn import Drawn
from surefoot.base.errors import ProblemError
from surefoot.contact.cones.sole_shape import edge_names, outline, outward, shape_of

if TYPE_CHECKING:
    from surefoot.contact.cones.cone import Fit
    from surefoot.contact.cones.sole_answers import SoleUse, SoleVerdict
    from surefoot.contact.cones.sole_rows import SolePolyhedron

MOST_MU = 1e100
"""Largest friction coefficient of a sole [-]: squares beyond it overflow."""


class Sole(Drawn):
    """A flat sole of length x width, or any convex polygon of corners (`Sole.of_corners`).

    Parameters
    ----------
    length, width
        Full size along the contact frame's x and y [m], > 0; the frame is in the middle.
    mu
        Friction coefficient [-], finite and >= 0.
    torsional_radius
        Radius [m], >= 0, of the pad that each corner stands for: beside a force it resists a yaw moment,
        sqrt(|f_t|² + (moment / radius)²) <= mu f_n, as `sf.contact_sets.SoftFinger` does. Pressed at its
        centre the sole resists up to mu f_z radius more. 0 is Coulomb's law for points.

    Attributes
    ----------
    corners
        (k, 2) corners in the contact frame [m], clockwise from the front left.
    radius
        Length that moments are counted over in sizes and for the nearest wrench [m]: the largest distance of
        a corner from `centre`, their mean.

    Raises
    ------
    ProblemError
        If a size is not positive and finite, mu negative or infinite, or corners lie on one line.

    Notes
    -----
    Wrenches are [force; moment] about the contact frame's origin, z out of the ground: (..., 6) [N, N m].

    Examples
    --------
    >>> sole = Sole(length=0.22, width=0.09, mu=0.6)
    >>> push = [55.0, 0.0, 100.0, 0.0, 0.0, 0.0]
    >>> bool(sole.contains(push)), round(float(sole.margin(push)), 6)
    (True, 8.333333)
    >>> round(float(sole.friction_needed(push)), 6)
    0.55
    >>> sole.use(push).binds.item()
    'friction'
    """

    dim = 6

    def __init__(self, length: float, width: float, mu: float = 0.6, torsional_radius: float = 0.0) -> None:
        half = 0.5 * positive_number("length", length), 0.5 * positive_number("width", width)
        self.length: float | None = 2.0 * half[0]
        self.width: float | None = 2.0 * half[1]
        self._set(np.array(half) * [[1.0, 1.0], [1.0, -1.0], [-1.0, -1.0], [-1.0, 1.0]], mu, torsional_radius)

    @classmethod
    def of_corners(cls, corners: ArrayLike, mu: float = 0.6, torsional_radius: float = 0.0) -> Sole:
        """Return the sole with corners (k, 2) in the contact frame [m], the convex hull of what is given.

        >>> Sole.of_corners([[0.1, 0.0], [-0.1, 0.05], [-0.1, -0.05], [0.0, 0.0]], mu=0.6)
        Sole(3 corners, mu=0.6)
        """
        sole = cls.__new__(cls)
        sole.length = sole.width = None
        sole._set(outline(corners), mu, torsional_radius)
        return sole

    def _set(self, corners: FloatArray, mu: float, torsional_radius: float) -> None:
        self.corners = outline(corners) if self.length is None else corners
        self.mu = real_number("mu", mu, low=0.0)
        if self.mu > MOST_MU:
            raise ProblemError(f"a sole needs a finite mu, got {self.mu:g}")
        self.torsional_radius = real_number("torsional_radius", torsional_radius, low=0.0, high=1e6)

    def __repr__(self) -> str:
        size = (
            f"{len(self.corners)} corners"
            if self.length is None or self.width is None
            else f"length={self.length:g}, width={self.width:g}"
        )
        pads = f", torsional_radius={self.torsional_radius:g}" if self.torsional_radius else ""
        return f"Sole({size}, mu={self.mu:g}{pads})"

    def __str__(self) -> str:
        size = 1e2 * np.ptp(self.corners, axis=0)
        pads = f", pads of {1e3 * self.torsional_radius:g} mm" if self.torsional_radius else ""
        kind = f"{len(self.corners)} corners, mu {self.mu:g}{pads}"
        return f"A sole of {size[0]:.3g} x {size[1]:.3g} cm with {kind}."

    @cached_property
    def _data(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """What every kernel is given: numbers, table, start and edges."""
        shape = shape_of(self.corners, self.torsional_radius)
        few = [*shape.centre, shape.length, self.torsional_radius / shape.length, self.mu]
        return np.array(few), shape.table, shape.start, shape.edges

    @property
    def centre(self) -> FloatArray:
        """(2,) mean of the corners in the contact frame [m]."""
        return self._data[0][:2].copy()

    @property
    def radius(self) -> float:
        """Largest distance of a corner from the centre [m]."""
        return float(self._data[0][2])

    @cached_property
    def edge_names(self) -> tuple[str, ...]:
        """A name for the edge from each corner to the next one: toe, right, heel, left."""
        return edge_names(outward(self.corners))

    def with_friction(self, mu: float) -> Sole:
        """Return the same sole with another friction coefficient [-]."""
        twin = Sole.__new__(Sole)
        twin.length, twin.width = self.length, self.width
        twin._set(self.corners, mu, self.torsional_radius)
        return twin

    def contains(self, wrench: ArrayLike, tol: float = 1e-9) -> BoolArray:
        """Tell whether wrenches (..., 6) [N, N m] are in the cone: (...); what is not finite is not.

        One that lacks no more than tol [-] times max(1 N, its size) of normal force at the centre counts as
        in it; its size is sqrt(||f||² + ||m||² / radius²).
        """
        w = self._wrenches(wrench)
        flags = np.empty(len(w), dtype=np.int8)
        if _kernels().hold(*self._data, w, tol, flags):
            from surefoot.contact.cones.sole_proof import hold_in_digits

            unsure = flags == _kernels().UNSURE
            flags[unsure] = hold_in_digits(self, self._data, w, tol, unsure)
        out: BoolArray = flags.view(np.bool_)
        return out.reshape(np.shape(wrench)[:-1]) if np.ndim(wrench) != 1 else out[0]

    def margin(self, wrench: ArrayLike) -> FloatArray:
        """Return the normal force to spare of wrenches (..., 6), pressing at the centre: (...) [N].

        It is the largest normal force that may be taken away at the centre of the sole before the wrench
        leaves the cone, negative for the least that must be added: f_z less the Minkowski gauge of the cone's
        section (R. Rockafellar, "Convex Analysis", section 15). Within 1e-9 of the wrench's size.
        """
        return self._each(wrench, lambda w: w[:, 2] - self._needs(w)[0])

    def use(self, wrench: ArrayLike) -> SoleUse:
        """Return the shares of the cone that wrenches (..., 6) use, and what binds; see `SoleUse`."""
        from surefoot.contact.cones.sole_answers import SoleUse

        w = self._wrenches(wrench)
        needs, shares = self._needs(w)
        force = np.where(w[:, 2] > 0.0, w[:, 2], 0.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            total = np.where(needs == 0.0, np.where(w[:, 2] >= 0.0, 0.0, np.inf), needs / force)
            parts = np.where(shares == 0.0, 0.0, shares / force[:, None])
            parts[parts == -np.inf] = 0.0  # without a normal force nothing helps
        shape = np.shape(wrench)[:-1]
        return SoleUse(total.reshape(shape), *(np.asarray(p).reshape(shape) for p in parts.T))

    def friction_needed(self, wrench: ArrayLike) -> FloatArray:
        """Return the least friction coefficient [-] that holds wrenches (..., 6): (...), infinite for none.

        The torsional radius stays: what the pads resist grows with the friction.
        """

        def find(w: FloatArray) -> FloatArray:
            out = np.empty(len(w))
            _kernels().frictions(*self._data, w, out)
            if (out < 0.0).any():
                from surefoot.contact.cones.sole_proof import frictions_in_digits

                frictions_in_digits(self, self._data, w, out)
            return out

        return self._each(wrench, find)

    def project(self, wrench: ArrayLike) -> FloatArray:
        """Return the nearest wrenches of the cone to wrenches (..., 6): (..., 6) [N, N m].

        Nearest in sqrt(||f||² + ||m||² / radius²) [N], moments about the centre of the sole. Within 1e-6 of
        the wrench's size, mostly 1e-8.
        """
        w = self._wrenches(wrench)
        out = np.empty_like(w)
        if self.mu == 0.0:
            out[:] = self._project_frictionless(w)
        else:
            _kernels().project(*self._data[:2], w, out)
        return out.reshape(np.shape(wrench))

    def support(self, direction: ArrayLike, tol: float = 1e-9) -> FloatArray:
        """Return sup of twist . wrench [W] over the cone for twists (..., 6) [m/s, rad/s]: zero or infinity.

        It is 0 where no corner force has a positive product with the direction, a twist [linear; angular]:
        within tol [-] times max(1, its size) of a newton of normal force.
        """
        from surefoot.contact.cones.sole_proof import resistance

        d = self._wrenches(direction)
        size = np.sqrt((d[:, :3] ** 2).sum(axis=1) + (d[:, 3:] ** 2).sum(axis=1) * self.radius**2)
        over = resistance(self, d).max(axis=1)
        return np.asarray(
            np.where(over <= tol * np.maximum(1.0, size), 0.0, np.inf).reshape(np.shape(direction)[:-1])
        )

    def verdict(self, wrench: ArrayLike, tol: float = 1e-9) -> SoleVerdict:
        """Tell whether the sole holds a wrench (6,) [N, N m], with corner forces or a twist as the proof.

        Proofs are checked here from the corners alone, within tol [-] times max(1 N, the wrench's size).
        """
        from surefoot.contact.cones.sole_proof import verdict_on

        return verdict_on(self, self._data, finite_array("wrench", wrench, (6,)), tol)

    def polyhedral(self, facets: int = 8, fit: Fit = "inner") -> SolePolyhedron:
        """Return the sum of the corners' friction pyramids, inside or around this cone, as named rows.

        Parameters
        ----------
        facets
            Sides of each corner's pyramid, >= 3.
        fit
            "inner" never promises a wrench that the ground cannot give, "outer" never forbids one that it
            can.

        Raises
        ------
        ProblemError
            For fewer than three facets, an unknown fit, or a sole with a torsional radius.
        """
        from surefoot.contact.cones.sole_rows import corner_pyramids

        self._refuse_pads()
        return corner_pyramids(self.corners, self.mu, facets, fit)

    def closed_form(self, fit: Fit = "inner") -> SolePolyhedron:
        """Return Caron's sixteen rows of a rectangle: the corners' pyramids of four sides along its own axes.

        Inside, friction along the axes is mu / sqrt(2): it gives up 29 %.

        Raises
        ------
        ProblemError
            For a sole that is no rectangle, or has a torsional radius, or an unknown fit.
        """
        from surefoot.contact.cones.sole_rows import caron_rows

        self._refuse_pads()
        if self.length is None or self.width is None:
            raise ProblemError("the closed form is of a rectangle, Sole(length, width); take Sole.polyhedral")
        return caron_rows(self.length, self.width, self.mu, fit)

    def _refuse_pads(self) -> None:
        if self.torsional_radius > 0.0:
            raise ProblemError(
                "polyhedral forms are of soles without a torsional radius: a pad's limit is an ellipsoid"
            )

    def _needs(self, w: FloatArray) -> tuple[FloatArray, FloatArray]:
        needs, shares = np.empty(len(w)), np.empty((len(w), 3))
        _kernels().measure(*self._data, w, needs, shares)
        if np.isnan(needs).any():
            from surefoot.contact.cones.sole_proof import measure_in_digits

            measure_in_digits(self, self._data, w, needs, shares)
        return needs, shares

    def _each(self, wrench: ArrayLike, question: Callable[[FloatArray], FloatArray]) -> FloatArray:
        return np.asarray(question(self._wrenches(wrench)).reshape(np.shape(wrench)[:-1]))

    def _wrenches(self, wrench: ArrayLike) -> FloatArray:
        """Return wrenches as (n, 6)."""
        w = numbers("wrench", wrench)
        if w.ndim == 0 or w.shape[-1] != 6:
            raise ProblemError(f"expected wrenches of shape (..., 6), got {w.shape}")
        return w.reshape(-1, 6)

    def _project_frictionless(self, w: FloatArray) -> FloatArray:
        """Return the nearest wrenches of normal forces at the corners alone."""
        from surefoot.contact.cones.nearest import nearest_in_cone
        from surefoot.contact.cones.sole_proof import count_moments

        x, y, length = self._data[0][:3]
        table = self._data[1]
        rays = np.column_stack([np.ones(len(table)), table[:, 2:4]])
        about = np.array([count_moments(self, one) for one in w]).reshape(-1, 6)
        near = np.full((len(w), 3), np.nan)
        finite = np.isfinite(about).all(axis=1)
        near[finite] = nearest_in_cone(rays, about[finite][:, 2:5])
        out = np.zeros((len(w), 6))
        out[:, 2], out[:, 3] = near[:, 0], near[:, 1] * length + y * near[:, 0]
        out[:, 4] = near[:, 2] * length - x * near[:, 0]
        return out


@cache
def _kernels() -> Any:
    """Return the compiled questions, which are loaded with the first of them."""
    from surefoot.contact.cones import sole_kernels

    return sole_kernels
