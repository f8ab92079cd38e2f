"""Look for a direction that proves a contact problem infeasible.

The directions that prove something form a cone C = {d in D : G d = 0} (`problem.proof`); the projection of
-g onto it is not zero exactly if one of them has g·d < 0. With V an orthonormal basis of the range of G, that
projection is the residual of a least-squares problem::

    min over z of 1/2 ||P_D(-(g + V z))||²,   d = P_D(-(g + V z)),   gradient -Vᵀ d

how near the velocities u = g + V z can come to lawful ones if forces were free: smooth, convex, and solved by
semismooth Newton steps with a line search, a handful where D is polyhedral.

A linear program is asked first: min g·d over rays of D (pyramids of eight in a round cone), of which G wants
nothing. It finds in milliseconds what is plain, and needs no decomposition of G.

Source: J. J. Moreau, "Décomposition orthogonale d'un espace hilbertien selon deux cônes mutuellement
polaires", 1962; L. Qi, J. Sun, "A nonsmooth version of Newton's method", Math. Programming 58, 1993.

Limits: dense matrices; a null space that is only nearly there gives a reach too short to count.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import working_time
from surefoot.contact.laws import Law
from surefoot.contact.problem.problem import ContactProblem
from surefoot.contact.problem.proof import InfeasibilityProof, check_proof, connected_parts
from surefoot.contact.sets import ContactKind, ContactSet
from surefoot.contact.solvers.set_kernels import (
    CODE,
    CONE,
    DISCS,
    FREE,
    HIGH,
    LOW,
    MOST_DISCS,
    RADIUS,
    SHIFT,
    SIDES,
    WIDEST,
    jacobian_sets,
    pack,
    project_sets,
)

STEPS, SHARES = 60, 0.5 ** np.arange(20)
"""Newton steps, and the shares of one that the line search tries."""
NULL = 1e-10
"""Eigenvalues of the scaled G below this share of the largest count as zero."""
VANISHED = 1e-9
"""A direction this much shorter than g is none: the problem has solutions, or only just not."""
DECOMPOSITION = 2e-8
"""Seconds that the decomposition takes, over the cube of the number of contacts."""
LARGEST = 700
"""Contacts up to which the dense decomposition is worth its time."""


def find_proof(
    problem: ContactProblem, max_time: float = math.inf, plain: bool = False
) -> InfeasibilityProof | None:
    """Return a conclusive proof that a problem has no solution, or None if none was found.

    The time [s] is looked at between parts and steps; parts too large for it are left out. Part by part:
    what is joined by nothing has nothing to do with each other, and may differ in size. A `plain` one is
    what the linear program finds: mostly there is one, and to look for it takes a tenth of the time.
    """
    if not 0 < problem.contacts <= LARGEST:
        return None
    contacts, label = problem.contact_set, connected_parts(problem)
    speeds = problem.scales[1]
    end = working_time() + max_time
    for name in np.argsort(np.bincount(label), kind="stable"):  # the smallest first: their time is short
        members = np.flatnonzero(label == name)
        # at rest without forces: solved by the nearest to zero, there is nothing to prove
        if float(speeds[members].max()) == 0.0:
            continue
        rows = np.concatenate([np.arange(*contacts.offsets[k : k + 2]) for k in members])
        part = _Directions([contacts[k] for k in members], problem.law)
        for found in _part_directions(part, problem.G[np.ix_(rows, rows)], problem.g[rows], end, plain):
            direction = np.zeros(problem.g.size)
            direction[rows] = found
            proof = check_proof(problem, direction)
            if proof is not None and proof.conclusive:
                return proof
    return None


def _part_directions(
    directions: _Directions, G: FloatArray, g: FloatArray, end: float, plain: bool
) -> Iterator[FloatArray]:
    """Yield directions of one connected part, flat, that may be a proof: what is cheap first, or it alone."""
    L = directions.lengths
    trace = np.add.reduceat(np.diagonal(G) * L * L, directions.starts)
    scale = 1.0 / np.sqrt(np.where(trace > 0.0, trace, 1.0))  # blocks of one size; one factor keeps a cone
    D = L * np.repeat(scale, np.diff([*directions.starts, g.size]))
    G, g = D[:, None] * G * D[None, :], D * g
    size = float(np.linalg.norm(g))
    if not 0.0 < size < np.inf:
        return
    with np.errstate(all="ignore"):
        d = _by_rays(directions.rays(), G, g / size, end)
        if d is not None:
            yield np.asarray(D * _onto_null_space(directions, G, d))
        # eigenvectors cost the cube of the contacts: not begun where the time would not do
        if plain or DECOMPOSITION * directions.starts.size**3 > end - working_time():
            return
        values, vectors = np.linalg.eigh(G)
        V = vectors[:, values > NULL * max(float(values[-1]), 1e-300)]
        d = _project(directions, V, g / size, end)
        if d is not None:
            yield np.asarray(D * _onto_null_space(directions, G, d))


def _by_rays(rays: FloatArray, G: FloatArray, g: FloatArray, end: float) -> FloatArray | None:
    """Return the best direction among sums of the rays' columns (m, c), None if there is none.

    G is positive semidefinite: G d = 0 for d = rays β exactly if raysᵀ G rays β = 0, with far fewer rows.
    """
    left = end - working_time()
    if rays.shape[1] == 0 or left <= 0.0:
        return None
    limit = {"time_limit": left} if left < math.inf else {}
    # β <= 1 only bounds the program: any positive multiple of a proof is one
    rows = rays.T @ G @ rays
    from scipy.optimize import linprog  # takes 0.2 s to import: only where a proof is looked for

    found = linprog(
        rays.T @ g, A_eq=rows, b_eq=np.zeros(len(rows)), bounds=(0.0, 1.0), method="highs", options=limit
    )  # type: ignore[call-overload]
    return None if found.x is None or not found.fun < -VANISHED else np.asarray(rays @ found.x)


def _onto_null_space(directions: _Directions, G: FloatArray, d: FloatArray) -> FloatArray:
    """Move d within its face of D onto the null space of G: what is left of G d is then rounding."""
    J = directions.project(d)[1]
    # an edge of the cone counts as the ray through d: its roundness is left out
    columns = []
    for k, (start, end) in enumerate(itertools.pairwise([*directions.starts, d.size])):
        own = slice(start, end)
        p = d[own]
        size = float(np.linalg.norm(p))
        if size == 0.0:
            continue
        block = np.eye(p.size) if np.trace(J[k]) > p.size - 0.5 else (p / size)[:, None]
        whole = np.zeros((d.size, block.shape[1]))
        whole[own] = block
        columns.append(whole)
    # d = C x: within the contacts that d loads, and x -> x - A⁺ A x is the nearest x with G C x = 0; twice,
    # since once leaves the rounding of a first correction
    C = np.hstack(columns)
    x = C.T @ d
    A = G @ C
    for _ in range(2):
        x = x - np.linalg.lstsq(A, A @ x, rcond=NULL)[0]
    return np.asarray(C @ x)


class _Directions:
    """The cone D of some contacts: where a direction may lie, contact by contact; see `proof`.

    `starts` (n,) is the first row of each contact, `lengths` (m,) what moments are counted over.
    """

    def __init__(self, chosen: list[ContactKind], law: Law) -> None:
        contacts = ContactSet(chosen)
        self.starts, self.lengths = contacts.offsets[:-1], contacts.lengths
        offset, group, table = pack(contacts, law, np.ones(len(chosen)))
        for row, start, contact in zip(table, self.starts, chosen, strict=True):
            row[LOW], row[HIGH] = 0.0, np.inf if contact.normal_max == np.inf else 0.0
            if row[CODE] == CONE:
                row[CODE], row[SIDES] = DISCS, 0.0
            for b, disc in enumerate(contact.discs_inside):
                row[RADIUS + b] = disc.radius * (1.0 - row[SHIFT] if disc.friction else 1.0)
                group[start + np.array(disc.rows)] = b
        self.packed = offset, group, table

    def rays(self) -> FloatArray:
        """Return directions (m, c) of D that span it, or nearly: eight around a disc; over the lengths."""
        offset, group, table = self.packed
        columns: list[tuple[list[int], FloatArray]] = []
        for k, (start, end) in enumerate(itertools.pairwise(offset)):
            rows = list(range(start, end))
            if table[k, CODE] == FREE:
                columns += [(rows, ray) for ray in _around(end - start)]
            elif table[k, HIGH] == np.inf:
                normal = [i for i in rows if group[i] < 0]
                columns.append((normal, np.ones(1)))
                for b in range(MOST_DISCS):
                    disc, radius = [i for i in rows if group[i] == b], table[k, RADIUS + b]
                    if disc and radius > 0.0:
                        columns += [(normal + disc, np.append(1.0, radius * e)) for e in _around(len(disc))]
        out = np.zeros((offset[-1], len(columns)))
        for at, (places, values) in enumerate(columns):
            out[places, at] = values
        return out

    def project(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return P_D(x) and its generalised Jacobian, (n, d, d), for flat x over the lengths."""
        out, J = np.empty(x.size), np.empty((self.starts.size, WIDEST, WIDEST))
        project_sets(*self.packed, x, out)
        jacobian_sets(*self.packed, x, J)
        return out, J

    def product(self, J: FloatArray, V: FloatArray) -> FloatArray:
        """Return the product (m, c) of the Jacobian, contact by contact (n, d, d), and a matrix (m, c)."""
        out = np.empty_like(V)
        for block, (start, end) in zip(J, itertools.pairwise(self.packed[0]), strict=True):
            out[start:end] = block[: end - start, : end - start] @ V[start:end]
        return out


