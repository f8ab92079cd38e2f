"""The dual Newton method on scalars and on dense arrays, against plain NumPy twins and finite differences."""

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.kernels import kernel
from surefoot.base.numerics import six
from surefoot.base.numerics.projection import project_truncated
from surefoot.contact.solvers.dual_newton import dense, wrench_distribution
from surefoot.contact.solvers.dual_newton import distribution_memory as layout


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
    return np.concatenate([project_truncated(*p, *cone) for p, cone in zip(points, cones, strict=True)])


@kernel
def run_enter(work, contacts, y, b, kappa):
    return wrench_distribution._enter((work, contacts, b, 0.0), y, kappa)


@kernel
def run_assemble(work, contacts, kappa):
    return wrench_distribution._assemble(work, contacts, kappa)


@kernel
def run_derivative(work, contacts, b, kappa, y, d, t):
    memory = work, contacts, b, 0.0
    for k in range(contacts):
        for a in range(3):
            work[k, layout.OLD + a] = work[k, layout.POINT + a]
        layout.store_vector(work, k, layout.STEP, wrench_distribution._pull_back(work, k, d, 1.0 / kappa))
    ahead, curve = wrench_distribution._line(memory, six.mix(y, 1.0, d), d)
    found = wrench_distribution._derivative((memory, kappa, ahead, curve), t)
    return found, wrench_distribution._take(memory, y, d, kappa, t, 0.0)


def full(lower):
    H = np.zeros((6, 6))
    H[np.tril_indices(6)] = lower
    return H + np.tril(H, -1).T


@pytest.mark.parametrize("seed", range(20))
def test_gradient_is_that_of_the_dual(seed):
    """F is y + B f - b, and the derivative of the dual function by central differences."""
    B, c, b, cones, work = program(seed)
    rng = np.random.default_rng(seed)
    y, rho = rng.normal(size=6), rng.uniform(0.2, 1.0)
    F, square = run_enter(work, 5, tuple(y), tuple(b), 1.0 / rho)
    assert square == pytest.approx(np.dot(F, F))
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
    run_enter(work, 5, tuple(y), tuple(b), 1.0 / rho)
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


def test_derivative_along_a_step():
    """t of the way it is F there times the direction, and a step taken ends there."""
    B, c, b, cones, work = program(3)
    rng = np.random.default_rng(3)
    y, d, t, rho = rng.normal(size=6), rng.normal(size=6), 0.37, 0.6
    run_enter(work, 5, tuple(y), tuple(b), 1.0 / rho)
    found, (end, F, _, slope) = run_derivative(work, 5, tuple(b), 1.0 / rho, tuple(y), tuple(d), t)
    expected = y + t * d + B @ forces_twin(B, c, cones, y + t * d, rho) - b
    assert found == pytest.approx(expected @ d, abs=1e-10)
    assert slope == pytest.approx(expected @ d, abs=1e-10)
    np.testing.assert_allclose(F, expected, atol=1e-10)
    np.testing.assert_allclose(end, y + t * d, atol=1e-12)
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
    assert wrench_distribution.distribute_wrench(B, b, work, forces) == layout.SOLVED

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
        points[dense.CENTRE], duals[dense.TARGET] = c, b
        columns = np.ascontiguousarray(B.T)
        error, _, _ = dense.minimise(columns, sets, points, duals, H, False, 1e-20, 100.0)
        assert error <= 1e-20
        f = points[dense.VALUE]
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
    points[dense.CENTRE, :15] = c
    columns = np.ascontiguousarray(B9.T)

    memory = dense.DenseMemory(columns, sets, points, duals, H, 5, 0.0)

    def gradient(y):
        duals[dense.DUAL] = y
        duals[dense.TARGET, :6] = b
        F, square = dense._enter(memory, duals[dense.DUAL], 1.0)
        assert square == pytest.approx(F @ F)
        return F.copy()

    y = 0.3 * rng.normal(size=m)
    numeric = np.array([gradient(y + 1e-7 * e) - gradient(y - 1e-7 * e) for e in np.eye(m)]).T / 2e-7
    F = gradient(y)
    dense._assemble(memory, 1.0)
    np.testing.assert_allclose(np.tril(H), np.tril(numeric), rtol=1e-5, atol=1e-5)
    S = np.tril(H) + np.tril(H, -1).T
    d, start = dense._direction(memory, duals[dense.GRADIENT], 1.0)
    np.testing.assert_allclose(S @ d, -F, atol=1e-9)
    assert start == pytest.approx(F @ d)
    ahead, curve = dense._line(memory, y + d, d)
    for t in (0.0, 0.4, 1.0):
        found = dense._derivative((memory, 1.0, ahead, curve), t)
        assert found == pytest.approx(gradient(y + t * d) @ d, rel=1e-9, abs=1e-9)
        gradient(y)
        dense._direction(memory, duals[dense.GRADIENT], 1.0)


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


def test_what_doubles_cannot_tell_any_better_is_solved():
    """With no error allowed at all, forces inside their cones are those of the linear equations."""
    feet = np.array([[x, y, -0.3] for x in (0.2, -0.2) for y in (0.15, -0.15)])
    turns = np.cross(np.repeat(feet, 3, axis=0), np.tile(np.eye(3), (4, 1))).T
    A, r = np.vstack([np.tile(np.eye(3), 4), turns]), 1e-3
    distributor = sf.ForceDistributor(mu=0.6, normal_min=5.0, normal_max=250.0, force_weight=r, tol=0.0)
    rng = np.random.default_rng(0)
    for _ in range(5):
        w = rng.normal(size=6) * [5.0, 5.0, 20.0, 1.0, 1.0, 1.0] + [0.0, 0.0, 160.0, 0.0, 0.0, 0.0]
        expected = np.linalg.solve(A.T @ A + r * np.eye(12), A.T @ w).reshape(4, 3)
        assert expected[:, 2].min() > 5.0
        assert (np.linalg.norm(expected[:, :2], axis=1) < 0.6 * expected[:, 2]).all()
        np.testing.assert_allclose(distributor.solve(A, w), expected, atol=1e-9)
        assert distributor.status is sf.Status.SOLVED
