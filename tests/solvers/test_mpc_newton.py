"""The kernels of the MPC's Newton method, each against plain NumPy."""

import numpy as np
import pytest
from scipy.optimize import approx_fprime

from surefoot.cones.projection import project_truncated
from surefoot.solvers import mpc_newton as kernels

N, CONTACTS, RHO = 4, 7, 1e-2


def project(point, bound):
    return np.array(project_truncated(*point, *bound))


def jacobian(point, bound, size=1e-6):
    columns = [
        (project(point + size * e, bound) - project(point - size * e, bound)) / (2.0 * size)
        for e in np.eye(3)
    ]
    return np.stack(columns, axis=1)


@pytest.fixture
def program():
    return random_program(7)


def random_program(seed):
    """Return P, its inverse K, q, step, M, bounds, wanted forces and points of every kind."""
    rng = np.random.default_rng(seed)
    roots = rng.normal(size=(6, N, N))
    P = np.einsum("jab,jcb->jac", roots, roots) + 0.1 * np.eye(N)
    step = np.sort(rng.integers(0, N, CONTACTS))
    M = rng.normal(size=(CONTACTS, 3, 6))
    bounds = np.column_stack(
        [rng.uniform(0.2, 1.0, CONTACTS), np.full(CONTACTS, 0.3), np.full(CONTACTS, 2.0)]
    )
    bounds[1, 1], bounds[2, 2] = 0.0, np.inf
    centre = rng.normal(size=(CONTACTS, 3)) + np.array([0.0, 0.0, 1.0])
    point = np.array(
        [[0.1, 0.1, 1], [0.2, 0.1, -3], [2, 1, 1], [0.1, 0, 0.1], [0.1, 0, 5], [3, 1, 1.5], [0, -4, 9]], float
    )
    return P, np.linalg.inv(P), rng.normal(size=6 * N), step, M, bounds, centre, point


def wide(step, M):
    """Return the (6 N, 3 c) matrix of all contacts' accelerations, step by step."""
    out = np.zeros((6 * N, 3 * CONTACTS))
    for i, k in enumerate(step):
        out[6 * k : 6 * k + 6, 3 * i : 3 * i + 3] = M[i].T
    return out


def over_steps(K):
    """Return the (6 N, 6 N) matrix of per-axis matrices, step by step."""
    out = np.zeros((N, 6, N, 6))
    for j in range(6):
        out[:, j, :, j] = K[j]
    return out.reshape(6 * N, 6 * N)


def test_the_newton_matrix_is_the_gradients_jacobian(program):
    _, K, _, step, M, bounds, _, point = program
    force = np.array([project(p, b) for p, b in zip(point, bounds, strict=True)])
    V = np.empty((6 * N, 6 * N))
    kernels.assemble(V, K, step, M, bounds, point, force, RHO)
    D = np.zeros((3 * CONTACTS, 3 * CONTACTS))
    for i in range(CONTACTS):
        D[3 * i : 3 * i + 3, 3 * i : 3 * i + 3] = jacobian(point[i], bounds[i])
    wanted = over_steps(K) + wide(step, M) @ D @ wide(step, M).T / RHO
    assert np.allclose(np.triu(V), np.triu(wanted), rtol=1e-6, atol=1e-6)


def dual(y, program):
    """The dual function, in its plain words: minima over accelerations and over forces."""
    P, K, q, step, M, bounds, centre, _ = program
    a = over_steps(K) @ (y - q)
    value = 0.5 * a @ over_steps(P) @ a + q @ a - y @ a
    pull = (wide(step, M).T @ y).reshape(-1, 3)
    for i in range(CONTACTS):
        f = project(centre[i] - pull[i] / RHO, bounds[i])
        value += 0.5 * RHO * np.sum((f - centre[i]) ** 2) + pull[i] @ f
    return value


