"""Linear complementarity problems, and contact with polyhedral friction written as one.

A PSD matrix gives an LCP that has a solution if it is feasible, not always. Polyhedral Coulomb friction
gives a matrix that is neither symmetric nor PSD but copositive: a case for Lemke's method, not for a QP.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from surefoot.arrays import FloatArray, IntArray, finite_array
from surefoot.cones import FrictionPyramid
from surefoot.contact.problem import ContactProblem
from surefoot.errors import ProblemError


class LCP:
    """Find z >= 0 with w = M z + q >= 0 and z . w = 0.

    Parameters
    ----------
    M
        (n, n), any square matrix.
    q
        (n,).

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

    def __repr__(self) -> str:
        return f"LCP(size={self.size})"

    def slack(self, z: ArrayLike) -> FloatArray:
        """Return w = M z + q: (n,)."""
        return np.asarray(self.M @ finite_array("z", z, (self.size,)) + self.q)

    def residual(self, z: ArrayLike) -> float:
        """Return max |min(z_i, s w_i)| / (s max |q|) with s = 1 / max |M|; zero at a solution.

        The size of z is left out on purpose: along a ray of an infeasible problem it would grow until any
        error looks small. The scaling makes the number the same for (c M, c q), and for (M, c q) with c z.
        """
        if self.size == 0:
            return 0.0
        scale = float(np.abs(self.M).max())
        s = 1.0 / scale if scale > 0.0 else 1.0
        x = np.asarray(z, dtype=np.float64)
        gap = float(np.abs(np.minimum(x, s * (self.M @ x + self.q))).max())
        size = s * float(np.abs(self.q).max())
        return gap / size if size > 0.0 else gap


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
    sigma = n + m + owner
    M[n + np.arange(m), sigma] = 1.0
    M[sigma, n + np.arange(m)] = -1.0
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
