"""The contact problem: one statement for simulation and control."""

from __future__ import annotations

from functools import cached_property
from typing import Any, Literal

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from surefoot.arrays import BoolArray, FloatArray, check_order, finite_array, per_contact
from surefoot.cones import FrictionPyramid
from surefoot.contact.blocks import (
    Blocks,
    checked_mirror,
    dense_blocks,
    vectors_fit,
)
from surefoot.contact.scales import scales_blocks, scales_dense
from surefoot.contact.spectral import spectral_norm, spectral_norm_blocks
from surefoot.errors import ProblemError, unknown_name

Law = Literal["coulomb", "convex"]
Fit = Literal["inner", "outer"]
LAWS: tuple[Law, ...] = ("coulomb", "convex")

ASYMMETRY = 1e-8
"""Largest |G - Gᵀ|, and largest -λ for an eigenvalue λ, over largest |G| that is taken for rounding.

G is then replaced by its symmetric part."""
SINGLE_ASYMMETRY = 1e-5
"""The same where all entries are of single precision: J M⁻¹ Jᵀ of a robot comes out 1e-7 to 1e-6 off."""


class ContactProblem:
    """Find contact forces λ and velocities u = (G + R) λ + g that obey the contact laws.

    With K the product of the friction cones cut to the normal bounds, and Γ(u) = (0, 0, mu ||u_t||)
    the De Saxcé shift::

        law="coulomb":   -(u + Γ(u)) is in the normal cone of K at λ   (for K without bounds:
                         K ∋ λ ⟂ u + Γ(u) ∈ K*)
        law="convex":    -u is in the normal cone of K at λ, the optimality condition of
                         min 1/2 λᵀ(G + R)λ + gᵀλ over K

    Each contact is (tangent, tangent, normal). Impulses and velocities, or forces and accelerations:
    the statement is the same. mu = 0 makes a contact frictionless.

    Parameters
    ----------
    G
        (3n, 3n) Delassus operator, symmetric positive semidefinite (its diagonal, its 2x2 minors and its 3x3
        diagonal blocks are looked at, up to rounding: 1e-8 of the largest entry, 1e-5 where all entries are
        of single precision); an array or a SciPy sparse matrix
        (then solvers that know how use its 3x3 blocks, and `G` is made dense only when it is read).
    g
        (3n,) free velocity.
    mu
        Friction coefficient, a number or (n,), finite and >= 0.
    normal_min, normal_max
        Bounds on the normal forces, a number or (n,); normal_max = 0 switches a contact off.
    law
        "coulomb" (exact) or "convex" (cone complementarity: adds a separation velocity mu ||u_t||
        to sliding contacts).
    facets, fit
        Replace the cones by pyramids of so many sides, "inner" or "outer"; None keeps the exact cones.
    compliance
        R, what is added to the diagonal of G: a number, (n,) or (3n,), >= 0. The attribute `G` includes it.
    bilateral
        (n,) mask of contacts that hold in all three directions (u = 0, any force); their mu is not used,
        and their normal bounds must be the defaults (the attributes then say -inf and inf).

    Attributes
    ----------
    notes
        What was changed when the problem was read from a file, in words; empty otherwise.
    reference
        (n, 3) forces of somebody else's solution that came with a file, or None.
    prepared
        What solvers keep with a problem, by their own names: views of its arrays, never copies of them, since
        those may be changed in place. No part of the problem.

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
        mu: ArrayLike,
        normal_min: ArrayLike = 0.0,
        normal_max: ArrayLike = np.inf,
        law: Law = "coulomb",
        facets: int | None = None,
        fit: Fit = "inner",
        *,
        compliance: ArrayLike = 0.0,
        bilateral: ArrayLike | None = None,
    ) -> None:
        if law not in LAWS:
            raise ProblemError(unknown_name("law", law, LAWS))
        self.law: Law = law
        self._read_vectors(g, mu, normal_min, normal_max)
        self.bilateral: BoolArray | None = None
        if bilateral is not None:
            self._hold(bilateral)
        if facets is not None or fit != "inner":
            FrictionPyramid(0.5, facets if facets is not None else 8, fit)  # its checks are ours
        self.facets, self.fit = facets, fit
        self.notes: tuple[str, ...] = ()
        self.reference: FloatArray | None = None
        self.compliance = _compliance(compliance, self.contacts)
        self.prepared: dict[str, Any] = {}
        self._sparse: Any = None
        self._dense: FloatArray | None = None
        size = 3 * self.contacts
        if not isinstance(G, np.ndarray) and sp.issparse(G):
            self._sparse = _checked_sparse(G, size, self.compliance)
        else:
            self._dense = np.empty((size, size))
            _read_dense(G, self.compliance, self._dense)

    def _read_vectors(
        self, g: ArrayLike, mu: ArrayLike, normal_min: ArrayLike, normal_max: ArrayLike
    ) -> None:
        """Read the vectors: one compiled check, and the words only where it fails."""
        vector = np.asarray(g, dtype=np.float64) if isinstance(g, np.ndarray) else finite_array("g", g)
        self.contacts = n = vector.size // 3
        self._vectors = np.empty((2, 3 * n))
        own_mu, low, high = self.mu, self.normal_min, self.normal_max
        try:
            own_mu[:], low[:], high[:] = mu, normal_min, normal_max
            if vector.shape == (3 * n,):
                self._vectors[0] = vector
                if vectors_fit(self._vectors):
                    return
        except (TypeError, ValueError):
            pass
        vector = finite_array("g", g, (None,))
        if vector.size % 3:
            raise ProblemError(f"g must have three entries per contact, got {vector.size}")
        own_mu[:] = per_contact("mu", mu, n)
        if np.isinf(own_mu).any():
            raise ProblemError("mu must be finite, got inf")
        low[:] = per_contact("normal_min", normal_min, n)
        if np.isinf(low).any():
            raise ProblemError("normal_min must be finite, got inf")
        high[:] = per_contact("normal_max", normal_max, n)
        check_order(low, high)

    @property
    def g(self) -> FloatArray:
        """The (3n,) free velocity; may be changed in place, not replaced, as all arrays of a problem."""
        part: FloatArray = self._vectors[0]
        return part

    @property
    def vectors(self) -> FloatArray:
        """All vectors in one array (2, 3n), as compiled calls take them: g; mu, normal_min and normal_max."""
        return self._vectors

    @property
    def mu(self) -> FloatArray:
        """The (n,) friction coefficients."""
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
        mask = np.asarray(bilateral)
        if mask.shape != (self.contacts,) or mask.dtype != np.bool_:
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
        """The (3n, 3n) Delassus operator with compliance, dense and in C order."""
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
        """Return u = (G + R) λ + g for (n, 3) forces: (n, 3)."""
        operator = self.G if self._sparse is None else self._sparse
        return np.asarray((operator @ forces.ravel() + self.g).reshape(-1, 3))

    def polyhedral(self, facets: int = 8, fit: Fit = "inner") -> ContactProblem:
        """Return the same problem with pyramids of `facets` sides in place of the exact cones."""
        return self.replace(facets=facets, fit=fit)

    def replace(self, **changes: Any) -> ContactProblem:
        """Return the same problem with some arguments changed; `G` then includes the compliance already."""
        low = self.normal_min if self.bilateral is None else np.where(self.bilateral, 0.0, self.normal_min)
        arguments: dict[str, Any] = {
            "G": self.G if self._sparse is None else self._sparse,
            "g": self.g,
            "mu": self.mu,
            "normal_min": low,
            "normal_max": self.normal_max,
            "law": self.law,
            "facets": self.facets,
            "fit": self.fit,
            "bilateral": self.bilateral,
        }
        problem = ContactProblem(**(arguments | changes))
        problem.notes, problem.reference = self.notes, self.reference
        return problem

    def __repr__(self) -> str:
        sides = "" if self.facets is None else f", facets={self.facets}, fit={self.fit!r}"
        return f"ContactProblem(contacts={self.contacts}, law={self.law!r}{sides})"

    @cached_property
    def norm(self) -> float:
        """The spectral norm ||G||₂ (Lanczos, to about 1e-9 relative; see `spectral`)."""
        if self.contacts == 0:
            return 0.0
        if self._sparse is not None or self.contacts > 60:
            b = self.blocks
            return float(spectral_norm_blocks(b.starts, b.columns, b.values))
        return float(spectral_norm(self.G))

    @property
    def scales(self) -> FloatArray:
        """The rows of `contact.scales`, (4, n).

        w_k = ||G_kk||₂, s_k [m/s], trace G_kk, and Σ s_j² / w_j over the part. Not kept: g may be changed
        in place, and a verdict must not rest on what it was.
        """
        scales = np.zeros((4, self.contacts))
        if self.contacts == 0:
            return scales
        if self._dense is not None:
            scales_dense(self.G, self.g, self.normal_min, self.normal_max, scales)
        else:
            b = self.blocks
            scales_blocks(b.starts, b.columns, b.values, self.g, self.normal_min, self.normal_max, scales)
        return scales


def _compliance(value: Any, contacts: int) -> FloatArray | None:
    """Return R as (3n,), None where it is zero."""
    if isinstance(value, (int, float)) and value == 0.0:
        return None
    R = finite_array("compliance", value)
    if R.shape == (contacts,):
        R = np.repeat(R, 3)
    elif R.ndim == 0:
        R = np.full(3 * contacts, float(R))
    if R.shape != (3 * contacts,):
        raise ProblemError(
            f"compliance must be a number or have shape ({contacts},) or ({3 * contacts},), got {R.shape}"
        )
    if (R < 0.0).any():
        raise ProblemError(f"compliance[{int(np.argmax(R < 0.0))}] must be >= 0, got {R.min():g}")
    return R


def _read_dense(G: ArrayLike, compliance: FloatArray | None, out: FloatArray) -> None:
    """Fill `out` with the symmetric part of G, and the compliance on its diagonal."""
    matrix = np.asarray(G) if isinstance(G, np.ndarray) else finite_array("G", G)
    if matrix.shape != out.shape or matrix.dtype.kind == "c":
        finite_array("G", G, out.shape)  # says so
    try:
        out[:] = matrix
    except (TypeError, ValueError):
        finite_array("G", G, out.shape)
    scale, gap, _, _ = checked_mirror(out, ASYMMETRY)
    if not scale < np.inf:
        finite_array("G", G, out.shape)  # names the entry
    if gap < 0.0 or gap > ASYMMETRY * scale:
        _refuse_unless_single(matrix, out)
    if compliance is not None:
        out[np.diag_indices(out.shape[0])] += compliance


def _refuse_unless_single(matrix: Any, out: FloatArray) -> None:
    """Check a dense G again as one of single precision, if it is; else say what is wrong with it."""
    entries = np.asarray(matrix, dtype=np.float64)
    with np.errstate(over="ignore"):
        single = bool((entries == entries.astype(np.float32)).all())
    limit = SINGLE_ASYMMETRY if single else ASYMMETRY
    out[:] = entries
    scale, gap, i, j = checked_mirror(out, limit)
    if gap > limit * scale:
        raise ProblemError(_asymmetry(i, j, float(entries[i, j]), float(entries[j, i]), limit))
    if gap < 0.0:
        raise ProblemError(_indefinite(i, j, out))


def _asymmetry(i: int, j: int, one: float, other: float, limit: float) -> str:
    return (
        f"G must be symmetric, but G[{i}, {j}] = {one:g} and G[{j}, {i}] = {other:g}; "
        f"up to {limit:g} of the largest entry is taken for rounding"
    )


def _indefinite(i: int, j: int, G: Any) -> str:
    """Say which entries show that G is not positive semidefinite, as `checked_mirror` returned them."""
    text = "G must be positive semidefinite, but "
    if i == j:
        return f"{text}G[{i}, {i}] = {G[i, i]:g}"
    if j > i:
        return f"{text}its block of contact {i // 3} (rows {i} to {i + 2}) has a negative eigenvalue"
    return f"{text}G[{i}, {j}] = {G[i, j]:g} with G[{i}, {i}] = {G[i, i]:g} and G[{j}, {j}] = {G[j, j]:g}"


def _checked_sparse(G: Any, size: int, compliance: FloatArray | None) -> Any:
    """Return the symmetric part of a sparse G with the compliance on its diagonal, in CSR."""
    if G.shape != (size, size):
        raise ProblemError(f"G must have shape ({size}, {size}), got {G.shape}")
    matrix = sp.csr_matrix(G, dtype=np.float64)
    finite_array("the entries of G", matrix.data)
    largest = float(abs(matrix.data).max(initial=0.0))
    with np.errstate(over="ignore"):
        single = bool((matrix.data == matrix.data.astype(np.float32)).all())
    limit = SINGLE_ASYMMETRY if single else ASYMMETRY
    gap = abs(matrix - matrix.T).tocoo()
    if gap.nnz and gap.data.max() > limit * largest:
        k = int(np.argmax(gap.data))
        i, j = int(gap.row[k]), int(gap.col[k])
        raise ProblemError(_asymmetry(i, j, float(matrix[i, j]), float(matrix[j, i]), limit))
    matrix = 0.5 * (matrix + matrix.T)
    entries, own = matrix.tocoo(), matrix.diagonal() + limit * largest
    over = entries.data**2 > own[entries.row] * own[entries.col]
    over = (over & (entries.row > entries.col)) | ((entries.row == entries.col) & (own[entries.row] < 0.0))
    if over.any():
        k = int(np.argmax(over))
        raise ProblemError(_indefinite(int(entries.row[k]), int(entries.col[k]), matrix.tocsr()))
    if compliance is not None:
        matrix = matrix + sp.diags(compliance)
    return matrix.tocsr()