def primal(forces, program):
    P, _, q, step, M, _, centre, _ = program
    a = wide(step, M) @ forces.ravel()
    return 0.5 * a @ over_steps(P) @ a + q @ a + 0.5 * RHO * np.sum((forces - centre) ** 2)


def test_gradient_and_gap_are_those_of_the_dual(program):
    P, K, q, step, M, bounds, centre, _ = program
    y = np.random.default_rng(1).normal(size=6 * N)
    point, force, F = np.empty((CONTACTS, 3)), np.empty((CONTACTS, 3)), np.empty(6 * N)
    kernels.place(step, M, centre, y, RHO, point)
    size = kernels.evaluate(K, P, q, step, M, bounds, y, point, force, F)
    slope = approx_fprime(y, lambda v: -dual(v, program), 1e-6)  # the kernel minimises minus the dual
    assert np.allclose(F, slope, rtol=0, atol=1e-3 * np.abs(F).max())
    assert size / 2.0 == pytest.approx(primal(force, program) - dual(y, program), rel=1e-9)


def test_the_search_finds_the_lowest_point_of_a_step(program):
    P, K, q, step, M, bounds, centre, _ = program
    rng = np.random.default_rng(2)
    for _ in range(20):
        y, d = rng.normal(size=(2, 6 * N))
        point, force, F = np.empty((CONTACTS, 3)), np.empty((CONTACTS, 3)), np.empty(6 * N)
        kernels.place(step, M, centre, y, RHO, point)
        kernels.evaluate(K, P, q, step, M, bounds, y, point, force, F)
        d *= -np.sign(F @ d) * 3.0
        move = -(wide(step, M).T @ d).reshape(-1, 3) / RHO
        base, curve = (over_steps(K) @ (y - q)) @ d, d @ over_steps(K) @ d
        t = kernels.search(bounds, point, move, RHO, base, curve, F @ d)
        kernels.evaluate(K, P, q, step, M, bounds, y + t * d, point + t * move, force, G := np.empty(6 * N))
        assert abs(G @ d) <= 0.011 * abs(F @ d) or (t == 1.0 and G @ d <= 0.51 * abs(F @ d))


def solve(program, tol=1e-8, patience=30, limit=100, guess=None):
    P, K, q, step, M, bounds, centre, _ = program
    point = np.full((CONTACTS, 3), np.nan) if guess is None else guess.copy()
    force = np.empty((CONTACTS, 3))
    count, error = kernels.newton(K, P, q, step, M, bounds, centre, RHO, tol, patience, limit, point, force)
    return count, error, point, force


@pytest.mark.parametrize("patience", [0, 30])
@pytest.mark.parametrize("seed", range(12))
def test_the_answer_is_a_fixed_point_of_projected_gradients(seed, patience):
    """With patience, and by lowering the force weight in stages."""
    program = random_program(seed)
    P, _, q, step, M, bounds, centre, _ = program
    _, error, _, force = solve(program, patience=patience)
    assert error <= 1e-8
    A = wide(step, M)
    H = A.T @ over_steps(P) @ A + RHO * np.eye(3 * CONTACTS)
    slope = (H @ force.ravel() + A.T @ q - RHO * centre.ravel()).reshape(-1, 3)
    s = 1.0 / np.linalg.eigvalsh(H)[-1]
    again = np.array([project(f - s * v, b) for f, v, b in zip(force, slope, bounds, strict=True)])
    assert np.allclose(again, force, rtol=0, atol=1e-8)


def test_the_bound_on_the_error_holds_at_every_stop(program):
    best = solve(program)[3]
    for limit in range(12):
        _, error, _, force = solve(program, limit=limit, guess=np.full((CONTACTS, 3), 3.0))
        assert np.linalg.norm(force - best) <= error + 1e-8


def test_a_right_guess_needs_no_step(program):
    _, _, point, force = solve(program)
    count, _, _, again = solve(program, guess=point)
    assert count == 0
    assert np.allclose(again, force, rtol=0, atol=1e-8)
