"""The kernels below the verdicts and regions against NumPy and SciPy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import block_diag, sqrtm
from scipy.optimize import linprog, minimize_scalar
from scipy.spatial import ConvexHull, HalfspaceIntersection

from surefoot.equilibrium import margin, polygons, scaling

LORENTZ, LINES = 2, 3
SIZE = 3 * LORENTZ + LINES


def interior(rng: np.random.Generator) -> np.ndarray:
    """Return a point inside two Lorentz cones and three half-lines."""
    x = rng.normal(size=SIZE)
    for i in range(0, 3 * LORENTZ, 3):
        x[i] = np.hypot(x[i + 1], x[i + 2]) + rng.uniform(0.1, 1.0)
    x[3 * LORENTZ :] = rng.uniform(0.1, 2.0, LINES)
    return x


def arrow(x: np.ndarray) -> np.ndarray:
    """Return the matrix of the Jordan product x o ."""
    blocks = [
        np.block([[x[i : i + 1, None], x[None, i + 1 : i + 3]], [x[i + 1 : i + 3, None], x[i] * np.eye(2)]])
        for i in range(0, 3 * LORENTZ, 3)
    ]
    return block_diag(*blocks, np.diag(x[3 * LORENTZ :]))


def quadratic(x: np.ndarray) -> np.ndarray:
    """Return the quadratic representation 2 L(x)² - L(x²)."""
    L = arrow(x)
    return 2.0 * L @ L - arrow(L @ x)


@pytest.mark.parametrize("seed", range(10))
def test_the_scaling_takes_both_points_to_the_same(seed: int) -> None:
    """W is symmetric with W z = W⁻¹ x, and W² = P(√x) P(P(√x) z)^(-½) P(√x)."""
    rng = np.random.default_rng(seed)
    x, z = interior(rng), interior(rng)
    v, eta = np.empty(SIZE), np.empty(LORENTZ)
    assert scaling.scale(x, z, LORENTZ, v, eta)
    W, inverse, out = np.empty((SIZE, SIZE)), np.empty((SIZE, SIZE)), np.empty(SIZE)
    for k in range(SIZE):
        for to, back in ((W, False), (inverse, True)):
            scaling.apply(v, eta, LORENTZ, back, np.eye(SIZE)[k], out)
            to[:, k] = out
    np.testing.assert_allclose(W, W.T, atol=1e-12)
    np.testing.assert_allclose(W @ inverse, np.eye(SIZE), atol=1e-11)
    np.testing.assert_allclose(W @ z, inverse @ x, rtol=1e-9, atol=1e-11)
    root = np.real(sqrtm(quadratic(x)))  # P(x)^½ = P(x^½)
    middle = np.real(sqrtm(np.linalg.inv(quadratic(root @ z))))
    np.testing.assert_allclose(root @ middle @ root, W @ W, rtol=1e-7, atol=1e-9)
    outside = x.copy()
    outside[0] = 0.0
    assert not scaling.scale(outside, z, LORENTZ, v, eta)
    assert not scaling.scale(x, -z, LORENTZ, v, eta)


@pytest.mark.parametrize("seed", range(10))
def test_the_corrector_solves_the_jordan_equation(seed: int) -> None:
    rng = np.random.default_rng(seed)
    lam, dx, dz = interior(rng), *rng.normal(size=(2, SIZE))
    unit = np.concatenate([np.tile([1.0, 0.0, 0.0], LORENTZ), np.ones(LINES)])
    out = np.empty(SIZE)
    scaling.corrector_target(lam, dx, dz, 0.7, LORENTZ, out)
    np.testing.assert_allclose(arrow(lam) @ out, 0.7 * unit - arrow(lam) @ lam - arrow(dx) @ dz, atol=1e-10)


def heights(x: np.ndarray) -> np.ndarray:
    """Return how deep x is in each cone, along its axis; negative outside."""
    cones = x[: 3 * LORENTZ].reshape(-1, 3)
    return np.concatenate([cones[:, 0] - np.hypot(cones[:, 1], cones[:, 2]), x[3 * LORENTZ :]])


@pytest.mark.parametrize("seed", range(10))
def test_steps_end_at_the_boundary_and_depth_is_the_way_to_it(seed: int) -> None:
    rng = np.random.default_rng(seed)
    x, d, e = interior(rng), rng.normal(size=SIZE), np.zeros(SIZE)
    step = scaling.step_to_boundary(x, d, LORENTZ)
    along = np.linspace(0.0, 1.0, 1000)
    if step < np.inf:
        assert heights(x + step * d).min() == pytest.approx(0.0, abs=1e-9)
        assert min(heights(x + t * step * d).min() for t in along) >= -1e-9
    else:
        assert min(heights(x + 1e3 * t * d).min() for t in along) >= 0.0
    e[[0, 3, 6, 7, 8]] = rng.uniform(0.5, 2.0, 5)
    for point in (x, d):
        t = margin.depth(point, e, LORENTZ)
        assert t == pytest.approx((heights(point) / e[e > 0.0]).min())
        assert heights(point - t * e).min() == pytest.approx(0.0, abs=1e-12)


def test_scales_of_a_stance() -> None:
    rng = np.random.default_rng(0)
    positions, about, load = rng.normal(size=(5, 3)), rng.normal(size=3), rng.normal(size=6)
    arms = np.linalg.norm(positions - about, axis=1)
    assert margin.spread(positions, about) == pytest.approx(np.sqrt(np.mean(arms**2)))
    assert margin.spread(about[None], about) == margin.spread(np.zeros((0, 3)), about) == 1.0
    assert margin.load_scale(load, 0.4) == pytest.approx(np.linalg.norm(load / np.repeat([1.0, 0.4], 3)))
    assert margin.load_scale(np.zeros(6), 0.4) == 1.0
    for mu in (0.1, 0.7, 3.0):  # the distance from (0, 0, s) to the cone's boundary is one
        s = margin.axis_scale(mu)
        near = minimize_scalar(
            lambda r, mu=mu, s=s: np.hypot(r, s - r / mu), bounds=(0.0, 100.0), method="bounded"
        )
        assert near.fun == pytest.approx(1.0, rel=1e-6)
    assert margin.axis_scale(0.0) == 1.0


@pytest.mark.parametrize("seed", range(20))
def test_the_reach_of_a_proof_is_a_lower_bound_that_a_linear_program_confirms(seed: int) -> None:
    """For half-lines alone: the least sum of x >= 0 with A x = w is a linear program."""
    rng = np.random.default_rng(seed)
    A, w = rng.normal(size=(3, 8)), rng.normal(size=3)
    y = -w + 0.5 * rng.normal(size=3)
    reach = margin.proof_reach(A, w, y, 0)
    work, lack = y @ w, -(A.T @ y).min()
    if work >= 0.0:
        assert reach == 0.0
    else:
        assert reach == pytest.approx(-work / lack if lack > 0.0 else np.inf, rel=1e-9)
        least = linprog(np.ones(8), A_eq=A, b_eq=w)
        assert not least.success or least.fun >= reach * (1.0 - 1e-9)


def random_planes(rng: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return directions and heights of half-planes that bound a region, and a point in it."""
    angles = np.sort(rng.uniform(0.0, 2.0 * np.pi, count)) + np.linspace(0.0, 0.1, count)
    angles[:4] = np.arange(4) * np.pi / 2.0
    directions = np.column_stack([np.cos(angles), np.sin(angles)])
    middle = rng.normal(size=2)
    return directions, directions @ middle + rng.uniform(0.2, 1.0, count), middle


