"""The compiled kernels of force distribution against plain NumPy twins and finite differences."""

import numpy as np
import pytest

from surefoot.cones.projection import project_truncated
from surefoot.kernels import kernel
from surefoot.solvers import distribution_newton as general
from surefoot.solvers import distribution_six as six
from surefoot.solvers import distribution_work as layout
from surefoot.solvers import distribution_wrench as wrench

LOWER = np.tril_indices(6)


def project_twin(point, mu, low, high):
    """The nearest point of a truncated friction cone, in NumPy."""
    t, z = np.hypot(point[0], point[1]), point[2]
    if t > mu * z:
        z = max((mu * t + z) / (1 + mu**2), 0.0)
    z = min(max(z, low), high)
    factor = min(1.0, mu * z / t) if t > 0 else 1.0
    return np.array([factor * point[0], factor * point[1], z])


def program(seed, n=5):
    """Return a scaled program in a work array: B (6, 3n), c (3n,), b (6,), cones (n, 3), work."""
    rng = np.random.default_rng(seed)
    B, c, b = rng.normal(size=(6, 3 * n)) * 3.0, rng.normal(size=3 * n), rng.normal(size=6) * 10.0
    cones = np.column_stack([rng.uniform(0, 1.5, n), rng.uniform(0, 1, n), rng.uniform(1, 4, n)])
    cones[0] = [0.5, 0.0, np.inf]
    cones[1, :2] = 0.0
    work = layout.new_work(n)
    work[:n, layout.MU], work[:n, layout.LOW], work[:n, layout.HIGH] = cones.T
    work[:n, layout.BLOCK : layout.BLOCK + 18] = B.T.reshape(n, 18)
    work[:n, layout.CENTRE : layout.CENTRE + 3] = c.reshape(n, 3)
    work[:n, layout.TANGENT : layout.NORMAL + 1] = 1.0
    return B, c, b, cones, work


def forces_twin(B, c, cones, y, rho=1.0):
    points = (c + rho * B.T @ y).reshape(-1, 3)
    return np.concatenate([project_twin(p, *cone) for p, cone in zip(points, cones, strict=True)])


@kernel
def run_place_and_evaluate(work, contacts, y, b, rho):
    wrench.place(work, contacts, y, rho)
    return wrench.evaluate(work, contacts, y, b)


@kernel
def run_assemble(work, contacts, kappa):
    return wrench.assemble(work, contacts, kappa)


@kernel
def run_slope(work, contacts, d, rho, t):
    wrench.aim(work, contacts, d, rho)
    wrench.move(work, contacts, t)
    return wrench.slope(work, contacts, t)


@kernel
def run_six(H, a, s):
    return six.solve_six(H, a), six.times(H, a), six.add_outer(H, a), six.mix(a, s, a), six.dot(a, a)


def full(lower):
    H = np.zeros((6, 6))
    H[LOWER] = lower
    return H + np.tril(H, -1).T


def test_six_dimensional_algebra():
    rng = np.random.default_rng(0)
    for _ in range(50):
        M = rng.normal(size=(6, 6)) * 10.0 ** rng.uniform(-3, 3, (6, 1))
        H, a, s = M @ M.T + 1e-3 * np.eye(6), rng.normal(size=6), rng.normal()
        x, product, outer, mixed, square = run_six(tuple(H[LOWER]), tuple(a), s)
        np.testing.assert_allclose(H @ x, -a, atol=1e-7 * np.linalg.cond(H) ** 0.5)
        np.testing.assert_allclose(product, H @ a, rtol=1e-9, atol=1e-9 * np.abs(H).max())
        np.testing.assert_allclose(full(outer), H + np.outer(a, a), rtol=1e-12)
        np.testing.assert_allclose(mixed, (1 + s) * a, rtol=1e-12)
        assert square == pytest.approx(a @ a)
    assert np.array_equal(full(six.scaled_identity(2.5)), 2.5 * np.eye(6))


