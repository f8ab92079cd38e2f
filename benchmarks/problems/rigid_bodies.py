"""Free rigid bodies that touch: contact Jacobians and Delassus operators for generated problems."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import scipy.sparse as sp

from surefoot.base.arrays import FloatArray
from surefoot.base.spatial import GRAVITY, skew
from surefoot.contact.problem import ContactProblem


def tangents(normal: FloatArray) -> FloatArray:
    """Return a (3, 3) rotation whose columns are (tangent, tangent, normal)."""
    n = normal / np.linalg.norm(normal)
    seed = np.eye(3)[np.argmin(np.abs(n))]
    x = np.cross(seed, n)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(n, x), n])


@dataclass
class Scene:
    """Rigid bodies in world axes and the contacts between them.

    `time_step` is the step over which gravity acts [s]; velocities are twists at the bodies' centres.
    """

    time_step: float = 2e-3
    masses: list[float] = field(default_factory=list)
    inertias: list[FloatArray] = field(default_factory=list)
    centres: list[FloatArray] = field(default_factory=list)
    twists: list[FloatArray] = field(default_factory=list)
    contacts: list[tuple[int, int, FloatArray, FloatArray, float]] = field(default_factory=list)

    def box(self, centre: FloatArray, size: FloatArray, mass: float, twist: FloatArray | None = None) -> int:
        """Add a box with edges `size` (3,) [m] at a centre (3,) with a twist (6,); return its number."""
        a, b, c = np.asarray(size) ** 2
        return self.body(centre, mass, np.diag([b + c, a + c, a + b]) * mass / 12.0, twist)

    def sphere(self, centre: FloatArray, radius: float, mass: float, twist: FloatArray | None = None) -> int:
        """Add a solid sphere at a centre (3,) [m] with a twist (6,) [m/s, rad/s]; return its number."""
        return self.body(centre, mass, 0.4 * mass * radius**2 * np.eye(3), twist)

    def body(
        self, centre: FloatArray, mass: float, inertia: FloatArray, twist: FloatArray | None = None
    ) -> int:
        """Add a body: centre (3,) [m], inertia (3, 3) [kg m²], twist (6,) [m/s, rad/s]; return its number."""
        self.masses.append(float(mass))
        self.inertias.append(np.asarray(inertia, dtype=np.float64))
        self.centres.append(np.asarray(centre, dtype=np.float64))
        self.twists.append(np.zeros(6) if twist is None else np.asarray(twist, dtype=np.float64))
        return len(self.masses) - 1

    def touch(self, body: int, other: int, point: FloatArray, normal: FloatArray, mu: float) -> None:
        """Add a contact at a point (3,) [m]; the normal (3,) is from `other` (-1: the ground) into `body`."""
        self.contacts.append(
            (body, other, np.asarray(point, dtype=np.float64), np.asarray(normal, dtype=np.float64), mu)
        )

    def jacobian(self) -> sp.csr_matrix:
        """Return the (3n, 6 bodies) map from twists to contact velocities."""
        rows, columns, values = [], [], []
        for k, (body, other, point, normal, _) in enumerate(self.contacts):
            turn = tangents(normal).T
            for which, sign in ((body, 1.0), (other, -1.0)):
                if which < 0:
                    continue
                block = sign * np.hstack([turn, -turn @ skew(point - self.centres[which])])
                i, j = np.meshgrid(3 * k + np.arange(3), 6 * which + np.arange(6), indexing="ij")
                rows.append(i.ravel())
                columns.append(j.ravel())
                values.append(block.ravel())
        shape = (3 * len(self.contacts), 6 * len(self.masses))
        entries = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
        return sp.csr_matrix(entries, shape=shape)

    def inverse_mass(self) -> sp.csr_matrix:
        """Return the inverse of the mass matrix."""
        blocks = [
            sp.block_diag([np.eye(3) / m, np.linalg.inv(inertia)])
            for m, inertia in zip(self.masses, self.inertias, strict=True)
        ]
        return sp.csr_matrix(sp.block_diag(blocks))

    def problem(self, restitution_free_gap: FloatArray | None = None) -> ContactProblem:
        """Return the contact problem of one time step under gravity (impulses, velocities), G sparse."""
        J = self.jacobian()
        fall = np.zeros(6 * len(self.masses))
        fall[2::6] = -GRAVITY * self.time_step
        g = J @ (np.concatenate(self.twists) + fall)
        if restitution_free_gap is not None:
            g[2::3] += restitution_free_gap / self.time_step
        G = (J @ self.inverse_mass() @ J.T).tocsr()
        mu = np.array([c[4] for c in self.contacts])
        problem = ContactProblem(0.5 * (G + G.T), g, mu)
        roots = [np.linalg.cholesky(np.linalg.inv(inertia)) for inertia in self.inertias]
        blocks = [sp.block_diag([np.eye(3) / m**0.5, r]) for m, r in zip(self.masses, roots, strict=True)]
        problem.factor = (J @ sp.block_diag(blocks)).tocsr()
        return problem
