"""The contact problem: one statement for simulation and control."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any, Literal, TypedDict

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from surefoot.base.arrays import (
    BoolArray,
    FloatArray,
    array_of,
    check_order,
    finite_array,
    numbers,
    per_contact,
)
from surefoot.base.drawn import Drawn
from surefoot.base.errors import ProblemError, count_of
from surefoot.contact.cones import FrictionPyramid
from surefoot.contact.laws import COULOMB, LAWS, Law, law_of
from surefoot.contact.problem.blocks import MOST_DENSE, Blocks, dense_blocks, vectors_fit
from surefoot.contact.problem.matrix import (
    checked_sparse,
    read_compliance,
    read_dense,
    read_factor,
    spectral_norm,
)
from surefoot.contact.problem.scales import scales_blocks, scales_dense
from surefoot.contact.problem.set_scales import set_scales
from surefoot.contact.sets.contact import MOST_FRICTION, ContactKind
from surefoot.contact.sets.contact_set import ContactSet, set_of

Fit = Literal["inner", "outer"]


class ContactOptions(TypedDict, total=False):
    """What contacts seldom say, by the names of `ContactProblem`'s arguments: for what hands them on."""

    facets: int | None
    fit: Fit
    compliance: ArrayLike
    bilateral: ArrayLike | None


