"""Compiled kernels against plain NumPy twins."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import surefoot as sf
from surefoot.cones.polyhedral import FrictionPyramid
from surefoot.contact import blocks
from surefoot.solvers import (
    admm,
    lemke,
    newton_sparse,
    newton_step,
    nsgs,
    pyramid,
    scaled,
    set_kernels,
    solver,
    stopping,
)


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


def twin_project(x: np.ndarray, mu: float, low: float, high: float) -> np.ndarray:
    """Dykstra's alternating projections onto the cone and the slab."""
    cone, y, a, b = sf.FrictionCone(mu), x.copy(), np.zeros(3), np.zeros(3)
    for _ in range(3000):
        inside = cone.project(y + a)
        a = y + a - inside
        z = inside + b
        clipped = np.array([z[0], z[1], min(max(z[2], low), high)])
        b, y = z - clipped, clipped
    return y


def test_projection_and_errors() -> None:
    rng = np.random.default_rng(0)
    for _ in range(10):
        x, mu, (low, high) = rng.normal(size=3), rng.uniform(0.1, 1.0), np.sort(rng.uniform(0, 1.5, 2))
        expected = twin_project(x, mu, low, high)
        assert np.allclose(pyramid.project_any(*x, mu, low, high, 0, True), expected, atol=1e-6)
    assert pyramid.project_any(1.0, 2.0, -3.0, 0.1, -np.inf, np.inf, 0, True) == (1.0, 2.0, -3.0)
    p = problem(1)
    force, u = rng.normal(size=12), rng.normal(size=12)
    w, s = p.scales[:2]
    gaps = []
    for k in range(4):
        i = slice(3 * k, 3 * k + 3)
        shifted = u[i] + [0, 0, p.mu[k] * np.hypot(*u[i][:2])]
        gaps.append(
            force[i] - twin_project(force[i] - shifted / w[k], p.mu[k], p.normal_min[k], p.normal_max[k])
        )
    measure, gap = stopping.measure_of(p), np.linalg.norm(gaps, axis=1)
    found = stopping.velocity_error(force, u, *laws(p), measure, False)
    assert found == pytest.approx((w * gap / s).max(), rel=1e-4)
    far = stopping.force_error(force, u, p.g, *laws(p), measure, False)
    size = w @ np.sum(force.reshape(4, 3) ** 2, axis=1)
    reach = np.sum(p.g.reshape(4, 3) ** 2, axis=1) @ (1.0 / w)
    assert far == pytest.approx(np.sqrt(w @ gap**2 / max(size, reach)), rel=1e-4)
    assert stopping.velocity_error(np.full(12, np.nan), u, *laws(p), measure, False) == np.inf


@pytest.mark.parametrize("facets", [3, 4, 8])
@pytest.mark.parametrize("fit", ["inner", "outer"])
def test_pyramid_projection_and_shift(facets: int, fit: str) -> None:
    rng = np.random.default_rng(facets)
    for _ in range(40):
        x, mu = rng.normal(size=3), rng.uniform(0.1, 1.2)
        cone = FrictionPyramid(mu, facets, fit)  # type: ignore[arg-type]
        found = pyramid.project_any(*x, mu, 0.0, np.inf, facets, fit == "inner")
        assert np.allclose(found, cone.project(x), atol=1e-9)
        limit = max(-cone.rays[:, :2] @ x[:2])
        assert pyramid.shift_any(x[0], x[1], mu, facets, fit == "inner") == pytest.approx(limit, abs=1e-12)


