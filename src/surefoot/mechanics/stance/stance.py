"""A stance: the contacts that hold a robot, and the map from their forces to one wrench."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from copy import copy
from functools import cached_property
from itertools import accumulate, pairwise

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, finite_array, per_contact
from surefoot.base.errors import ProblemError, check_name
from surefoot.base.spatial import skew
from surefoot.contact import Fit, ProductCone
from surefoot.mechanics.stance.contact import Contact, PatchContact, PointContact
from surefoot.mechanics.stance.halfspaces import Axes, HalfSpaces, halfspaces


class Stance:
    """Contacts in a fixed order; forces are stacked in that order, each in its contact frame.

    Parameters
    ----------
    contacts
        Point and patch contacts; none at all is allowed (a robot in the air).

    Examples
    --------
    >>> feet = [[0.2, 0.15, 0], [0.2, -0.15, 0], [-0.2, 0.15, 0], [-0.2, -0.15, 0]]
    >>> stance = Stance([PointContact(p, mu=0.6) for p in feet])
    >>> stance.grasp_map(about=[0, 0, 0.3]).shape
    (6, 12)
    """

    def __init__(self, contacts: Sequence[Contact]) -> None:
        if not isinstance(contacts, Iterable):
            raise ProblemError(
                f"contacts must be a list, as [sf.PointContact(p)] is one, got {contacts!r:.60}"
            )
        self.contacts = tuple(contacts)
        for k, contact in enumerate(self.contacts):
            if not isinstance(contact, (PointContact, PatchContact)):
                raise ProblemError(
                    f"contacts[{k}] must be a PointContact or a PatchContact, got {type(contact).__name__}"
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
            (three columns for a point, six for a patch).
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
            Sides of each point's friction pyramid, >= 3.
        fit
            "inner" never promises force that the ground cannot give, "outer" never forbids any.
        axes
            Of the forces: "contact" (each in its contact frame) or "world".
        swing
            Contacts whose force is zero: their names, or one flag per contact.

        Returns
        -------
        HalfSpaces
            A @ forces <= b with facets + 2 rows per stance foot (18 for a patch), E @ forces = e with
            three rows per swing foot (six for a patch).

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

    def cone(self) -> ProductCone:
        """Return the product of the contacts' cones, for the stacked forces."""
        return ProductCone([c.cone for c in self.contacts])

    @cached_property
    def bounded(self) -> bool:
        """Whether any contact bounds its normal force (beyond >= 0)."""
        return any(c.normal_min > 0.0 or c.normal_max < math.inf for c in self.contacts)

    def points(self) -> Stance:
        """Return the same stance with every patch replaced by its four corner points.

        Worked out once; a stance without patches is returned as it is.
        """
        return self._points

    @cached_property
    def _points(self) -> Stance:
        if not any(isinstance(c, PatchContact) for c in self.contacts):
            return self
        out: list[Contact] = []
        for contact in self.contacts:
            out.extend(contact.corners() if isinstance(contact, PatchContact) else [contact])
        return Stance(out)

    @cached_property
    def corner_map(self) -> FloatArray:
        """(dim, 3 k) map [-, m] from the forces of `points()` to the stacked forces and patch wrenches."""
        corners = self.points()
        out = np.zeros((self.dim, corners.dim))
        at = 0
        for contact, part in zip(self.contacts, self.slices, strict=True):
            if not isinstance(contact, PatchContact):
                out[part, at : at + 3] = np.eye(3)
                at += 3
                continue
            for x, y in contact.corner_offsets():
                out[part.start : part.start + 3, at : at + 3] = np.eye(3)
                out[part.start + 3 : part.stop, at : at + 3] = skew([x, y, 0.0])
                at += 3
        return out

    def with_friction(self, mu: ArrayLike) -> Stance:
        """Return the same stance with other friction [-], a number for all contacts or (n,) for each."""
        twins = [copy(contact) for contact in self.contacts]
        for twin, friction in zip(twins, per_contact("mu", mu, len(twins)).tolist(), strict=True):
            twin.mu = friction
        return Stance(twins)

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
