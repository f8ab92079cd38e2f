"""A contact problem of any kind in scaled variables, and the velocity error there, for ADMM and Newton.

λ = D λ' with a D that is equal within a contact but for the lengths that its moments are counted over, so
that cones stay what they are; it gives every block of G the trace of its rows.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.contact.problem.problem import ContactProblem
from surefoot.contact.solvers.set_kernels import WIDTH, Packing, natural_sets, pack, pack_cones


def scaling(problem: ContactProblem) -> FloatArray:
    """Return the (m,) scale of each row."""
    contacts = problem.contact_set
    counts = np.diff(contacts.offsets)
    trace = problem.scales[2] / counts
    top = trace.max(initial=0.0)
    trace = np.where(trace > 1e-12 * top, trace, top if top > 0.0 else 1.0)
    return contacts.lengths * np.repeat(1.0 / np.sqrt(trace), counts)


def measure_of(problem: ContactProblem, unit: FloatArray) -> FloatArray:
    """Return the step and weight of `natural_sets`, (2, n), for contacts in so large units of force (n,)."""
    w, s = problem.scales[:2]
    moving = s > 0.0
    w = np.where(w > 0.0, w, np.where(moving, s, 1.0))
    return np.array([1.0 / (w * unit * unit), np.where(moving, w * unit / np.where(moving, s, 1.0), 0.0)])


class ScaledContacts:
    """A problem in scaled variables, packed for `set_kernels`.

    Attributes
    ----------
    problem
        What is scaled.
    D, G, g
        (m,) the scale of each row, and the problem in the scaled variables; G is made dense when it is read.
    packed
        What `set_kernels` takes.
    step, weight
        (n,); see `natural_sets`, as for `point` and `gap` (m,).
    """

    def __init__(self, problem: ContactProblem) -> None:
        self.problem, n, m = problem, problem.contacts, problem.g.size
        self.packed: Packing
        if problem.general:
            self.D, contacts = scaling(problem), problem.contact_set
            unit = self.D[contacts.normal_rows]
            self.packed, measure = pack(contacts, problem.law, unit), measure_of(problem, unit)
        else:
            self.D, measure = np.empty(m), np.empty((2, n))
            self.packed = np.empty(n + 1, dtype=np.int64), np.empty(m, dtype=np.int64), np.zeros((n, WIDTH))
            shape = problem.law.shift, problem.facets or 0, problem.fit == "inner"
            pack_cones(problem.vectors, problem.scales, *shape, self.D, *self.packed, measure)
        self.step, self.weight = measure
        self.g = self.D * problem.g
        self.point, self.gap = np.empty(m), np.empty(m)

    @cached_property
    def G(self) -> FloatArray:
        """The dense (m, m) operator in the scaled variables."""
        return np.asarray(self.D[:, None] * self.problem.G * self.D)

    @property
    def normals(self) -> IntArray:
        """(n,) the rows of the normal forces."""
        problem = self.problem
        return problem.contact_set.normal_rows if problem.general else np.arange(2, problem.g.size, 3)

    def velocities(self, z: FloatArray) -> FloatArray:
        """Return the scaled velocities of scaled (m,) forces."""
        forces = (z * self.D).reshape(self.problem.shape)
        return np.asarray(self.D * self.problem.velocity(forces).ravel())

    def measure(self, z: FloatArray) -> tuple[FloatArray, float]:
        """Return the velocities of scaled (m,) forces, and the velocity error; fills `point` and `gap`."""
        u = self.velocities(z)
        return u, float(natural_sets(*self.packed, self.step, self.weight, z, u, self.point, self.gap))
