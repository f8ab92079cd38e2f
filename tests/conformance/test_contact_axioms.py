"""What must hold for any right solution of a contact problem, whoever solves it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import nnls
from scipy.spatial.transform import Rotation

import surefoot as sf
from benchmarks.problems.rigid_bodies import Scene
from surefoot.base.spatial import GRAVITY, skew
from tests.contact.solvers.convex_oracle import convex_forces

SOLVERS = ("auto", "nsgs", "admm")


def well_posed(seed: int, contacts: int = 4, mu: float | None = None) -> sf.ContactProblem:
    """A full-rank problem whose forces are unique in practice: moderate friction and coupling."""
    rng = np.random.default_rng(seed)
    J = rng.normal(size=(3 * contacts, 6 * contacts))
    G = J @ J.T / (6 * contacts) + 0.3 * np.eye(3 * contacts)
    g = rng.normal(size=(contacts, 3))
    g[:, 2] -= 0.7
    return sf.ContactProblem(G, g.ravel(), rng.uniform(0.1, 0.6, contacts) if mu is None else mu)


seeds = st.integers(0, 10_000)
few = settings(max_examples=15, deadline=None)


@few
@given(seed=seeds, factor=st.floats(1e-6, 1e6))
def test_forces_scale_with_the_free_velocity(seed: int, factor: float) -> None:
    problem = well_posed(seed)
    a = sf.solve(problem, tol=1e-11).raise_if_failed()
    b = sf.solve(problem.replace(g=factor * problem.g), tol=1e-11).raise_if_failed()
    assert np.allclose(factor * a.forces, b.forces, rtol=1e-7, atol=1e-8 * factor)


@few
@given(seed=seeds)
def test_the_order_of_contacts_does_not_matter(seed: int) -> None:
    problem = well_posed(seed, contacts=5)
    order = np.random.default_rng(seed).permutation(5)
    rows = (3 * order[:, None] + np.arange(3)).ravel()
    other = sf.ContactProblem(problem.G[np.ix_(rows, rows)], problem.g[rows], problem.mu[order])
    a, b = sf.solve(problem, tol=1e-11), sf.solve(other, tol=1e-11)
    assert np.allclose(a.raise_if_failed().forces[order], b.raise_if_failed().forces, atol=1e-7)


@few
@given(seed=seeds)
def test_turning_the_tangents_turns_the_forces(seed: int) -> None:
    problem = well_posed(seed)
    angles = np.random.default_rng(seed).uniform(0, 2 * np.pi, size=4)
    turns = Rotation.from_euler("z", angles[:, None]).as_matrix()
    T = np.zeros((12, 12))
    for k in range(4):
        T[3 * k : 3 * k + 3, 3 * k : 3 * k + 3] = turns[k]
    other = sf.ContactProblem(T @ problem.G @ T.T, T @ problem.g, problem.mu)
    a, b = sf.solve(problem, tol=1e-11), sf.solve(other, tol=1e-11)
    assert np.allclose(T @ a.raise_if_failed().forces.ravel(), b.raise_if_failed().forces.ravel(), atol=1e-7)


@pytest.mark.parametrize("name", SOLVERS)
@pytest.mark.parametrize("law", ["coulomb", "convex"])
def test_frictionless_is_the_quadratic_program(name: str, law: str) -> None:
    """min 1/2 fᵀNf + nᵀf over f >= 0, by SciPy's non-negative least squares on a Cholesky factor."""
    for seed in range(5):
        problem = well_posed(seed, mu=0.0).replace(law=law)
        N, n = problem.G[2::3, 2::3], problem.g[2::3]
        L = np.linalg.cholesky(N)
        expected = nnls(L.T, -np.linalg.solve(L, n))[0]
        found = sf.solve(problem, name, 1e-10).raise_if_failed()
        assert np.allclose(found.forces[:, 2], expected, atol=1e-8)
        assert np.abs(found.forces[:, :2]).max() < 1e-9


@pytest.mark.parametrize("name", ["auto", "nsgs", "newton", "admm"])
def test_the_convex_law_is_the_cone_program(name: str) -> None:
    pytest.importorskip("clarabel")
    for seed in range(5):
        problem = well_posed(seed).replace(law="convex")
        expected = convex_forces(problem, 1e-10)
        found = sf.solve(problem, name, 1e-10)
        if name != "newton":  # a local method: it may say that it stalled, and does
            found.raise_if_failed()
        elif not found.solved:
            continue
        ours, theirs = (
            0.5 * f @ problem.G @ f + problem.g @ f for f in (found.forces.ravel(), expected.ravel())
        )
        assert ours <= theirs + 1e-9
        solved = sf.residuals(problem, expected).worst <= 1e-10
        assert np.allclose(found.forces, expected, atol=1e-6 if solved else 1e-4)


