"""Linear complementarity problems, and contact with polyhedral friction written as one.

A PSD matrix gives an LCP that has a solution if it is feasible, not always. Polyhedral Coulomb friction
gives a matrix that is neither symmetric nor PSD but copositive: a case for Lemke's method, not for a QP.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surefoot.base.arrays import FloatArray, IntArray, finite_array
from surefoot.base.errors import ProblemError
from surefoot.contact.cones import FrictionPyramid
from surefoot.contact.problem.problem import ContactProblem

COARSE = 1.5
"""Scales within this many powers of two of each other are left alone."""


class LCP:
    """Find z >= 0 with w = M z + q >= 0 and z . w = 0.

    `M` and `q` are copies that cannot be written to: another q is another problem.

    Parameters
    ----------
    M
        (n, n), any square matrix, in the units of w over those of z.
    q
        (n,), in the units of w: what they are is the problem's affair, and may differ from row to row.

    Raises
    ------
    ProblemError
        If shapes disagree or an entry is not finite.

    Examples
    --------
    >>> lcp = LCP([[2.0, 1.0], [1.0, 2.0]], [-5.0, -6.0])
    >>> float(lcp.residual([4 / 3, 7 / 3])) < 1e-15
    True
    """

    def __init__(self, M: ArrayLike, q: ArrayLike) -> None:
        self.q = finite_array("q", q, (None,))
        self.size = self.q.shape[0]
        self.M = finite_array("M", M, (self.size, self.size))
        for own in (self.M, self.q):  # copies; what is measured on them is kept, and must stay true
            own.setflags(write=False)

    def __repr__(self) -> str:
        return f"LCP(size={self.size})"

    def slack(self, z: ArrayLike) -> FloatArray:
        """Return w = M z + q, (n,) in the units of q, for z (n,)."""
        return np.asarray(self.M @ finite_array("z", z, (self.size,)) + self.q)

    @cached_property
    def parts(self) -> tuple[IntArray, ...]:
        """The indices (k,) of each part that no entry of M couples to another, in ascending order."""
        from scipy.sparse import csr_matrix
        from scipy.sparse.csgraph import connected_components

        count, label = connected_components(csr_matrix(self.M), directed=False)
        return tuple(np.flatnonzero(label == k) for k in range(count))

    def part(self, index: IntArray) -> LCP:
        """Return the problem of one of `parts`, given by its indices (k,), alone."""
        return LCP(self.M[np.ix_(index, index)], self.q[index])

    def residual(self, z: ArrayLike) -> float:
        """Return max |min(m z_i, w_i)| / max |q| with m = max |M|, the worst of `parts` [-]; 0 at a solution.

        Each part is measured by its own q and M (by the largest |q| of all, where its own is zero), so that
        nothing unrelated makes an error look small; and twice, in the units of w as they are and in those
        that equilibrate M, so that no row's unit does. The size of z is left out on purpose: along a ray of
        an infeasible problem it would grow until any error looks small. The number is the same for
        (c M, c q), and for (M, c q) with c z. An answer that is not finite, or overflows, gives NaN or
        infinity.
        """

        def gap(M: FloatArray, q: FloatArray, x: FloatArray) -> FloatArray:
            m = float(np.abs(M).max()) or 1.0
            return np.asarray(np.abs(np.minimum(m * x, M @ x + q)))

        return self._worst(z, gap)

    def rounding(self, z: ArrayLike) -> float:
        """Return the largest 4 eps Σ_j |M_ij| |z_j| of z (n,), in the same measure as `residual` [-].

        What double precision cannot tell of w: a residual below it says nothing.
        """
        return self._worst(z, lambda M, q, x: 4.0 * np.finfo(float).eps * (np.abs(M) @ np.abs(x)))

    @cached_property
    def _measured(self) -> list[tuple[IntArray, IntArray, FloatArray, FloatArray, float]]:
        """What an error is measured on: indices, exponents k of z' = 2^-k z, M', q' and max |q'|."""
        everywhere, found = float(np.abs(self.q).max(initial=0.0)), []
        for index in self.parts:
            M, q = self.M[np.ix_(index, index)], self.q[index]
            size = float(np.abs(q).max())
            found.append((index, np.zeros(index.size, dtype=np.int64), M, q, size or everywhere or 1.0))
            balanced, d = equilibrated(M)
            # the same part once more, equilibrated: an error in a row of small numbers shows there
            if size > 0.0 and d.max() > d.min():
                exponents = np.frexp(q)[1][q != 0.0] + d[q != 0.0]
                scaled = np.ldexp(q, d - int(exponents.max()))
                found.append((index, d + int(exponents.max()), balanced, scaled, float(np.abs(scaled).max())))
        return found

    def _worst(
        self, z: ArrayLike, error: Callable[[FloatArray, FloatArray, FloatArray], FloatArray]
    ) -> float:
        """Return the worst of the parts' errors, each relative to the part's largest |q|."""
        x, worst = np.asarray(z, dtype=np.float64), 0.0
        with np.errstate(over="ignore", invalid="ignore", under="ignore"):
            for index, k, M, q, size in self._measured:
                found = float(error(M, q, np.ldexp(x[index], -k)).max()) / size
                worst = found if not found <= worst else worst
        return worst

    def proves_infeasible(self, v: ArrayLike) -> bool:
        """Tell whether v proves that no z >= 0 has M z + q >= 0: v >= 0, Mᵀ v <= 0, q . v < 0 (Farkas).

        v is (n,), in any unit: its length says nothing. Row by row and without any tolerance: the numbers are
        taken as the rationals that they are, so that no scaling of the problem can pass a vector that proves
        nothing.
        """
        x = np.asarray(v, dtype=np.float64)
        if x.shape != (self.size,) or not np.isfinite(x).all() or (x < 0.0).any():
            return False
        held = np.flatnonzero(x)
        # rationals over a common power of two: integers, whose sums and signs are exact
        weights = _whole(x[held])
        if not (weights * _whole(self.q[held])).sum() < 0:
            return False
        rows = _whole(self.M[held])
        return all(total <= 0 for total in weights @ rows) if held.size else False


def equilibrated(M: FloatArray) -> tuple[FloatArray, IntArray]:
    """Return D M D (n, n), rows and columns with largest entries near one, and the exponents (n,) of D.

    D is diagonal with powers of two, so that nothing is rounded. For z = D z', q' = D q the problem is the
    same, and a congruence keeps M positive semidefinite, copositive-plus or P. Source: D. Ruiz, "A scaling
    algorithm to equilibrate both rows and columns norms in matrices", RAL-TR-2001-034.
    """
    with np.errstate(divide="ignore"):
        logs = np.log2(np.abs(M))
    logs = np.maximum(logs, logs.T)
    scale = np.zeros(M.shape[0])
    for _ in range(30):
        # Ruiz's iteration in logarithms: each row is divided by the root of its
        # largest entry, until all are near one
        largest = (logs + scale[:, None] + scale).max(axis=1, initial=-np.inf)
        largest[~np.isfinite(largest)] = 0.0  # a row and column of zeros
        scale -= 0.5 * largest
        if float(np.ptp(scale)) <= COARSE or (np.abs(largest) < 0.1).all():
            break
    middle = float(np.median(scale))
    # what is nearly of one scale keeps one: a matrix that is fine already is not touched
    off = np.where(np.abs(scale - middle) <= COARSE, 0.0, scale - middle)
    d = np.asarray(np.round(middle) + np.round(off), dtype=np.int64)
    return np.ldexp(np.ldexp(M, d[:, None]), d), d


def _whole(x: FloatArray) -> NDArray[np.object_]:
    """Return x times a common power of two as Python integers, exactly."""
    mantissa, exponent = np.frexp(x)
    digits = (mantissa * 2.0**53).astype(np.int64).astype(object)
    used = exponent[mantissa != 0.0]
    shift = np.where(mantissa != 0.0, exponent - (int(used.min()) if used.size else 0), 0)
    return np.asarray(digits * 2 ** shift.astype(object), dtype=object)


@dataclass(frozen=True)
class FrictionLCP:
    """A contact problem as an LCP in (normal forces, pyramid edges, sliding speeds).

    Attributes
    ----------
    lcp
        The linear complementarity problem.
    contacts
        How many contacts the contact problem has.
    edges
        (3n, r): contact forces are edges @ z[:r] of the LCP's solution z.
    """

    lcp: LCP
    contacts: int
    edges: FloatArray

    def forces(self, z: ArrayLike) -> FloatArray:
        """Return the (n, 3) contact forces of an LCP solution."""
        x = np.asarray(z, dtype=np.float64)
        return np.asarray((self.edges @ x[: self.edges.shape[1]]).reshape(-1, 3))


def stewart_trinkle(problem: ContactProblem) -> FrictionLCP:
    """Return the LCP of a contact problem on pyramids under Coulomb's law.

    For each contact: normal velocity against normal force; for each edge direction d, d . u_t + sigma against
    its share of the friction force; mu f_n less the sum of the shares against the sliding speed sigma. The
    matrix is copositive, not symmetric. Contacts that are switched off are left out.

    Raises
    ------
    ProblemError
        For exact cones, the convex law, bilateral contacts or normal bounds.

    References
    ----------
    .. [1] D. E. Stewart, J. C. Trinkle, "An implicit time-stepping scheme for rigid body dynamics with
       inelastic collisions and Coulomb friction", IJNME 39, 1996.
    .. [2] M. Anitescu, F. A. Potra, "Formulating dynamic multi-rigid-body contact problems with friction as
       solvable linear complementarity problems", Nonlinear Dynamics 14, 1997.
    """
    if problem.facets is None or problem.law != "coulomb":
        raise ProblemError(
            "friction becomes an LCP for law='coulomb' on pyramids: use problem.polyhedral(facets)"
        )
    if problem.bilateral is not None or problem.bounded:
        raise ProblemError("friction becomes an LCP without bilateral contacts and normal bounds only")
    on = np.flatnonzero(problem.normal_max > 0.0)
    rough = on[problem.mu[on] > 0.0]
    normals, shares, owner = _edge_columns(problem, on, rough)
    edges = np.hstack([normals, shares])
    n, m, s = on.size, shares.shape[1], rough.size
    H = edges.T @ problem.G @ edges
    M = np.zeros((n + m + s, n + m + s))
    M[: n + m, : n + m] = H
    # d·u_t + σ >= 0 for every edge: σ is the sliding speed, at least the largest -d·u_t
    sigma = n + m + owner
    M[n + np.arange(m), sigma] = 1.0
    M[sigma, n + np.arange(m)] = -1.0
    # in mu f_n - Σ shares >= 0 mu is the radius of the pyramid's corners, for outer ones beyond the cone
    radius = np.array(
        [
            np.hypot(*FrictionPyramid(float(problem.mu[k]), problem.facets, problem.fit).rays[0, :2])
            for k in rough
        ]
    )
    M[n + m + np.arange(s), np.searchsorted(on, rough)] = radius
    q = np.concatenate([edges.T @ problem.g, np.zeros(s)])
    return FrictionLCP(LCP(M, q), problem.contacts, edges)


def _edge_columns(
    problem: ContactProblem, on: IntArray, rough: IntArray
) -> tuple[FloatArray, FloatArray, IntArray]:
    """Return unit normal forces, unit forces along the pyramids' edges, and the contact of each edge."""
    size, facets = 3 * problem.contacts, int(problem.facets or 0)
    normals = np.zeros((size, on.size))
    normals[3 * on + 2, np.arange(on.size)] = 1.0
    rays = FrictionPyramid(1.0, facets, problem.fit).rays[:, :2]
    rays = rays / np.linalg.norm(rays, axis=1, keepdims=True)
    shares = np.zeros((size, rough.size * facets))
    for j, k in enumerate(rough):
        shares[3 * k : 3 * k + 2, j * facets : (j + 1) * facets] = rays.T
    return normals, shares, np.repeat(np.arange(rough.size), facets)
