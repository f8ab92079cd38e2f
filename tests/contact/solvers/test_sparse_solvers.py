"""Sparse factors give what dense ones give: ADMM's iteration."""

import numpy as np
import pytest

from benchmarks.problems.heaps import capsules, rocks
from surefoot.contact.cones import FrictionCone, ProductCone
from surefoot.contact.problem import ContactProblem, residuals
from surefoot.contact.solvers import admm
from surefoot.contact.solvers.scaled import ScaledContacts
from surefoot.contact.solvers.solver import solve


@pytest.fixture(scope="module")
def heap() -> ContactProblem:
    return capsules(np.random.default_rng(5), 40, 90, 0.5)


def test_admm_with_sparse_factors_matches_a_dense_twin(heap: ContactProblem) -> None:
    own = ScaledContacts(heap)
    s = admm.Splitting(own, None)
    assert s.sparse is not None
    rho, mu = 0.3, heap.mu
    cones = ProductCone([FrictionCone(m) for m in mu])
    x, y, z = (np.zeros(own.g.size) for _ in range(3))
    for _ in range(30):
        shift = np.zeros(own.g.size)
        shift[2::3] = mu * np.hypot(y[0::3], y[1::3])
        A, b = own.G + (rho + s.eta) * np.eye(own.g.size), rho * z - y + s.eta * x - own.g - shift
        x = np.linalg.solve(A, b)
        r = admm.RELAXATION * x + (1.0 - admm.RELAXATION) * z
        z = cones.project(r + y / rho)
        y = y + rho * (r - z)
    s.iterations(rho)(30)
    np.testing.assert_allclose(s.z, z, atol=1e-10 * np.abs(z).max())
    np.testing.assert_allclose(s.y, y, atol=1e-10 * np.abs(y).max())
    assert np.abs(z).max() > 0.0


@pytest.mark.long
def test_a_heap_of_1063_contacts_is_solved_by_its_bodies() -> None:
    problem = rocks(np.random.default_rng(1), 150, 1063, 0.5)
    assert (
        abs(problem.factor @ problem.factor.T - problem.operator).max() < 1e-9 * abs(problem.operator).max()
    )
    found = solve(problem, tol=1e-4, max_time=60.0)
    assert found.solved
    made = ContactProblem.of_factor(problem.factor, problem.g, problem.mu)
    assert made.replace(mu=0.3).factor is made.factor
    assert made.replace(G=made.operator).factor is None
    assert residuals(made, found.forces).velocity_error <= 1.1e-4


def test_admm_on_a_factor_inverts_what_it_does_on_contacts(heap: ContactProblem) -> None:
    own = ScaledContacts(heap)
    bare = ScaledContacts(ContactProblem(heap.operator, heap.g, heap.mu))
    by_blocks, by_bodies, by_contacts = (admm.Splitting(one, None) for one in (own, own, bare))
    assert by_blocks.bodies is not None
    by_bodies.bodies = None  # as of more bodies than `MOST_BLOCKS`: SuperLU's factors
    assert by_contacts.factor is None
    assert by_contacts.bodies is None
    for s in (by_blocks, by_bodies, by_contacts):
        s.iterations(0.3)(30)
    np.testing.assert_allclose(by_bodies.z, by_contacts.z, atol=1e-9)
    np.testing.assert_allclose(by_blocks.z, by_contacts.z, atol=1e-9)
