"""The real-time path: one problem after another with the same contacts, a new G and g every call.

`solve` reads a `ContactProblem`, which checks and keeps all it is given; a simulator that has another
matrix every step pays for that each time. A `ContactSolver` knows the laws of its contacts beforehand and
hands a raw matrix to one compiled call that checks it, solves, and certifies the answer as `solve` would.
"""

from __future__ import annotations

import math
from dataclasses import astuple
from typing import Any, Unpack

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, numbers, real_number, whole_number
from surefoot.base.errors import ProblemError
from surefoot.base.kernels import (
    BOOLEAN,
    INTEGER,
    MATRIX,
    REAL,
    VECTOR,
    borrowed,
    entry_point,
    inline_kernel,
    releasing_kernel,
    window,
)
from surefoot.contact.problem.matrix import ASYMMETRY
from surefoot.contact.problem.problem import ContactOptions, ContactProblem
from surefoot.contact.problem.proof import InfeasibilityProof
from surefoot.contact.solution import Certified, Status, record_of
from surefoot.contact.solvers.compiled import (
    COMPILED_CONTACTS,
    CONVEX_CALL,
    DOUBTFUL,
    FIRST,
    NOT_NUMBERS,
    UNBOUNDED,
    UNSOLVED,
    WARM,
    WORK,
    read_system,
    solve_within,
)
from surefoot.contact.solvers.solver import solve

FLOAT = np.dtype(np.float64)
_empty, _ndarray, _SOLVED = np.empty, np.ndarray, Status.SOLVED
_FASTER = 10.0
"""Times the free velocity that the last forces may give the contacts and still be a start."""
LAWS, FLAGS, COMPLIANCE, LAST = 1, 2, 3, 4
"""Rows of the solver's memory after G and g: see `_solve_raw`."""


@inline_kernel
def _of_this_size(G: FloatArray, g: FloatArray, forces: FloatArray) -> bool:
    """Return whether forces (m,) of another call move the contacts about as fast as the free velocity g does.

    Where they move them much faster (that call was a wild one) nothing is a better start than they are.
    """
    fastest, free = 0.0, 0.0
    for i in range(g.size):
        moved = 0.0
        for j in range(g.size):
            moved += G[i, j] * forces[j]
        fastest, free = max(fastest, abs(moved)), max(free, abs(g[i]))
    return fastest <= _FASTER * free