@pytest.mark.parametrize("seed", range(10))
def test_half_planes_meet_where_qhull_says(seed: int) -> None:
    directions, heights, middle = random_planes(np.random.default_rng(seed), 12)
    corners = polygons.intersection(directions, heights, middle, 50.0)
    expected = HalfspaceIntersection(np.column_stack([directions, -heights]), middle).intersections
    expected = expected[ConvexHull(expected).vertices]
    assert len(corners) == len(expected)
    apart = np.linalg.norm(corners[:, None] - expected[None], axis=2)
    assert max(apart.min(axis=0).max(), apart.min(axis=1).max()) < 1e-9


@pytest.mark.parametrize("seed", range(10))
def test_the_hull_is_qhulls_and_the_gap_that_of_the_outer_corners(seed: int) -> None:
    rng = np.random.default_rng(seed)
    directions, heights, middle = random_planes(rng, 10)
    points = middle + 0.1 * rng.normal(size=(30, 2))
    corners = polygons.hull(points)
    expected = points[ConvexHull(points).vertices]
    assert sorted(map(tuple, corners.tolist())) == sorted(map(tuple, expected.tolist()))
    raised = heights.copy()
    inner, gap = polygons.enclose(points, directions, raised, 0.0, 1e-3)
    assert (directions @ points.T <= raised[:, None]).all()
    np.testing.assert_allclose(raised, np.maximum(heights, (directions @ points.T).max(axis=1)), atol=1e-9)
    outer = HalfspaceIntersection(np.column_stack([directions, -raised]), middle).intersections
    ends = np.roll(inner, -1, axis=0)
    worst = 0.0
    for p in outer:
        share = np.clip(((p - inner) * (ends - inner)).sum(1) / ((ends - inner) ** 2).sum(1), 0.0, 1.0)
        worst = max(worst, np.linalg.norm(p - inner - share[:, None] * (ends - inner), axis=1).min())
    assert gap == pytest.approx(worst, rel=1e-6)
