"""Redundant contacts: what a contact problem determines, and what it leaves open.

If G = J M⁻¹ Jᵀ is rank-deficient, forces along its null space do nothing: they change no velocity and, M
being positive definite, no joint torque and no net wrench (Jᵀ λ). Velocities, net wrench and motion are
then as determined as ever; how the load is shared between the points is not, and any share is as good as
another.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp

from surefoot.base.arrays import BoolArray, FloatArray, of_kind, real_number
from surefoot.base.errors import ProblemError
from surefoot.contact.problem.blocks import count_blocks
from surefoot.contact.problem.problem import ContactProblem


@dataclass(frozen=True)
class Redundancy:
    """What the forces of a contact problem leave open.

    Attributes
    ----------
    rank, size
        Rank of G and the number of its rows; the difference is the number of free directions.
    null_space
        (3n, size - rank) orthonormal directions [-] of forces that change no velocity and no net wrench.
    determined
        (n, 3) mask of the force components that no such direction touches.
    """

    rank: int
    size: int
    null_space: FloatArray
    determined: BoolArray

    @property
    def redundant(self) -> bool:
        """Whether some share of the forces is left open."""
        return self.rank < self.size

    def summary(self) -> str:
        """Return one line for a log."""
        if not self.redundant:
            return f"G has full rank {self.rank}: every contact force is determined"
        loose, free = int((~self.determined).any(axis=1).sum()), self.size - self.rank
        return (
            f"G has rank {self.rank} of {self.size}: velocities and the net wrench are determined, the "
            f"forces of {loose} of {len(self.determined)} contacts only up to {free} directions"
        )


LIKELY_FEW = 0.58
"""Likely rank's share of the rows up to which contacts hold few bodies: 0.3 to 0.53 for walls of bricks, 0.66
and more for stacks and piles of spheres."""


def likely_rank(problem: ContactProblem) -> float:
    """Return about what the rank of G is, without a factorisation: that of its factor, or six per body.

    A contact of two bodies meets as many contacts as they have together, d + e, so that 4 / (d + e) is about
    its share of the bodies; for contacts of three rows.
    """
    if problem.factor is not None:
        return float(problem.factor.shape[1])
    met = np.empty(problem.contacts, dtype=np.int64)
    if isinstance(problem.operator, np.ndarray):
        count_blocks(problem.G, met)
    else:
        met = np.diff(problem.blocks.starts)
    return float(np.sum(24.0 / np.maximum(met, 1)))


NARROW, NARROW_MOST = 24, 2000
"""Contacts from one to the farthest that it meets, in a good order, up to which all are in a row; contacts up
to which that is looked at."""


def in_a_row(problem: ContactProblem) -> bool:
    """Tell whether contacts of three rows are in a row, as those of a stack: each meets near ones alone."""
    if problem.contacts > NARROW_MOST:
        return False
    b, n = problem.blocks, problem.contacts
    met: Any = sp.csr_matrix((np.ones(b.columns.size), b.columns, b.starts), shape=(n, n))
    place = np.empty(n, dtype=np.int64)
    place[sp.csgraph.reverse_cuthill_mckee(met, symmetric_mode=True)] = np.arange(n)
    row = np.repeat(np.arange(n), np.diff(b.starts))
    return bool(np.abs(place[row] - place[b.columns]).max(initial=0) <= NARROW)


def few_bodies(problem: ContactProblem) -> bool:
    """Tell whether many contacts hold few bodies, as far as `likely_rank` knows."""
    return likely_rank(problem) <= LIKELY_FEW * problem.g.size


def redundancy(problem: ContactProblem, tol: float = 1e-9) -> Redundancy:
    """Return what a contact problem's matrix determines.

    Contacts are scaled to blocks of one size first, so that light and heavy bodies count alike; eigenvalues
    below `tol` (relative) times the largest are zero. The null space is looked at before the cones: a contact
    that takes off, or a cone's boundary, can only determine more.

    Examples
    --------
    >>> import numpy as np
    >>> J = np.vstack([np.eye(3), np.eye(3)])  # two contacts of one point mass
    >>> redundancy(ContactProblem(J @ J.T, np.zeros(6), 0.5)).rank
    3
    """
    of_kind("problem", problem, ContactProblem)
    if problem.shape != (problem.contacts, 3):
        raise ProblemError("redundancy is for contacts of three rows; for others look at the rank of G")
    n, tol = problem.contacts, real_number("tol", tol, low=0.0)
    trace = np.diagonal(problem.G).reshape(-1, 3).sum(axis=1)
    scale = np.repeat(1.0 / np.sqrt(np.where(trace > 0.0, trace, 1.0)), 3)
    values, vectors = np.linalg.eigh(scale[:, None] * problem.G * scale[None, :])
    small = values <= tol * max(float(values[-1]), 0.0) if values.size else np.zeros(0, dtype=bool)
    loose = scale[:, None] * vectors[:, small]
    null_space = np.linalg.qr(loose)[0] if loose.shape[1] else np.zeros((3 * n, 0))
    touched = np.abs(null_space).max(axis=1, initial=0.0) > 1e-6
    return Redundancy(int((~small).sum()), 3 * n, null_space, ~touched.reshape(n, 3))