def test_block_kernels() -> None:
    p = problem(2, 6)
    b = p.blocks
    full = np.zeros((18, 18))
    for k in range(6):
        for at in range(b.starts[k], b.starts[k + 1]):
            j = b.columns[at]
            full[3 * k : 3 * k + 3, 3 * j : 3 * j + 3] = b.values[at]
    assert np.array_equal(full, p.G)
    x = np.random.default_rng(0).normal(size=18)
    assert np.allclose(blocks.block_product(b.starts, b.columns, b.values, x), p.G @ x)
    u = np.empty(18)
    nsgs.refresh_dense(p.G, p.g, x, u)
    assert np.allclose(u, p.G @ x + p.g)
    crooked = p.G + np.triu(np.full((18, 18), 1e-3), 1)
    scale, gap, i, j = blocks.checked_mirror(crooked, 1e-8)
    assert (scale, gap) == pytest.approx(
        (np.abs(p.G + 1e-3 * np.triu(np.ones((18, 18)), 1)).max(), 1e-3), rel=1e-6
    )
    assert i != j
    assert np.array_equal(crooked, crooked.T)
    assert not np.isfinite(blocks.checked_mirror(np.array([[1.0, np.nan], [np.nan, 1.0]]), 1e-8)[0])


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
def test_sweeps_dense_and_blocks(law: str) -> None:
    """One sweep in NumPy: each contact solved with the others held, velocities recomputed from scratch."""
    p = problem(3, 6, law)
    convex, b = law == "convex", p.blocks
    local = nsgs.prepare_dense(p.G, p.scales)
    assert np.array_equal(local, nsgs.prepare_blocks(b.starts, b.columns, b.values, p.scales))
    twin = np.zeros(18)
    for _ in range(2):
        for k in range(6):
            i = slice(3 * k, 3 * k + 3)
            q = p.G[i] @ twin + p.g[i] - p.G[i, i] @ twin[i]
            block = tuple(local[k, :12].tolist())
            law = p.mu[k], p.normal_min[k], p.normal_max[k], convex
            twin[i] = nsgs.solve_one(block, *q, *law, *twin[i][:2], 0.0, 0.0)[:3]
    for form in ("dense", "blocks"):
        force, u = np.zeros(18), p.g.copy()
        for _ in range(2):
            if form == "dense":
                nsgs.sweep_dense(p.G, local, *laws(p), convex, 1.0, force, u)
            else:
                nsgs.sweep_blocks(b.starts, b.columns, b.values, local, *laws(p), convex, 1.0, force, u)
        assert np.allclose(force, twin, atol=1e-7), form
        assert np.allclose(u, p.G @ force + p.g, atol=1e-10), form


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
            local = nsgs.prepare_dense(p.G, p.scales)
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
    again = sf.contact.residuals(p, found.forces)
    assert found.residuals == again
    assert pickle.loads(pickle.dumps(sf.solve(p))).forces.tolist() == found.forces.tolist()
    assert "velocity_error" in repr(sf.solve(p))
    with pytest.raises(AttributeError, match="nothing"):
        found.nothing  # noqa: B018
    for name in ("problem", "forces", "velocities", "status", "residuals", "solver", "iterations"):
        with pytest.raises(AttributeError):
            setattr(found, name, None)


def test_sparse_newton_steps_are_the_dense_ones() -> None:
    p = problem(5, 8)
    local = nsgs.prepare_dense(p.G, p.scales)
    start = sf.solve(p, "nsgs", max_iterations=3).forces.ravel()
    dense, u = start.copy(), p.G @ start + p.g
    newton_step.newton_dense(p.G, p.g, *laws(p), False, 1e-10, 4, 0.1, local, dense, u)
    sparse = start.copy()
    newton_sparse.BlockNewton(p, 1e-10, np.inf).run(sparse, 4, 0.1)
    assert np.allclose(dense, sparse, atol=1e-9)


def test_admm_iterations() -> None:
    """Ten iterations in NumPy, with the linear system solved instead of inverted."""
    p = problem(6)
    rho, eta, n = 0.7, 1e-3, 12
    x, z, y = np.zeros(n), np.zeros(n), np.zeros(n)
    inverse = np.linalg.inv(p.G + (rho + eta) * np.eye(n))
    found = tuple(v.copy() for v in (x, z, y))
    packed = set_kernels.pack(p.contact_set, p.law, np.ones(4))
    admm.iterate(inverse, packed, p.g, rho, eta, *found, 10)
    for _ in range(10):
        shift = np.zeros(n)
        shift[2::3] = p.mu * np.hypot(y[0::3], y[1::3])
        x = np.linalg.solve(p.G + (rho + eta) * np.eye(n), rho * z - y + eta * x - p.g - shift)
        mixed = admm.RELAXATION * x + (1 - admm.RELAXATION) * z
        new = np.concatenate([
            pyramid.project_any(
                *(mixed + y / rho)[3 * k : 3 * k + 3], p.mu[k], p.normal_min[k], p.normal_max[k], 0, True
            )
            for k in range(4)
        ])  # fmt: skip
        y, z = y + rho * (mixed - new), new
    for a, b in zip(found, (x, z, y), strict=True):
        assert np.allclose(a, b, atol=1e-10)


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


def test_a_pivot_of_lemke() -> None:
    rng = np.random.default_rng(1)
    J = rng.normal(size=(5, 5))
    M, q = J @ J.T + np.eye(5), rng.normal(size=5)
    T = np.hstack([np.eye(5), -M, -np.ones((5, 1)), q[:, None]])
    pivoted, expected = T.copy(), T.copy()
    lemke._pivot(pivoted, 2, 7)
    expected[2] /= expected[2, 7]
    for i in (0, 1, 3, 4):
        expected[i] -= expected[i, 7] * expected[2]
    assert np.allclose(pivoted, expected)
