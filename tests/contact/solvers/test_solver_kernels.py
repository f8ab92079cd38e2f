"""What kernels promise by themselves: right derivatives, signs of bad input, one answer by two ways."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import surefoot as sf
from surefoot.contact.cones.polyhedral import FrictionPyramid
from surefoot.contact.problem import blocks
from surefoot.contact.solvers import admm, newton_step, nsgs, one_contact, pyramid_projection, scaled, solver


def problem(seed: int, contacts: int = 4, law: str = "coulomb") -> sf.ContactProblem:
    rng = np.random.default_rng(seed)
    J = rng.normal(size=(3 * contacts, 5 * contacts))
    coupled = np.kron(sum(np.eye(contacts, k=k) for k in (-1, 0, 1)), np.ones((1, 5)))
    J *= np.repeat(coupled, 3, axis=0)
    low = np.where(np.arange(contacts) == 1, 0.05, 0.0)
    high = np.where(np.arange(contacts) == 2, 0.2, np.inf)
    g = rng.normal(size=3 * contacts) - np.tile([0, 0, 0.5], contacts)
    mu = rng.uniform(0.1, 0.8, contacts)
    return sf.ContactProblem(J @ J.T, g, mu, low, high, law)  # type: ignore[arg-type]


def laws(p: sf.ContactProblem) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    return p.mu, p.normal_min, p.normal_max


@pytest.mark.parametrize("facets", [3, 4, 8])
@pytest.mark.parametrize("fit", ["inner", "outer"])
def test_pyramid_projection_and_shift(facets: int, fit: str) -> None:
    rng = np.random.default_rng(facets)
    for _ in range(40):
        x, mu = rng.normal(size=3), rng.uniform(0.1, 1.2)
        cone = FrictionPyramid(mu, facets, fit)  # type: ignore[arg-type]
        found = pyramid_projection.project_any(*x, mu, 0.0, np.inf, facets, fit == "inner")
        assert np.allclose(found, cone.project(x), atol=1e-9)
        limit = max(-cone.rays[:, :2] @ x[:2])
        found = pyramid_projection.shift_any(x[0], x[1], mu, facets, fit == "inner")
        assert found == pytest.approx(limit, abs=1e-12)


def test_a_checked_copy_says_what_the_checked_mirror_says() -> None:
    """On sound matrices, rank-deficient and scaled ones, and such as break one of the signs."""
    rng, verdicts = np.random.default_rng(4), []
    for turn in range(400):
        n = int(rng.integers(1, 5))
        J = rng.normal(size=(3 * n, int(rng.integers(1, 3 * n + 2))))
        G = J @ J.T * 10.0 ** rng.uniform(-100, 100)
        i, j = rng.integers(0, 3 * n, 2)
        top = np.abs(G).max()
        if turn % 4 == 1:
            G[i, j] += top * 10.0 ** rng.uniform(-10, 0)
        elif turn % 4 == 2:
            G[i, i] -= 3.0 * top * rng.integers(0, 2)
        elif turn % 4 == 3:
            G[i, j] = rng.choice([np.nan, np.inf, -np.inf, 0.0])
        mirror, copy = G.copy(), np.empty_like(G)
        scale, gap, _, _ = blocks.checked_mirror(mirror, 1e-8)
        finite, sound = blocks.checked_copy(G, 1e-8, copy)
        assert finite == np.isfinite(G).all() == (scale < np.inf)
        if finite:
            assert sound == (0.0 <= gap <= 1e-8 * scale)
            assert np.array_equal(copy, 0.5 * (G + G.T))
        verdicts.append((finite, sound and finite))
    assert set(verdicts) == {(True, True), (True, False), (False, False)}


@pytest.mark.parametrize("law", ["coulomb", "convex"])
def test_newton_step_solves_the_linearised_equations(law: str) -> None:
    """Near a solution one step of the kernels must square the error: the test of a right derivative."""
    for seed in range(6):
        p = problem(seed, 4, law)
        exact = sf.solve(p, tol=1e-13)
        if not exact.residuals.velocity_error < 1e-12:
            continue
        rng = np.random.default_rng(seed)
        errors = []
        for size in (1e-3, 1e-4):
            start = exact.forces.ravel() + size * rng.normal(size=12) * np.abs(exact.forces).max()
            local = np.empty((4, one_contact.WIDTH))
            nsgs.fill_dense(p.G, p.scales, local)
            force, u = start.copy(), p.G @ start + p.g
            newton_step.newton_dense(p.G, p.g, *laws(p), law == "convex", 0.0, 1, 0.1, local, force, u)
            errors.append(np.abs(force - exact.forces.ravel()).max())
        assert errors[0] < 1e-3
        assert errors[1] < max(0.1 * errors[0], 1e-9), (seed, errors)


def test_fields_read_late_are_those_read_at_once() -> None:
    """Solutions of the compiled call cut their arrays out of a buffer: nothing may tell them apart."""
    p = problem(3, 4)
    found = sf.solve(p)
    assert found.solved
    assert found.forces.shape == found.velocities.shape == (4, 3)
    assert np.allclose(found.velocities, p.velocity(found.forces), atol=1e-12)
    again = sf.residuals(p, found.forces)
    assert found.residuals == again
    assert pickle.loads(pickle.dumps(sf.solve(p))).forces.tolist() == found.forces.tolist()
    assert "velocity_error" in repr(sf.solve(p))
    with pytest.raises(AttributeError, match="nothing"):
        found.nothing  # noqa: B018
    for name in ("problem", "forces", "velocities", "status", "residuals", "solver", "iterations"):
        with pytest.raises(AttributeError):
            setattr(found, name, None)


@pytest.mark.parametrize("law", ["coulomb", "convex"])
@pytest.mark.parametrize("facets", [None, 6])
def test_admm_of_few_contacts_is_that_of_many(law: str, facets: int | None) -> None:
    """The compiled loop against the one in Python, which inverts by LAPACK and looks less often."""
    p = problem(7, 5, law).replace(facets=facets)
    few = sf.solve(p, "admm", tol=1e-10)
    assert few.solved
    many = admm.run_admm(scaled.ScaledContacts(p), solver.SolverSettings(1e-10), None)
    assert np.allclose(few.forces, many.forces, atol=1e-7)
    again = sf.solve(p, "admm", tol=1e-10, warm_start=few.forces)
    assert again.solved
    assert again.iterations <= few.iterations
    short = sf.solve(p, "admm", tol=1e-14, max_iterations=7)
    assert short.iterations == 7
    assert sf.solve(p, "admm", tol=1e-300, max_time=1e-9).status.value in ("max_time", "almost")