def _around(size: int) -> FloatArray:
    """Return unit vectors (k, size) on all sides: eight in a plane, else the axes both ways."""
    if size != 2:
        return np.vstack([np.eye(size), -np.eye(size)])
    turn = np.arange(8) * math.pi / 4.0
    return np.column_stack([np.cos(turn), np.sin(turn)])


def _project(directions: _Directions, V: FloatArray, g: FloatArray, end: float) -> FloatArray | None:
    """Return the projection of -g onto C, for g of length one; None if it vanishes."""
    rank = V.shape[1]
    z = np.zeros(rank)
    d, J = directions.project(-g)
    value = float(d @ d)
    for _ in range(STEPS):
        if value <= VANISHED**2 or working_time() > end:
            return None
        gradient = V.T @ d
        if float(np.linalg.norm(gradient)) <= 1e-15 * np.sqrt(value):
            break
        H = V.T @ directions.product(J, V)
        # where P_D is constant its Jacobian vanishes, and H with it
        H[np.diag_indices(rank)] += 1e-12
        step = np.linalg.solve(H, gradient)
        for share in SHARES:
            # the minimum is 0 or not, nothing else is asked: any decrease will do
            trial, jacobian = directions.project(-(g + V @ (z + share * step)))
            now = float(trial @ trial)
            if now < value:
                break
        else:
            break
        z, d, J, value = z + share * step, trial, jacobian, now
    return d if value > VANISHED**2 else None
