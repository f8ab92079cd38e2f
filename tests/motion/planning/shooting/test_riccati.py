"""The backward pass against a dense KKT solve, and its box programs against an outside solver."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
import scipy.optimize

from surefoot.motion.planning.shooting.riccati import backward_pass, solve_box


class Quadratic(NamedTuple):
    """A linear-quadratic problem with gaps, of n positions and m inputs."""

    dynamics: tuple[np.ndarray, ...]
    costs: tuple[np.ndarray, ...]
    N: int
    n: int
    m: int


def quadratic(seed: int, N: int = 6, n: int = 8, m: int = 3) -> Quadratic:
    rng = np.random.default_rng(seed)
    A, B = 0.4 * rng.normal(size=(N, 2 * n, 2 * n)), rng.normal(size=(N, 2 * n, m))
    lxx = np.array([definite(rng, 2 * n) for _ in range(N + 1)])
    luu = np.array([definite(rng, m) for _ in range(N)])
    gaps = 0.3 * rng.normal(size=(N, 2 * n))
    lx, lu = rng.normal(size=(N + 1, 2 * n)), rng.normal(size=(N, m))
    return Quadratic((A, B, gaps), (lx, lxx, lu, luu), N, n, m)


def definite(rng: np.random.Generator, size: int) -> np.ndarray:
    X = rng.normal(size=(size, size))
    return np.asarray(X @ X.T / size + 0.1 * np.eye(size))


def run(
    given: Quadratic, low: float = -np.inf, high: float = np.inf, damping: float = 0.0
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    N, n, m = given.N, given.n, given.m
    gains, steps, slopes = np.zeros((N, m, 2 * n)), np.zeros((N, m)), np.zeros((N + 1, 2 * n))
    predicted = np.zeros(2)
    box = np.full((N, m), low), np.full((N, m), high)
    assert backward_pass(given.dynamics, given.costs, box, damping, gains, steps, slopes, predicted)
    return gains, steps, slopes, predicted


def forward(given: Quadratic, gains: np.ndarray, steps: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    """March the linear system under the policy; return dx, du and the cost's change."""
    A, B, gaps = given.dynamics
    lx, lxx, lu, luu = given.costs
    dx, du = np.zeros((given.N + 1, 2 * given.n)), np.zeros((given.N, given.m))
    for k in range(given.N):
        du[k] = steps[k] + gains[k] @ dx[k]
        dx[k + 1] = A[k] @ dx[k] + B[k] @ du[k] + gaps[k]
    total = sum(lx[k] @ dx[k] + 0.5 * dx[k] @ lxx[k] @ dx[k] for k in range(given.N + 1))
    total += sum(lu[k] @ du[k] + 0.5 * du[k] @ luu[k] @ du[k] for k in range(given.N))
    return dx, du, float(total)


@pytest.mark.parametrize(("seed", "n", "damping"), [(0, 8, 0.0), (2, 3, 0.3)])
def test_the_policy_is_the_solution_of_the_kkt_system(seed: int, n: int, damping: float) -> None:
    given = quadratic(seed, n=n)
    gains, steps, slopes, _ = run(given, damping=damping)
    dx, du, _ = forward(given, gains, steps)
    A, B, gaps = given.dynamics
    lx, lxx, lu, luu = given.costs
    luu = luu + damping * np.eye(given.m)
    N, w, m = given.N, 2 * n, given.m
    size = N * (w + m)  # unknowns (du_0, dx_1, du_1, ..., dx_N), then the multipliers
    H, g, C, d = np.zeros((size, size)), np.zeros(size), np.zeros((N * w, size)), np.zeros(N * w)
    for k in range(N):
        u, x, rows = k * (w + m), k * (w + m) + m, slice(k * w, (k + 1) * w)
        H[u : u + m, u : u + m], g[u : u + m] = luu[k], lu[k]
        H[x : x + w, x : x + w], g[x : x + w] = lxx[k + 1], lx[k + 1]
        C[rows, u : u + m], C[rows, x : x + w], d[rows] = B[k], -np.eye(w), -gaps[k]
        if k:
            C[rows, u - w : u] = A[k]
    kkt = np.block([[H, C.T], [C, np.zeros((N * w, N * w))]])
    solution = np.linalg.solve(kkt, np.concatenate([-g, d]))
    z, multipliers = solution[:size].reshape(N, m + w), solution[size:].reshape(N, w)
    np.testing.assert_allclose(du, z[:, :m], atol=1e-9)
    np.testing.assert_allclose(dx[1:], z[:, m:], atol=1e-9)
    np.testing.assert_allclose(slopes[0], lx[0] + A[0].T @ multipliers[0], atol=1e-9)


def test_without_gaps_the_prediction_is_the_change_of_the_cost() -> None:
    given = quadratic(7)
    given.dynamics[2][:] = 0.0
    gains, steps, _, predicted = run(given)
    for share in (1.0, 0.3):
        _, _, change = forward(given, gains, share * steps)
        assert change == pytest.approx(share * predicted[0] + 0.5 * share**2 * predicted[1], rel=1e-9)


def test_bounded_inputs_stay_within_and_their_gains_are_zero() -> None:
    given = quadratic(9)
    gains, steps, _, _ = run(given, low=-0.2, high=0.1)
    at = (steps <= -0.2) | (steps >= 0.1)
    assert at.any()
    assert not at.all()
    assert (steps >= -0.2).all()
    assert (steps <= 0.1).all()
    assert (gains[at] == 0.0).all()
    assert (np.abs(gains[~at]).max(axis=1) > 0.0).all()


@pytest.mark.parametrize("m", [1, 3, 12])
def test_box_programs_against_scipy(m: int) -> None:
    rng = np.random.default_rng(m)
    for trial in range(30):
        H, g = definite(rng, m), 3.0 * rng.normal(size=m)
        low, high = -rng.uniform(0.0, 1.0, m), rng.uniform(0.0, 1.0, m)
        if trial % 5 == 0:
            low[0] = high[0] = 0.0
        x = rng.normal(size=m)
        solved, inside, L = solve_box(H, g, low, high, x)
        assert solved
        root = np.linalg.cholesky(H).T
        want = scipy.optimize.lsq_linear(
            root, -np.linalg.solve(root.T, g), (low - 1e-15, high + 1e-15), method="bvls", tol=1e-14
        ).x
        np.testing.assert_allclose(x, want, atol=1e-8)
        assert ((x[inside] >= low[inside]) & (x[inside] <= high[inside])).all()
        np.testing.assert_allclose(np.tril(L) @ np.tril(L).T, H[np.ix_(inside, inside)], atol=1e-12)


def test_a_hessian_that_is_not_definite_is_refused() -> None:
    m = 3
    H = np.diag([1.0, -1.0, 1.0])
    assert not solve_box(H, np.ones(m), np.full(m, -9.0), np.full(m, 9.0), np.zeros(m))[0]
    given = quadratic(2)
    given.costs[3][-1] = -1e3 * np.eye(given.m)
    out = np.zeros((given.N, given.m, 2 * given.n)), np.zeros((given.N, given.m))
    box = np.full(out[1].shape, -1.0), np.full(out[1].shape, 1.0)
    slopes = np.zeros((given.N + 1, 2 * given.n))
    assert not backward_pass(given.dynamics, given.costs, box, 0.0, *out, slopes, np.zeros(2))
