"""One problem after another with gradients: `ContactSolver` and a compiled vjp of its last answer."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from surefoot.arrays import FloatArray
from surefoot.batch.kernel import contact_vjp
from surefoot.contact.derivative_rates import Cotangents
from surefoot.contact.solution import Status
from surefoot.errors import NoSolution, ProblemError
from surefoot.kernels import BOOLEAN, MATRIX, entry_point
from surefoot.solvers.compiled import COMPILED_CONTACTS
from surefoot.solvers.contact_solver import FLOAT, ContactForces, ContactSolver

_empty, _ndarray, _SOLVED = np.empty, np.ndarray, Status.SOLVED


class DifferentiableSolver(ContactSolver):
    """A `ContactSolver` whose answers can be differentiated, for loops that run one problem at a time.

    The arguments are those of `ContactSolver`; up to 45 contacts on exact cones. The derivative is taken at
    the forces as solved, see `surefoot.batch.derivative.BatchDerivative`.

    Examples
    --------
    >>> import numpy as np
    >>> contacts = DifferentiableSolver(contacts=1, mu=0.5)
    >>> G = np.eye(3)
    >>> answer = contacts.solve(G, np.array([3.0, 0.0, -2.0]))
    >>> contacts.vjp(G, answer, velocities=np.array([[1.0, 0.0, 0.0]])).mu.round(6).tolist()
    [-2.0]
    """

    def __init__(self, contacts: int, mu: ArrayLike, *arguments: Any, **options: Any) -> None:
        super().__init__(contacts, mu, *arguments, **options)
        laws = self._laws
        if laws.general or laws.facets is not None or not 0 < self.contacts <= COMPILED_CONTACTS:
            raise ProblemError(f"gradients take exact cones and 1 to {COMPILED_CONTACTS} contacts here")
        self._own = np.ascontiguousarray(laws.vectors[1].reshape(3, -1))
        self._added = None if laws.compliance is None else laws.G
        n = self.contacts
        self._weights = np.zeros((2 * n, 3))
        self._above, self._below = (
            self._weights[:n],
            self._weights[n:],
        )  # views take longer than their filling
        self._size = 3 * self.contacts, 3 * self.contacts
        self._convex = bool(laws.law == "convex")
        self._pull = entry_point(contact_vjp, MATRIX, MATRIX, BOOLEAN, MATRIX, MATRIX, MATRIX)

    def vjp(
        self,
        G: FloatArray,
        answer: ContactForces,
        forces: ArrayLike | None = None,
        velocities: ArrayLike | None = None,
    ) -> Cotangents:
        """Return the gradient of forces·f + velocities·u for (n, 3) weights, at an answer of `solve`.

        Parameters
        ----------
        G
            The (3n, 3n) matrix that it was the answer to [1/kg].
        answer
            What `solve` returned.
        forces, velocities
            (n, 3) weights, in any unit: the gradient's is theirs times that of f or u.

        Raises
        ------
        NoSolution
            If the answer is not SOLVED.
        ProblemError
            If a shape is wrong.
        """
        n = self.contacts
        if answer.status is not _SOLVED:
            raise NoSolution(f"no derivative of an answer with status {answer.status.value!r}", None, answer)
        try:
            self._above[...] = 0.0 if forces is None else forces
            self._below[...] = 0.0 if velocities is None else velocities
        except (TypeError, ValueError) as error:
            raise ProblemError(f"forces and velocities must have shape ({n}, 3): {error}") from error
        size = self._size
        if not (type(G) is _ndarray and G.dtype is FLOAT and G.shape == size and G.flags.c_contiguous):
            G = self._read("G", G, size)
        if self._added is not None:
            G = G + self._added
        out = _empty((2 * n, 3))
        regular = self._pull(G, self._own, self._convex, answer.buffer, self._weights, out)
        return Cotangents(out, answer.forces, regular)