@pytest.mark.parametrize("seed", range(20))
def test_gradient_is_that_of_the_dual(seed):
    """F is y + B f - b, and the derivative of the dual function by central differences."""
    B, c, b, cones, work = program(seed)
    rng = np.random.default_rng(seed)
    y, rho = rng.normal(size=6), rng.uniform(0.2, 1.0)
    F = run_place_and_evaluate(work, 5, tuple(y), tuple(b), rho)
    f = forces_twin(B, c, cones, y, rho)
    np.testing.assert_allclose(F, y + B @ f - b, atol=1e-11)
    np.testing.assert_allclose(work[:5, layout.FORCE : layout.FORCE + 3].ravel(), f, atol=1e-12)

    def dual(y):
        point = c + rho * B.T @ y
        near = forces_twin(B, c, cones, y, rho)
        return 0.5 * y @ y - b @ y + (0.5 * point @ point - 0.5 * np.sum((point - near) ** 2)) / rho

    h = 1e-6
    numeric = [(dual(y + h * e) - dual(y - h * e)) / (2 * h) for e in np.eye(6)]
    np.testing.assert_allclose(F, numeric, rtol=1e-6, atol=1e-5)


@pytest.mark.parametrize("seed", range(40))
def test_curvature_is_the_derivative_of_the_gradient(seed):
    B, c, b, cones, work = program(seed)
    rng = np.random.default_rng(100 + seed)
    y, rho = rng.normal(size=6), rng.uniform(0.2, 1.0)
    run_place_and_evaluate(work, 5, tuple(y), tuple(b), rho)
    H = rho * full(run_assemble(work, 5, 1.0 / rho))
    h = 1e-7
    numeric = np.array(
        [
            (y + h * e + B @ forces_twin(B, c, cones, y + h * e, rho))
            - (y - h * e + B @ forces_twin(B, c, cones, y - h * e, rho))
            for e in np.eye(6)
        ]
    ).T / (2 * h)
    np.testing.assert_allclose(H, numeric, rtol=1e-5, atol=1e-5)


def test_slope_along_a_step():
    B, c, b, cones, work = program(3)
    rng = np.random.default_rng(3)
    y, d, t, rho = rng.normal(size=6), rng.normal(size=6), 0.37, 0.6
    run_place_and_evaluate(work, 5, tuple(y), tuple(b), rho)
    found = run_slope(work, 5, tuple(d), rho, t)
    expected = forces_twin(B, c, cones, y + t * d, rho) @ (rho * B.T @ d)
    assert found == pytest.approx(expected, abs=1e-11)
    np.testing.assert_allclose(
        work[:5, layout.POINT : layout.POINT + 3].ravel(), c + rho * B.T @ (y + t * d), atol=1e-12
    )


@pytest.mark.parametrize("seed", range(20))
def test_newton_against_the_same_in_numpy(seed):
    """Plain Newton on the dual with NumPy's solver ends at the same forces."""
    B, c, b, cones, work = program(seed)
    work[5, layout.ROOT : layout.ROOT + 6] = 1.0
    work[:5, layout.PULL] = work[:5, layout.PULL + 1] = 1.0
    work[:5, layout.REFERENCE : layout.REFERENCE + 3] = c.reshape(5, 3)
    work[:5, layout.FLOOR], work[:5, layout.CEILING] = cones[:, 1], cones[:, 2]
    work[6, layout.TOLERANCE], work[6, layout.LIMIT] = 1e-11, 100
    forces = np.zeros((5, 3))
    assert wrench.distribute_wrench(B, b, work, forces) == layout.SOLVED

    def gradient(y):
        return y + B @ forces_twin(B, c, cones, y) - b

    y = np.zeros(6)
    for _ in range(200):
        F = gradient(y)
        J = np.array([gradient(y + 1e-7 * e) - gradient(y - 1e-7 * e) for e in np.eye(6)]).T / 2e-7
        d, t = -np.linalg.solve(J, F), 1.0
        while gradient(y + t * d) @ d > -0.1 * F @ d and t > 1e-4:
            t *= 0.5
        y = y + t * d
    assert np.linalg.norm(gradient(y)) < 1e-8
    np.testing.assert_allclose(forces.ravel(), forces_twin(B, c, cones, y), atol=1e-7)


def test_general_newton_matches_the_six_dimensional_one():
    for seed in range(20):
        B, c, b, cones, _ = program(seed)
        sets = np.zeros((5, 4))
        sets[:, :3] = cones
        points, duals, H = np.zeros((5, 15)), np.zeros((5, 6)), np.zeros((6, 6))
        points[general.CENTRE], duals[general.TARGET] = c, b
        columns = np.ascontiguousarray(B.T)
        error, _, _ = general.minimise(columns, sets, points, duals, H, False, 1e-20, 100.0)
        assert error <= 1e-20
        f = points[general.VALUE]
        y = b - B @ f
        np.testing.assert_allclose(f, forces_twin(B, c, cones, y), atol=1e-8)


