"""The convex-law solver "distribution" on general Delassus operators, against Clarabel."""

import numpy as np
import pytest

import surefoot as sf
from tests.contact.solvers.convex_oracle import convex_forces


def convex_problem(seed, n, rank, scale=1.0):
    """Return a convex-law problem with a G of the given rank whose optimum is attained."""
    rng = np.random.default_rng(seed)
    J = rng.normal(size=(3 * n, rank)) * 10.0 ** (scale * rng.uniform(-1, 1, rank))
    G = J @ J.T
    g = G @ rng.normal(size=3 * n)
    g[2::3] += np.abs(rng.normal(size=n))
    return sf.ContactProblem(G, g, rng.uniform(0.1, 1.2, n), law="convex")


def objective(problem, f):
    x = f.ravel()
    return 0.5 * x @ problem.G @ x + problem.g @ x


@pytest.mark.parametrize(("n", "rank"), [(1, 3), (2, 8), (4, 12), (4, 6), (8, 10), (16, 18), (30, 40)])
def test_solves_any_rank(n, rank):
    for seed in range(6):
        problem = convex_problem(seed, n, rank, 0.5)
        found = sf.solve(problem, solver="distribution", tol=1e-8)
        assert found.solved
        assert found.residuals.cone_violation < 1e-12 * max(1.0, np.abs(found.forces).max())
        best = objective(problem, convex_forces(problem, 1e-8))
        assert objective(problem, found.forces) <= best + 1e-7 * (abs(best) + 1.0)


def test_bounds_and_contacts_switched_off():
    problem = convex_problem(1, 5, 15)
    high = np.array([1.0, 0.0, 2.0, np.inf, 3.0])
    bounded = sf.ContactProblem(problem.G, problem.g, problem.mu, [0.5, 0.0, 0.0, 0.1, 3.0], high, "convex")
    found = sf.solve(bounded, solver="distribution", tol=1e-10)
    assert found.solved
    assert np.all(found.forces[1] == 0.0)
    assert found.forces[4, 2] == pytest.approx(3.0, rel=1e-14)


def test_diagonal_and_zero_operators():
    g = np.array([0.3, -0.1, -2.0, 0.0, 0.0, 1.0])
    scaled = sf.solve(sf.ContactProblem(2.0 * np.eye(6), g, 0.5, law="convex"), solver="distribution")
    assert scaled.solved
    np.testing.assert_allclose(scaled.forces, [[-0.15, 0.05, 1.0], [0.0, 0.0, 0.0]], atol=1e-12)
    nothing = sf.solve(sf.ContactProblem(np.zeros((3, 3)), g[3:], 0.5, law="convex"), solver="distribution")
    assert nothing.solved


def test_warm_start_saves_iterations():
    problem = convex_problem(2, 8, 10)
    cold = sf.solve(problem, solver="distribution", tol=1e-8)
    warm = sf.solve(problem, solver="distribution", tol=1e-8, warm_start=cold.forces)
    assert warm.solved
    assert warm.iterations < cold.iterations


def test_refuses_what_it_cannot_take():
    problem = convex_problem(0, 2, 6)
    coulomb = sf.ContactProblem(problem.G, problem.g, problem.mu)
    with pytest.raises(sf.ProblemError, match="distribution does not solve law='coulomb'"):
        sf.solve(coulomb, solver="distribution")
    with pytest.raises(sf.ProblemError, match="distribution takes exact cones only"):
        sf.solve(problem.polyhedral(8), solver="distribution")


def test_unbounded_problem_is_not_called_solved():
    """Without stiffness and with a pulling g there is no optimum: bounded work, an honest status."""
    problem = sf.ContactProblem(np.zeros((3, 3)), [0.0, 0.0, -1.0], 0.5, law="convex")
    found = sf.solve(problem, solver="distribution", max_time=1.0)
    assert not found.solved
    assert np.isfinite(found.forces).all()


def test_badly_scaled_operators():
    """Eigenvalues over twelve decades: lawful velocities, and soft directions are not forgotten."""
    rng = np.random.default_rng(0)
    compared = 0
    for _ in range(40):
        J = rng.normal(size=(12, 12)) * 10.0 ** rng.uniform(-3, 3, 12)
        problem = sf.ContactProblem(J @ J.T, rng.normal(size=12) * 10, 0.5, 1.0, 100.0, law="convex")
        found = sf.solve(problem, solver="distribution", tol=1e-9)
        assert found.residuals.velocity_error <= 1e-9
        assert found.residuals.rounding <= 1e-9
        assert found.residuals.energy_gap <= 5e-9
        reference = convex_forces(problem, 1e-9)
        if sf.residuals(problem, reference).worst <= 1e-7:
            best = objective(problem, reference)
            assert objective(problem, found.forces) <= best + 1e-6 * abs(best)
            compared += 1
    assert compared > 15
