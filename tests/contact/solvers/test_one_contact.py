"""The local solver against a twin that knows nothing of angles: projected fixed-point iteration in NumPy."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import surefoot as sf
from surefoot.contact.solvers import one_contact


def prepared(W: np.ndarray) -> np.ndarray:
    out = np.ones((2, one_contact.WIDTH))
    one_contact.prepare(W[0, 0], W[0, 1], W[0, 2], W[1, 1], W[1, 2], W[2, 2], out, 1)
    assert (out[0] == 1.0).all()
    return out[1]


def block(rng: np.random.Generator, spread: float = 1.0) -> np.ndarray:
    J = rng.normal(size=(3, 6)) * 10 ** rng.uniform(-spread, 0, size=(3, 1))
    return J @ J.T


def coupled(W: np.ndarray, share: float) -> np.ndarray:
    """Return a block whose normal and tangents couple by less: little enough, and the law has one answer."""
    W[2, :2] *= share
    W[:2, 2] *= share
    return W


def local(
    W: np.ndarray, q: np.ndarray, mu: float, low: float, high: float, convex: bool, guess=(0.0, 0.0)
) -> np.ndarray:
    """Solve until the warm start stands still: the kernel leaves the last digits to the next sweep."""
    force = np.array([*guess, 0.0])
    for _ in range(3):
        force = np.array(solve_from(prepared(W), q, mu, low, high, convex, force[0], force[1], 0.0, 0.0)[:3])
    return force


def solve_from(W: np.ndarray, q: np.ndarray, *arguments: float) -> tuple[float, ...]:
    return one_contact.solve_one(tuple(W[:12].tolist()), *q.tolist(), *arguments)  # type: ignore[arg-type]


def test_prepare_inverts_the_block() -> None:
    rng = np.random.default_rng(0)
    for _ in range(20):
        W = block(rng)
        out = prepared(W)
        a, b, c, d, e, f = out[6:12]
        inverse = np.array([[a, b, c], [b, d, e], [c, e, f]])
        assert np.allclose(inverse @ W, np.eye(3), atol=1e-6)
    singular = prepared(np.outer([1.0, 2.0, 3.0], [1.0, 2.0, 3.0]))
    assert np.isfinite(singular).all()
    assert (prepared(np.zeros((3, 3)))[[0, 3, 5]] > 0).all()


@settings(max_examples=200, deadline=None)
@given(
    seed=st.integers(0, 100_000), mu=st.floats(0.0, 1.5), convex=st.booleans(),
    bound=st.sampled_from([(0.0, np.inf), (0.0, 0.3), (0.2, 2.0)]),
)  # fmt: skip
def test_solution_obeys_the_laws(seed: int, mu: float, convex: bool, bound: tuple[float, float]) -> None:
    rng = np.random.default_rng(seed)
    W, q = coupled(block(rng), 1.0 if convex else 0.3), rng.normal(size=3)
    force = local(W, q, mu, *bound, convex)
    problem = sf.ContactProblem(W, q, mu, *bound, "convex" if convex else "coulomb")
    assert sf.residuals(problem, force[None]).velocity_error < 1e-8


@pytest.mark.parametrize("convex", [False, True])
@pytest.mark.long
def test_matches_a_projected_fixed_point(convex: bool) -> None:
    """r <- P(r - rho (u + shift)) with a small rho: slow, simple, and the definition of a solution."""
    rng = np.random.default_rng(3)
    for _ in range(20):
        W = coupled(block(rng, 0.5) + 0.2 * np.eye(3), 0.3)
        q, mu = rng.normal(size=3), rng.uniform(0.1, 0.8)
        cone, twin, rho = sf.FrictionCone(mu), np.zeros(3), 0.5 / np.linalg.norm(W, 2)
        for _ in range(4000):
            u = W @ twin + q
            shift = 0.0 if convex else mu * np.hypot(u[0], u[1])
            twin = cone.project(twin - rho * (u + np.array([0.0, 0.0, shift])))
        assert local(W, q, mu, 0.0, np.inf, convex) == pytest.approx(twin, abs=1e-7)


def test_any_guess_leads_to_the_same_force() -> None:
    rng = np.random.default_rng(5)
    for _ in range(50):
        W, q = coupled(block(rng, 1.5), 0.2), rng.normal(size=3) - [0, 0, 1.0]
        first = local(W, q, 0.5, 0.0, np.inf, False)
        for guess in ((1.0, 0.0), (-1.0, 0.2), (0.0, -3.0)):
            assert local(W, q, 0.5, 0.0, np.inf, False, guess) == pytest.approx(first, abs=1e-7)


def test_the_circle_search_finds_what_newton_finds() -> None:
    rng = np.random.default_rng(6)
    found = 0
    for _ in range(60):
        W, q = coupled(block(rng, 0.5), 0.2), rng.normal(size=3) - [0, 0, 1.0]
        force = local(W, q, 0.4, 0.0, np.inf, False)
        push = np.hypot(*force[:2])
        if push < 0.999 * 0.4 * force[2] or push == 0.0:
            continue
        good, x, y = one_contact._search_circle(prepared(W), *q, 0.4, False)
        assert good
        assert np.array([x, y]) == pytest.approx(force[:2] / push, abs=1e-6)
        found += 1
    assert found > 10


def test_bilateral_contacts_solve_the_linear_system() -> None:
    W, q = block(np.random.default_rng(7), 0.3), np.array([1.0, -2.0, 3.0])
    assert local(W, q, 0.5, -np.inf, np.inf, False) == pytest.approx(-np.linalg.solve(W, q), rel=1e-6)