class ContactProblem(Drawn):
    """Find contact forces λ and velocities u = (G + R) λ + g that obey the contact laws.

    With K the product of the friction cones cut to the normal bounds, and Γ(u) = (0, 0, mu ||u_t||)
    the De Saxcé shift::

        law="coulomb":   -(u + Γ(u)) is in the normal cone of K at λ   (for K without bounds:
                         K ∋ λ ⟂ u + Γ(u) ∈ K*)
        law="convex":    -u is in the normal cone of K at λ, the optimality condition of
                         min 1/2 λᵀ(G + R)λ + gᵀλ over K

    Each contact is (tangent, tangent, normal). Impulses and velocities, or forces and accelerations:
    the statement is the same. mu = 0 makes a contact frictionless. Units below are those of impulses [N s]
    and velocities [m/s]; for forces read [N] and [m/s²].

    Parameters
    ----------
    G
        (3n, 3n) Delassus operator [1/kg], symmetric positive semidefinite (its diagonal, its 2x2 minors and
        its 3x3 diagonal blocks are looked at, up to rounding: 1e-8 of the largest entry, 1e-5 where all
        entries are of single precision); an array or a SciPy sparse matrix (then solvers that know how use
        its 3x3 blocks, and `G` is made dense only when it is read).
    g
        (3n,) free velocity [m/s], contact frames.
    mu
        Friction coefficient [-], a number or (n,), finite and >= 0.
    normal_min, normal_max
        Bounds on the normal impulses [N s], a number or (n,); normal_max = 0 switches a contact off.
    law
        "coulomb" (exact) or "convex" (cone complementarity: adds a separation velocity mu ||u_t||
        to sliding contacts), or a value of `sf.laws`.
    facets, fit
        Replace the cones by pyramids of so many sides, "inner" or "outer"; None keeps the exact cones.
    compliance
        R, added to the diagonal of G [1/kg]: a number, (n,) or (3n,), >= 0; the attribute `G` has it in it.
    bilateral
        (n,) mask of contacts that hold in all three directions (u = 0, any force); their mu is not used,
        and their normal bounds must be the defaults (the attributes then say -inf and inf).
    contacts
        In place of mu, the bounds, facets and bilateral: one value of `sf.contact_sets` for each contact, of
        any kinds together; G and g then have their rows, one contact after the other.

    Attributes
    ----------
    contacts
        Their number n.
    shape
        Of forces and velocities: (n, 3); for `contacts` of other kinds (n, d) where all have d rows, else
        flat, (m,) (`contact_set.split` gives each contact its own).
    general
        Whether solvers and residuals for contacts of any kind are needed: what (n, 3) arrays cannot say.
    notes
        What was changed when the problem was read from a file, in words; empty otherwise.
    reference
        (n, 3) forces of somebody else's solution that came with a file, or None.
    prepared
        What solvers keep with a problem, by their own names: views of its arrays, which may be changed in
        place, never copies. No part of the problem.

    Raises
    ------
    ProblemError
        If it is not a problem: wrong shapes, NaN, mu < 0, G not symmetric or visibly indefinite, bounds out
        of order.

    References
    ----------
    .. [1] V. Acary, F. Cadoux, C. Lemaréchal, J. Malick, "A formulation of the linear discrete Coulomb
       friction problem via convex optimization", ZAMM 91(2), 2011.
    """

    def __init__(
        self,
        G: ArrayLike | Any,
        g: ArrayLike,
        mu: ArrayLike | None = None,
        normal_min: ArrayLike = 0.0,
        normal_max: ArrayLike = np.inf,
        law: str = COULOMB,
        facets: int | None = None,
        fit: Fit = "inner",
        *,
        compliance: ArrayLike = 0.0,
        bilateral: ArrayLike | None = None,
        contacts: Sequence[ContactKind] | None = None,
    ) -> None:
        self.law: Law = law_of(law)
        self.notes: tuple[str, ...] = ()
        self.reference: FloatArray | None = None
        self.prepared: dict[str, Any] = {}
        self.bilateral: BoolArray | None = None
        self._set: ContactSet | None = None
        self._own_g: FloatArray | None = None
        self._sparse: Any = None
        self._dense: FloatArray | None = None
        self._factor: Any = None
        if contacts is not None:
            own = mu is None and facets is None and bilateral is None and fit == "inner"
            if not (own and np.all(normal_min == 0.0) and np.all(normal_max == np.inf)):
                raise ProblemError("contacts say their own mu, bounds and facets; give those or them")
            self._set = ContactSet(contacts)
            short = self._set.short_form()
            if short is None:
                self._read_general(G, g, self._set, compliance)
                return
            mu, normal_min, normal_max = short["mu"], short["normal_min"], short["normal_max"]
            facets, fit, bilateral = short["facets"], short["fit"], short["bilateral"]
        elif mu is None:
            raise ProblemError("a contact problem needs mu, or contacts")
        self._read_vectors(g, mu, normal_min, normal_max)
        if bilateral is not None:
            self._hold(bilateral)
        if not (facets is None and isinstance(fit, str) and fit == "inner"):
            read = FrictionPyramid(0.5, 8 if facets is None else facets, fit)  # its checks are ours
            facets = None if facets is None else read.facets
        self.facets, self.fit = facets, fit
        self.shape: tuple[int, ...] = (self.contacts, 3)
        self.general = self.law not in LAWS
        self.compliance = read_compliance(compliance, self.contacts, 3)
        size = 3 * self.contacts
        if not isinstance(G, np.ndarray) and sp.issparse(G):
            self._sparse = checked_sparse(G, size, self.compliance)
        else:
            self._dense = np.empty((size, size))
            read_dense(G, self.compliance, self._dense)

    @classmethod
    def of_factor(cls, factor: Any, g: ArrayLike, mu: ArrayLike, law: str = COULOMB) -> ContactProblem:
        """Return the problem of G = Y Yᵀ, for a sparse factor Y (3n, nv): J L⁻ᵀ with M = L Lᵀ [kg^-1/2].

        Many contacts are solved with matrices as large as their bodies' velocities are many then.

        >>> problem = ContactProblem.of_factor(2.0 * np.eye(3), [0.0, 0.0, -1.0], 0.5)
        >>> problem.G[2, 2], problem.factor.shape
        (np.float64(4.0), (3, 3))
        """
        Y = read_factor(factor)
        problem = cls(Y @ Y.T, g, mu, law=law)
        problem._factor = Y
        return problem

    @property
    def factor(self) -> Any:
        """Y with G = Y Yᵀ, or None; a new one, dense or sparse, is kept without its empty columns."""
        return self._factor

    @factor.setter
    def factor(self, Y: Any) -> None:
        self._factor = None if Y is None else read_factor(Y)

    @property
    def operator(self) -> Any:
        """G as it was given, dense or sparse: (3n, 3n) [1/kg]."""
        return self.G if self._sparse is None else self._sparse

    def _read_general(self, G: Any, g: ArrayLike, contacts: ContactSet, compliance: ArrayLike) -> None:
        """Read a problem whose contacts the short form cannot say; its G is kept dense."""
        self.contacts, self.shape, self.general = len(contacts), contacts.shape, True
        self._own_g = finite_array("g", g, (contacts.rows,)).copy()
        self._vectors = np.zeros((2, 3 * self.contacts))
        self.mu[:] = [c.coefficient for c in contacts]
        held = np.array([c.bilateral for c in contacts], dtype=bool)
        self.normal_min[:] = np.where(held, -np.inf, [c.normal_min for c in contacts])
        self.normal_max[:] = [c.normal_max for c in contacts]
        self._vectors.setflags(write=False)  # the contacts say it
        self.bilateral = held if held.any() else None
        self.facets, self.fit = None, "inner"
        self.compliance = read_compliance(compliance, self.contacts, np.diff(contacts.offsets))
        self._dense = np.empty((contacts.rows, contacts.rows))
        sparse = not isinstance(G, np.ndarray) and sp.issparse(G)
        read_dense(G.toarray() if sparse else G, self.compliance, self._dense, threes=False)

    def _read_vectors(
        self, g: ArrayLike, mu: ArrayLike, normal_min: ArrayLike, normal_max: ArrayLike
    ) -> None:
        """Read the vectors: one compiled check, and the words only where it fails."""
        plain = type(g) is np.ndarray and g.dtype.kind == "f"
        vector = np.asarray(g, dtype=np.float64) if plain else finite_array("g", g)
        self.contacts = n = vector.size // 3
        self._vectors = np.empty((2, 3 * n))
        own_mu, low, high = self.mu, self.normal_min, self.normal_max
        try:
            own_mu[:] = mu if type(mu) is float else numbers("mu", mu)
            low[:] = normal_min if type(normal_min) is float else numbers("normal_min", normal_min)
            high[:] = normal_max if type(normal_max) is float else numbers("normal_max", normal_max)
            if vector.shape == (3 * n,):
                self._vectors[0] = vector
                if vectors_fit(self._vectors):
                    return
        except ValueError:
            pass
        vector = finite_array("g", g, (None,))
        if vector.size % 3:
            raise ProblemError(f"g must have three entries per contact, got {vector.size}")
        own_mu[:] = per_contact("mu", mu, n)
        if (own_mu > MOST_FRICTION).any():
            raise ProblemError(f"mu must be finite, at most {MOST_FRICTION:g}, got {own_mu.max():g}")
        low[:] = per_contact("normal_min", normal_min, n)
        if np.isinf(low).any():
            raise ProblemError("normal_min must be finite, got inf")
        high[:] = per_contact("normal_max", normal_max, n)
        check_order(low, high)

    @property
    def g(self) -> FloatArray:
        """The (3n,) free velocity [m/s]; changed in place, never replaced, as all arrays of a problem."""
        part: FloatArray = self._vectors[0] if self._own_g is None else self._own_g
        return part

    @property
    def vectors(self) -> FloatArray:
        """All vectors in one (2, 3n), as compiled calls take them: g [m/s]; mu [-] and the bounds [N s]."""
        return self._vectors

    @property
    def mu(self) -> FloatArray:
        """The (n,) friction coefficients [-]."""
        part: FloatArray = self._vectors[1, : self.contacts]
        return part

    @property
    def normal_min(self) -> FloatArray:
        """The (n,) lower bounds of the normal forces [N]; -inf marks a bilateral contact."""
        part: FloatArray = self._vectors[1, self.contacts : 2 * self.contacts]
        return part

    @property
    def normal_max(self) -> FloatArray:
        """The (n,) upper bounds of the normal forces [N]."""
        part: FloatArray = self._vectors[1, 2 * self.contacts :]
        return part

    def _hold(self, bilateral: ArrayLike) -> None:
        """Read the mask of bilateral contacts."""
        mask: BoolArray = array_of("bilateral", bilateral, "b", "a mask of True and False", np.bool_)
        if mask.shape != (self.contacts,):
            raise ProblemError(
                f"bilateral must be a mask of shape ({self.contacts},), got {mask.dtype} {mask.shape}"
            )
        bounded = mask & ((self.normal_min != 0.0) | (self.normal_max != np.inf))
        if bounded.any():
            raise ProblemError(
                f"a bilateral contact takes no normal bounds, got some at contact {int(np.argmax(bounded))}"
            )
        if mask.any():
            self.bilateral = mask
            self.normal_min[mask] = -np.inf

    @cached_property
    def bounded(self) -> bool:
        """Whether some contact has a normal bound other than 0 below and infinity or 0 above."""
        low, high = self.normal_min > 0.0, (self.normal_max > 0.0) & (self.normal_max < np.inf)
        return bool((low | high).any())

    @property
    def G(self) -> FloatArray:
        """The (3n, 3n) Delassus operator with compliance [1/kg], dense and in C order."""
        if self._dense is None:
            self._dense = np.ascontiguousarray(self._sparse.toarray())
        return self._dense

    @cached_property
    def blocks(self) -> Blocks:
        """The 3x3 blocks of G that are not zero, in compressed rows."""
        if self._sparse is None:
            return Blocks(*dense_blocks(self.G))
        b = sp.bsr_matrix(self._sparse, blocksize=(3, 3))
        b.sort_indices()
        return Blocks(b.indptr.astype(np.int64), b.indices.astype(np.int64), np.ascontiguousarray(b.data))

    def velocity(self, forces: FloatArray) -> FloatArray:
        """Return u = (G + R) λ + g [m/s] for impulses [N s] of the problem's shape, (n, 3), in that shape."""
        return np.asarray((self.operator @ forces.ravel() + self.g).reshape(self.shape))

    def polyhedral(self, facets: int = 8, fit: Fit = "inner") -> ContactProblem:
        """Return the same problem with pyramids of `facets` sides in place of the exact cones.

        Raises
        ------
        ProblemError
            If some contact is more than a point.
        """
        return self.replace(facets=facets, fit=fit)

    def replace(self, **changes: Any) -> ContactProblem:
        """Return the same problem with some arguments changed; `G` then includes the compliance already."""
        arguments: dict[str, Any] = {"G": self.operator, "g": self.g, "law": self.law}
        if self._own_g is not None:
            given = changes.items()
            changes = {k: v for k, v in given if not (k in ("facets", "fit") and v in (None, "inner"))}
            arguments |= {"contacts": self.contact_set}
        else:
            held = False if self.bilateral is None else self.bilateral
            arguments |= {
                "mu": self.mu,
                "normal_min": np.where(held, 0.0, self.normal_min),
                "normal_max": self.normal_max,
                "facets": self.facets,
                "fit": self.fit,
                "bilateral": self.bilateral,
            }
        problem = ContactProblem(**(arguments | changes))
        problem.notes, problem.reference = self.notes, self.reference
        if not changes.keys() & {"G", "compliance"}:
            problem._factor = self._factor
        return problem

    @property
    def contact_set(self) -> ContactSet:
        """The contacts as values of `sf.contact_sets`; those of the short form are made when asked for."""
        if self._own_g is not None and self._set is not None:
            return self._set
        return set_of(self.mu, self.normal_min, self.normal_max, self.facets, self.fit)

    def __str__(self) -> str:
        kinds = "" if self._own_g is None else " of several kinds"
        size = f"G is {self.G.shape[0]} x {self.G.shape[1]}"
        count = count_of(self.contacts, "contact")
        return f"Contact problem under the law {str(self.law)!r}: {count}{kinds}; {size}."

    def __repr__(self) -> str:
        if self._own_g is not None:
            return f"ContactProblem(contacts={list(self.contact_set)!r}, law={str(self.law)!r})"
        sides = "" if self.facets is None else f", facets={self.facets}, fit={self.fit!r}"
        return f"ContactProblem(contacts={self.contacts}, law={str(self.law)!r}{sides})"

    @cached_property
    def norm(self) -> float:
        """The spectral norm ||G||₂, to about 1e-9 relative [m/s per unit of force]."""
        return spectral_norm(self.operator)

    @property
    def scales(self) -> FloatArray:
        """The rows of `contact.problem.scales`, (4, n).

        w_k = ||G_kk||₂, s_k [m/s], trace G_kk, and Σ s_j² / w_j over the part. Not kept: g may be changed
        in place, and a verdict must not rest on what it was.
        """
        if self.general:
            return set_scales(self.contact_set, self.G, self.g)
        scales = np.zeros((4, self.contacts))
        if self.contacts == 0:
            return scales
        if self._dense is not None and self.contacts <= MOST_DENSE:
            scales_dense(self.G, self.g, self.normal_min, self.normal_max, scales)
        else:
            b = self.blocks
            scales_blocks(b.starts, b.columns, b.values, self.g, self.normal_min, self.normal_max, scales)
        return scales