def test_vanishing_friction_tends_to_none_and_huge_friction_sticks() -> None:
    for seed in range(5):
        base = well_posed(seed)
        none, little = (sf.solve(base.replace(mu=m), tol=1e-11).raise_if_failed() for m in (0.0, 1e-7))
        assert np.abs(none.forces - little.forces).max() < 1e-5
        rough = sf.solve(base.replace(mu=1e4), tol=1e-10).raise_if_failed()
        on = rough.forces[:, 2] > 1e-2  # a contact that slides has |f_t| = mu f_n: hardly any normal force
        assert np.abs(rough.velocities[on, :2]).max(initial=0.0) < 1e-6


@pytest.mark.parametrize("name", ["auto", "nsgs", "admm", "newton"])
def test_sliding_friction_opposes_the_velocity(name: str) -> None:
    sliding = 0
    for seed in range(10):
        found = sf.solve(well_posed(seed), name, 1e-10)
        if not found.solved:
            assert name == "newton"
            continue
        for f, u, mu in zip(found.forces, found.velocities, found.problem.mu, strict=True):
            speed, push = np.hypot(*u[:2]), np.hypot(*f[:2])
            if f[2] < 1e-3 or speed < 1e-3:
                continue
            sliding += 1
            assert push == pytest.approx(mu * f[2], rel=1e-6)
            assert np.linalg.norm(f[:2] / push + u[:2] / speed) < 1e-6
            assert abs(u[2]) < 1e-8
    assert sliding >= 5


def test_the_same_friction_on_finer_pyramids_tends_to_the_cone() -> None:
    problem = well_posed(1)
    exact = sf.solve(problem, tol=1e-10).raise_if_failed().forces
    gaps = []
    for facets in (4, 8, 16, 32):
        found = sf.solve(problem.polyhedral(facets)).raise_if_failed()
        gaps.append(np.linalg.norm(found.forces - exact))
    assert gaps[-1] < 0.1 * gaps[0]


@pytest.mark.parametrize("facets", [4, 8])
@pytest.mark.parametrize("fit", ["inner", "outer"])
def test_lemke_and_admm_agree_on_pyramids(facets: int, fit: str) -> None:
    for seed in range(5):
        problem = well_posed(seed).polyhedral(facets, fit)  # type: ignore[arg-type]
        a, b = (sf.solve(problem, name, 1e-10).raise_if_failed() for name in ("lemke", "admm"))
        assert np.allclose(a.velocities, b.velocities, atol=1e-7)


@pytest.mark.parametrize("law", ["coulomb", "convex"])
def test_a_cube_sliding_on_a_plane(law: str) -> None:
    """Coulomb: it never lifts off, energy never grows. Convex: it glides up, that law's known artefact."""
    size, mass, dt, mu = 0.2, 1.5, 5e-3, 0.4
    scene = Scene(time_step=dt)
    body = scene.box(np.array([0, 0, size / 2]), np.full(3, size), mass, np.array([2.0, 0.5, 0, 0, 0, 3.0]))
    for x in (-0.1, 0.1):
        for y in (-0.1, 0.1):
            scene.touch(body, -1, np.array([x, y, 0.0]), np.array([0, 0, 1.0]), mu)
    M = np.linalg.inv(scene.inverse_mass().toarray())
    twist, spin, height = scene.twists[0].copy(), 0.0, 0.0
    energy, lifted = np.inf, 0.0
    for _ in range(150):
        turn = Rotation.from_euler("z", spin).as_matrix()
        corners = [turn @ np.array([x, y, -size / 2]) for x in (-0.1, 0.1) for y in (-0.1, 0.1)]
        J = np.vstack([np.hstack([np.eye(3), -skew(c)]) for c in corners])
        free = twist + dt * np.array([0, 0, -GRAVITY, 0, 0, 0])
        g = J @ free
        g[2::3] += height / dt  # the gap that is left may be closed
        G = J @ np.linalg.solve(M, J.T)
        found = sf.solve(sf.ContactProblem(G, g, mu, law=law), tol=1e-9).raise_if_failed()  # type: ignore[arg-type]
        twist = free + np.linalg.solve(M, J.T @ found.forces.ravel())
        spin, height = spin + dt * twist[5], height + dt * twist[2]
        lifted = max(lifted, height)
        kinetic = 0.5 * twist @ M @ twist + mass * GRAVITY * height
        if law == "coulomb":
            assert kinetic <= energy + 1e-9
        energy = kinetic
    if law == "coulomb":
        assert lifted < 1e-8
        assert np.linalg.norm(twist) < 1e-6  # it has come to rest
    else:
        assert lifted > 1e-3
