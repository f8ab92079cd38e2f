"""A stance: the contacts that hold a robot, and the map from their forces to one wrench."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import cached_property
from itertools import accumulate, pairwise

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, finite_array, per_contact
from surefoot.base.drawn import Drawn
from surefoot.base.errors import ProblemError, check_name, count_of, shown
from surefoot.base.spatial import skew
from surefoot.contact import Fit, ProductCone
from surefoot.mechanics.stance.contact import Contact, PointContact, SoleContact
from surefoot.mechanics.stance.halfspaces import Axes, HalfSpaces, TwoSidedRows, halfspaces, two_sided


class Stance(Drawn):
    """Contacts in a fixed order; forces are stacked in that order, each in its contact frame.

    Parameters
    ----------
    contacts
        Points and soles; none at all is allowed (a robot in the air).

    Examples
    --------
    >>> feet = [[0.2, 0.15, 0], [0.2, -0.15, 0], [-0.2, 0.15, 0], [-0.2, -0.15, 0]]
    >>> stance = Stance([PointContact(p, mu=0.6) for p in feet])
    >>> stance.grasp_map(about=[0, 0, 0.3]).shape
    (6, 12)
    """

    def __init__(self, contacts: Sequence[Contact]) -> None:
        try:
            self.contacts = tuple(contacts)
        except TypeError as error:
            raise ProblemError(
                f"contacts must be a list, as [sf.PointContact(p)] is one, got {shown(contacts)}"
            ) from error
        for k, contact in enumerate(self.contacts):
            if not isinstance(contact, (PointContact, SoleContact)):
                raise ProblemError(
                    f"contacts[{k}] must be a PointContact or a SoleContact, got {type(contact).__name__}"
                )
        ends = list(accumulate((c.dim for c in self.contacts), initial=0))
        self.slices = tuple(slice(a, b) for a, b in pairwise(ends))
        self.dim = ends[-1]

    def __len__(self) -> int:
        return len(self.contacts)

    def __iter__(self) -> Iterator[Contact]:
        return iter(self.contacts)

    def __repr__(self) -> str:
        return f"Stance([{', '.join(c.name or type(c).__name__ for c in self.contacts)}])"

    def __str__(self) -> str:
        soles = sum(c.dim == 6 for c in self.contacts)
        kinds = [count_of(len(self) - soles, "point")] if soles < len(self) or not soles else []
        kinds += [count_of(soles, "sole")] if soles else []
        named = [c.name for c in self.contacts if c.name]
        who = f": {', '.join(named[:8])}{', ...' if len(named) > 8 else ''}" if named else ""
        mu = self._each("mu")
        friction = f", mu {mu.min():.3g} to {mu.max():.3g}" if len(self) and np.ptp(mu) > 0.0 else ""
        friction = f", mu {mu[0]:.3g}" if len(self) and not friction else friction
        return f"Stance of {' and '.join(kinds)}{friction}{who}."

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the contacts, in order."""
        return tuple(c.name for c in self.contacts)

    def _each(self, attribute: str) -> FloatArray:
        return np.array([getattr(c, attribute) for c in self.contacts], dtype=np.float64)

    @cached_property
    def positions(self) -> FloatArray:
        """(n, 3) contact positions in world axes [m]."""
        return self._each("position").reshape(-1, 3)

    @cached_property
    def rotations(self) -> FloatArray:
        """The (n, 3, 3) rotations rotation_world_contact of the contacts."""
        return self._each("rotation_world_contact").reshape(-1, 3, 3)

    @cached_property
    def mu(self) -> FloatArray:
        """(n,) friction coefficients [-]."""
        return self._each("mu")

    @cached_property
    def normal_min(self) -> FloatArray:
        """(n,) lower bounds on the normal forces [N]."""
        return self._each("normal_min")

    @cached_property
    def normal_max(self) -> FloatArray:
        """(n,) upper bounds on the normal forces [N]."""
        return self._each("normal_max")

    def grasp_map(self, about: ArrayLike = (0.0, 0.0, 0.0)) -> FloatArray:
        """Return the map from stacked contact forces to the wrench on the robot.

        Parameters
        ----------
        about
            (3,) point that moments refer to, usually the centre of mass, world axes [m].

        Returns
        -------
        FloatArray
            (6, dim) [-, m]: [force; moment about the point] in world axes = map @ forces in contact frames
            (three columns for a point, six for a sole).
        """
        point = finite_array("about", about, (3,))
        out = np.zeros((6, self.dim))
        for contact, part in zip(self.contacts, self.slices, strict=True):
            R = contact.rotation_world_contact
            block = out[:, part]
            block[:3, :3] = R
            block[3:, :3] = skew(contact.position - point) @ R
            if contact.dim == 6:
                block[3:, 3:] = R
        return out

    def force_rows(self, stacked: ArrayLike, axes: Axes = "contact") -> FloatArray:
        """Return the force of each contact as a row, from forces and wrenches stacked as the grasp map's.

        Parameters
        ----------
        stacked
            (dim,) forces of points and wrenches of soles in contact frames [N, N m].
        axes
            Of what is returned: of each contact's frame (tangent, tangent, normal), or the world's.

        Returns
        -------
        FloatArray
            (n, 3) [N]; a sole's moment is left out.

        Raises
        ------
        ProblemError
            For another shape, or axes that are neither.
        """
        check_name("axes", axes, ("contact", "world"))
        given = finite_array("stacked", stacked, (self.dim,))
        rows = np.array([given[part][:3] for part in self.slices]).reshape(-1, 3)
        return rows if axes == "contact" else np.einsum("nij,nj->ni", self.rotations.reshape(-1, 3, 3), rows)

    def halfspaces(
        self,
        facets: int = 8,
        fit: Fit = "inner",
        axes: Axes = "contact",
        swing: Sequence[bool] | Sequence[str] = (),
    ) -> HalfSpaces:
        """Return the rows that a QP over the stacked forces needs: friction, normal bounds, swing feet.

        Parameters
        ----------
        facets
            Sides of the friction pyramid of each point and of each corner of a sole, >= 3.
        fit
            "inner" never promises force that the ground cannot give, "outer" never forbids any.
        axes
            Of the forces: "contact" (each in its contact frame) or "world".
        swing
            Contacts whose force is zero: their names, or one flag per contact.

        Returns
        -------
        HalfSpaces
            A @ forces <= b with facets + 1 rows per point on the ground, those of `Sole.polyhedral` + 1 per
            sole, and one more for each upper bound; E @ forces = e with three rows per point in swing and six
            per sole.

        Raises
        ------
        ProblemError
            For fewer than three facets, or an unknown fit, axes or contact.

        Examples
        --------
        >>> feet = [[0.2, 0.15, 0], [0.2, -0.15, 0], [-0.2, 0.15, 0], [-0.2, -0.15, 0]]
        >>> stance = Stance([PointContact(p, mu=0.6, normal_min=10.0, normal_max=500.0) for p in feet])
        >>> rows = stance.halfspaces(facets=4, swing=[False, True, True, False])  # a trot
        >>> rows.A.shape, rows.E.shape
        ((12, 12), (6, 12))
        """
        return halfspaces(self.contacts, facets, fit, axes, swing)

    def two_sided(
        self,
        facets: int = 8,
        fit: Fit = "inner",
        axes: Axes = "contact",
        swing: Sequence[bool] | Sequence[str] = (),
    ) -> TwoSidedRows:
        """Return the rows of `halfspaces` as lower <= A @ forces <= upper, swing feet among them.

        One row for each side and one for each normal force, whether it is bounded above or not: their number
        does not follow from the bounds at all.

        Parameters
        ----------
        facets, fit, axes, swing
            As for `halfspaces`.

        Examples
        --------
        >>> rows = Stance([PointContact([0, 0, 0], mu=0.6, normal_min=10.0)]).two_sided(facets=4)
        >>> rows.A.shape, rows.lower.tolist(), rows.upper.tolist()
        ((5, 3), [-inf, -inf, -inf, -inf, 10.0], [0.0, 0.0, 0.0, 0.0, inf])
        """
        return two_sided(self.contacts, facets, fit, axes, swing)

    def cone(self) -> ProductCone:
        """Return the product of the contacts' cones, for the stacked forces."""
        return ProductCone([c.cone for c in self.contacts])

    @cached_property
    def bounded(self) -> bool:
        """Whether any contact bounds its normal force (beyond >= 0)."""
        return any(c.normal_min > 0.0 or c.normal_max < math.inf for c in self.contacts)

    def points(self) -> Stance:
        """Return the same stance with every sole replaced by its corner points.

        Worked out once; a stance without soles is returned as it is.
        """
        return self._points

    @cached_property
    def _points(self) -> Stance:
        if not any(isinstance(c, SoleContact) for c in self.contacts):
            return self
        out: list[Contact] = []
        for contact in self.contacts:
            out.extend(contact.corners() if isinstance(contact, SoleContact) else [contact])
        return Stance(out)

    @cached_property
    def corner_map(self) -> FloatArray:
        """(dim, 3 k) map [-, m] from the forces of `points()` to the stacked forces and soles' wrenches."""
        corners = self.points()
        out = np.zeros((self.dim, corners.dim))
        at = 0
        for contact, part in zip(self.contacts, self.slices, strict=True):
            if not isinstance(contact, SoleContact):
                out[part, at : at + 3] = np.eye(3)
                at += 3
                continue
            for x, y in contact.sole.corners:
                out[part.start : part.start + 3, at : at + 3] = np.eye(3)
                out[part.start + 3 : part.stop, at : at + 3] = skew([x, y, 0.0])
                at += 3
        return out

    def with_friction(self, mu: ArrayLike) -> Stance:
        """Return the same stance with other friction [-], a number for all contacts or (n,) for each."""
        frictions = per_contact("mu", mu, len(self)).tolist()
        return Stance([c.with_friction(m) for c, m in zip(self.contacts, frictions, strict=True)])

    def without(self, *names: str) -> Stance:
        """Return the stance less the named contacts (feet in swing).

        Raises
        ------
        ProblemError
            For a name that is not in the stance.
        """
        for name in names:
            check_name("contact", name, self.names)
        return Stance([c for c in self.contacts if c.name not in names])