@releasing_kernel
def _solve_raw(
    G: FloatArray, g: FloatArray, memory: FloatArray, tol: float, most: int, warm: bool, buffer: FloatArray
) -> int:
    """Solve with a new G (m, m) and g (m,); return what `solve_compiled` does.

    The rows of memory (at least m + 5, m): room for G and g, the parameters (mu, low, high), the mode of the
    law and whether the last row holds forces, the compliance, the last forces, and the scratch memory of
    `solve_within`. The buffer is `solve_compiled`'s.
    """
    m = g.size
    start = warm and memory[m + FLAGS, 1] != 0.0
    # forgotten until this call has solved: an unsolved one must not start the next
    memory[m + FLAGS, 1] = 0.0
    matrix, vectors = window(memory, 0, m, m), window(memory, m * m, 2, m)
    refused = read_system(borrowed(G), borrowed(g), ASYMMETRY, matrix, vectors)
    if refused != 0:
        return refused
    for i in range(m):
        # after the check: the caller's G is judged as it was given
        memory[i, i] += memory[m + COMPLIANCE, i]
    start = start and _of_this_size(matrix, vectors[0], memory[m + LAST])
    if start:
        for k in range(m // 3):
            for a in range(3):
                buffer[k, a] = memory[m + LAST, 3 * k + a]
    mode = int(memory[m + FLAGS, 0]) | FIRST
    if start:
        mode |= WARM
    done = solve_within(matrix, vectors, tol, most, mode, borrowed(buffer), memory, (m + LAST + 1) * m)
    # a solved answer is the next call's start
    if done < UNSOLVED:
        for k in range(m // 3):
            for a in range(3):
                memory[m + LAST, 3 * k + a] = buffer[k, a]
        memory[m + FLAGS, 1] = 1.0
    return done


class ContactForces(Certified):
    """What a `ContactSolver` returns: forces and velocities that it owns, and their certificate.

    Attributes
    ----------
    forces, velocities
        (n, 3) contact frames (tangent, tangent, normal) [N s, m/s, or N, m/s²]; for a problem that was not
        solved the best that was found, always finite.
    status
        See `Status`; INVALID for a G or g with entries that are not finite.
    iterations
        Sweeps and Newton steps.
    proof
        The proof that there is no solution where the status is INFEASIBLE, else None.
    """

    __slots__ = ("iterations", "proof")

    def __init__(
        self,
        buffer: FloatArray,
        contacts: int,
        status: Status,
        iterations: int,
        proof: InfeasibilityProof | None = None,
    ) -> None:
        self._record, self._forces, self._status = buffer, buffer[:contacts], status
        self.iterations, self.proof = iterations, proof

    @property
    def velocity_error(self) -> float:
        """The first field of `residuals` [-]."""
        return float(self._record[2 * len(self._forces), 0])

    def __repr__(self) -> str:
        return (
            f"ContactForces({self.status.name}, contacts={len(self._forces)}, "
            f"velocity_error={self.velocity_error:.1e}, iterations={self.iterations})"
        )


class ContactSolver:
    """Solve contact problems with the same contacts and laws, and a new G and g every call.

    Preallocated; the arguments are those of `ContactProblem` and `solve`. Up to 128 contacts on exact cones a
    call is one compiled one, and what that leaves is handed to the other methods of `auto`. It never raises
    for a hard problem: look at the status. One for each thread run at once, the compiled call releases
    the interpreter's lock; a call while another thread is in one of the same solver is refused.

    Parameters
    ----------
    contacts
        Their number n.
    mu, law, normal_min, normal_max
        As for `ContactProblem`.
    tol
        Wanted velocity error and rounding, see `Residuals`.
    max_iterations
        Bound on sweeps and Newton steps of a call, all methods together: 10,000 are about 10 ms of four
        contacts. None for the methods' own bounds, which may take seconds on a problem without solution.
    warm_start
        Whether a call starts from the forces of the last, if that was solved; see `reset`.
    **options
        facets, fit, bilateral and compliance, as for `ContactProblem`.

    Raises
    ------
    ProblemError
        If an argument is out of range.

    Examples
    --------
    >>> import numpy as np
    >>> contacts = ContactSolver(contacts=1, mu=0.5)
    >>> answer = contacts.solve(np.eye(3), np.array([0.0, 0.0, -2.0]))
    >>> answer.status.value, answer.forces.round(6).tolist()
    ('solved', [[0.0, 0.0, 2.0]])
    """

    def __init__(
        self,
        contacts: int,
        mu: ArrayLike,
        law: str = "coulomb",
        normal_min: ArrayLike = 0.0,
        normal_max: ArrayLike = np.inf,
        *,
        tol: float = 1e-8,
        max_iterations: int | None = 10_000,
        warm_start: bool = True,
        **options: Unpack[ContactOptions],
    ) -> None:
        self.contacts = n = whole_number("contacts", contacts, low=1)
        self.tol = real_number("tol", tol, low=0.0, high=1e300)
        self.max_iterations = (
            None if max_iterations is None else whole_number("max_iterations", max_iterations)
        )
        self.warm_start = bool(warm_start)
        m = 3 * n
        # the problem's own checks; a zero matrix with the compliance on its diagonal
        self._laws = ContactProblem(np.zeros((m, m)), np.zeros(m), mu, normal_min, normal_max, law, **options)
        self.law = self._laws.law
        self._memory = np.zeros((m + LAST + 1 + -(-WORK // 3), max(m, 2)))
        self._shapes = (m, m), (m,), (2 * n + 3, 3)
        self._most = UNBOUNDED if self.max_iterations is None else self.max_iterations
        # the memory's one user; to pop it from a list is atomic, and takes less time than a lock
        self._turn = [None]
        self._compiled = not self._laws.general and self._laws.facets is None and 0 < n <= COMPILED_CONTACTS
        if self._compiled:
            self._memory[m + LAWS] = self._laws.vectors[1]
            self._memory[m + FLAGS, 0] = CONVEX_CALL if self.law.shift == 0.0 else 0
            self._memory[m + COMPLIANCE] = np.diagonal(self._laws.G)
            self._bind()

    def _bind(self) -> None:
        """Find the compiled call."""
        types = MATRIX, VECTOR, MATRIX, REAL, INTEGER, BOOLEAN, MATRIX
        self._call = entry_point(_solve_raw, *types)

    def __getstate__(self) -> dict[str, Any]:
        """Return all but the compiled call, with the memory that nobody uses."""
        return {**{name: value for name, value in vars(self).items() if name != "_call"}, "_turn": [None]}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        if self._compiled:
            self._bind()

    def reset(self) -> None:
        """Forget the last forces: the next call starts from zero."""
        self._memory[3 * self.contacts + FLAGS, 1] = 0.0

    def solve(self, G: FloatArray, g: FloatArray, out: FloatArray | None = None) -> ContactForces:
        """Solve for a new matrix and free velocity.

        Parameters
        ----------
        G
            (3n, 3n) Delassus operator [1/kg], symmetric (to 1e-8 of its largest entry); the compliance is
            added.
        g
            (3n,) free velocity [m/s].
        out
            (2n + 3, 3) memory for the answer, rows in the units of forces, velocities and residuals,
            C-contiguous; without it every answer owns its own.

        Returns
        -------
        ContactForces
            Look at its `status`.

        Raises
        ------
        ProblemError
            If a shape is wrong, G not symmetric positive semidefinite, as far as `ContactProblem` sees, or
            another thread in a call; never for a problem that is hard or has no solution.
        """
        n = self.contacts
        square, row, whole = self._shapes
        if not (
            type(G) is _ndarray and type(g) is _ndarray and G.dtype is FLOAT and g.dtype is FLOAT
            and G.shape == square and g.shape == row
            and G.flags.c_contiguous and g.flags.c_contiguous
        ):  # fmt: skip
            G, g = self._read("G", G, square), self._read("g", g, row)
        if out is None:
            out = _empty(whole)
        elif not (type(out) is _ndarray and out.dtype is FLOAT and out.shape == whole and out.flags.carray):
            raise ProblemError(f"out must be a writable C-contiguous float64 array of shape {whole}")
        if not self._compiled:
            return self._solve_rest(G, g, out, 0)
        try:
            turn = self._turn.pop()
        except IndexError:
            raise ProblemError("this ContactSolver is at work in another thread: make one for each") from None
        try:
            done = self._call(G, g, self._memory, self.tol, self._most, self.warm_start, out)
        finally:
            self._turn.append(turn)
        if 0 <= done < UNSOLVED:
            return ContactForces(out, n, _SOLVED, done)
        if done == NOT_NUMBERS:
            return self._nothing(out)
        return self._solve_rest(G, g, out, 0 if done == DOUBTFUL else done - UNSOLVED)

    def _read(self, name: str, value: ArrayLike, shape: tuple[int, ...]) -> FloatArray:
        """Return an argument as the compiled call takes it."""
        array = numbers(name, value)
        if array.shape != shape:
            raise ProblemError(f"{name} must have shape {shape}, got {array.shape}")
        return array

    def _nothing(self, out: FloatArray) -> ContactForces:
        """Answer input that is not finite: the admissible forces nearest to zero, and NaN for all else."""
        n = self.contacts
        out[:n] = 0.0
        out[:n, 2] = np.maximum(self._laws.normal_min, 0.0)
        out[n:] = math.nan
        return ContactForces(out, n, Status.INVALID, 0)

    def _solve_rest(self, G: FloatArray, g: FloatArray, out: FloatArray, done: int) -> ContactForces:
        """Solve by the general path what the compiled call does not take, or left unsolved."""
        n, laws = self.contacts, self._laws
        if not (np.isfinite(G).all() and np.isfinite(g).all()):
            return self._nothing(out)
        left = None if self.max_iterations is None else max(self.max_iterations - done, 0)
        problem = laws.replace(G=G if laws.compliance is None else G + laws.G, g=g)
        start = out[:n].copy() if done > 0 and np.isfinite(out[:n]).all() else None
        found = solve(problem, "auto", self.tol, max_iterations=left, warm_start=start)
        out[:] = record_of(found.forces, found.velocities, astuple(found.residuals))
        return ContactForces(out, n, found.status, done + found.iterations, found.proof)