def test_general_curvature_with_intervals():
    """H of the general kernel is the derivative of its gradient, intervals included."""
    rng = np.random.default_rng(1)
    B, c, b, cones, _ = program(1)
    m, rows = 9, 3
    B9 = np.vstack([B, rng.normal(size=(3, 15))])
    sets = np.zeros((5 + rows, 4))
    sets[:5, :3] = cones
    sets[5:, 1], sets[5:, 2], sets[5:, 3] = -0.5, 0.5, [1.5, 2.0, 0.7]
    points, duals, H = np.zeros((5, 15 + rows)), np.zeros((5, m)), np.zeros((m, m))
    points[general.CENTRE, :15] = c
    columns = np.ascontiguousarray(B9.T)

    def gradient(y):
        duals[general.DUAL] = y
        duals[general.TARGET, :6] = b
        general.pull_back(columns, sets, y, points[general.POINT], 1.0, 5)
        points[general.POINT] += points[general.CENTRE]
        square = general.gradient(columns, sets, points, duals, 5)
        F = duals[general.GRADIENT].copy()
        assert square == pytest.approx(F @ F)
        return F

    y = 0.3 * rng.normal(size=m)
    numeric = np.array([gradient(y + 1e-7 * e) - gradient(y - 1e-7 * e) for e in np.eye(m)]).T / 2e-7
    gradient(y)
    general.assemble(columns, sets, points, duals, H, 1.0, 5)
    np.testing.assert_allclose(np.tril(H), np.tril(numeric), rtol=1e-5, atol=1e-5)
    x = rng.normal(size=m)
    S = np.tril(H) + np.tril(H, -1).T
    solution = x.copy()
    general.solve_in_place(H, solution)
    np.testing.assert_allclose(S @ solution, x, atol=1e-9)


def test_projection_twin():
    @kernel
    def run(x, y, z, mu, low, high):
        return project_truncated(x, y, z, mu, low, high)

    rng = np.random.default_rng(0)
    for _ in range(300):
        p, mu, low = rng.normal(size=3) * 5.0, rng.uniform(0.0, 2.0), rng.uniform(0.0, 2.0)
        np.testing.assert_allclose(
            run(*p, mu, low, low + 3.0), project_twin(p, mu, low, low + 3.0), atol=1e-12
        )


@kernel
def run_memory(work, contacts, y):
    layout.remember(work, contacts, y)
    return layout.predict(work, contacts)


def test_a_steady_change_is_foretold_and_noise_is_not():
    """After y, y + d and y + 2 d the guess is y + 3 d; after a jump it is the last y again."""
    rng = np.random.default_rng(4)
    y, d = rng.normal(size=(2, 6))
    work = layout.new_work(2)
    for k in range(3):
        guess = run_memory(work, 2, tuple(y + k * d))
        np.testing.assert_allclose(guess, y + (k if k < 2 else 3) * d, atol=1e-14)
    jump = y + 2 * d - 3.0 * d
    np.testing.assert_allclose(run_memory(work, 2, tuple(jump)), jump)
    assert layout.set_limits(work, np.zeros(2), np.ones(2), np.ones(2, dtype=np.bool_)) == -1
    np.testing.assert_allclose(run_memory(work, 2, tuple(jump - 3.0 * d)), jump - 6.0 * d)
    layout.set_limits(work, np.zeros(2), np.ones(2), np.ones(2, dtype=np.bool_))
    assert work[3, layout.TREND] == 0.0


def test_sum_of_outer_products():
    @kernel
    def run(work, first, end):
        return wrench.sum_outer(six.scaled_identity(2.0), work, first, end, layout.BLOCK)

    work = np.random.default_rng(0).normal(size=(7, layout.WIDTH))
    V = work[2:6, layout.BLOCK : layout.BLOCK + 6]
    np.testing.assert_allclose(full(run(work, 2, 6)), 2.0 * np.eye(6) + V.T @ V, rtol=1e-12)
    assert np.array_equal(full(run(work, 3, 3)), 2.0 * np.eye(6))
