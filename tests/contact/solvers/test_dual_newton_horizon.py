"""The dual Newton method over a horizon: each kernel against plain NumPy with matrices over all steps."""

import numpy as np
import pytest
from scipy.optimize import approx_fprime

from surefoot.base.kernels import kernel
from surefoot.base.numerics.line_search import search
from surefoot.base.numerics.projection import project_truncated
from surefoot.contact.solvers.dual_newton import horizon, riccati

N, CONTACTS, RHO, DT, TERMINAL = 4, 7, 1e-2, 0.3, 3.0


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


def cost_of(weights, steps, dt=DT):
    """Return the (6 steps, 6 steps) matrix of the integrators' cost, by simulating unit accelerations."""
    out, share = np.zeros((steps, 6, steps, 6)), np.append(np.ones(steps - 1), TERMINAL)
    place, rate = np.zeros((2, steps, steps))
    for i in range(steps):
        x = v = 0.0
        for k in range(steps):
            x, v = x + dt * v + 0.5 * dt * dt * (k == i), v + dt * (k == i)
            place[k, i], rate[k, i] = x, v
    for j in range(6):
        out[:, j, :, j] = place.T * share * weights[0, j] @ place + rate.T * share * weights[1, j] @ rate
    return out.reshape(6 * steps, 6 * steps)


def random_program(seed):
    """Return weights, P, q, step, M, bounds, wanted forces and points of every kind."""
    rng = np.random.default_rng(seed)
    weights = rng.uniform(0.1, 3.0, (2, 6))
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
    return weights, cost_of(weights, N), rng.normal(size=6 * N), step, M, bounds, centre, point


def memory_of(program, y):
    """Return the memory of the method with the points and the motion of multipliers y."""
    weights, P, q, step, M, bounds, centre, _ = program
    places, motions = np.empty((6, CONTACTS, 3)), np.zeros((6, N, 6))
    vectors, cost = motions.reshape(6, 6 * N), riccati.tracking(weights, TERMINAL, DT, N)
    places[horizon.CENTRE], places[horizon.BOUNDS] = centre, bounds
    vectors[horizon.SLOPE], vectors[horizon.MOTION] = q, np.linalg.solve(P, y - q)
    memory = horizon.HorizonMemory(cost, M, step, places, vectors, motions, np.empty((N, 6, 6)))
    run_pull_back(memory, y)
    return memory


@kernel
def run_pull_back(memory, y):
    horizon._pull_back(memory, y, RHO, horizon.CENTRE, horizon.POINT)


@kernel
def run_search(memory, d):
    """Return where the search along d ends; a step is tried in full first, as the method does."""
    places, a = memory.places, memory.vectors[horizon.MOTION]
    for i in range(places.shape[1]):
        for j in range(3):
            places[horizon.OLD, i, j] = places[horizon.POINT, i, j]
    horizon._pull_back(memory, d, RHO, -1, horizon.MOVE)
    _, _, _, at_0 = horizon._take(memory, a, d, RHO, 0.0, 0.0)
    _, _, _, at_1 = horizon._take(memory, a, d, RHO, 1.0, 0.0)
    ahead, curve = horizon._line(memory, a, d)
    t = search(horizon._derivative, (memory, RHO, ahead, curve), at_0, at_1, 0.01) if at_1 > 0.0 else 1.0
    _, _, _, slope = horizon._take(memory, a, d, RHO, t, 1.0)
    return t, at_0, at_1, slope


def wide(step, M):
    """Return the (6 N, 3 c) matrix of all contacts' accelerations, step by step."""
    out = np.zeros((6 * N, 3 * CONTACTS))
    for i, k in enumerate(step):
        out[6 * k : 6 * k + 6, 3 * i : 3 * i + 3] = M[i].T
    return out


def curvature(program, memory):
    """Return the blocks M Π' Mᵀ / ρ as one (6 N, 6 N) matrix, by differences of projections."""
    _, _, _, step, M, bounds, _, _ = program
    D = np.zeros((3 * CONTACTS, 3 * CONTACTS))
    for i in range(CONTACTS):
        D[3 * i : 3 * i + 3, 3 * i : 3 * i + 3] = jacobian(memory.places[horizon.POINT, i], bounds[i])
    return wide(step, M) @ D @ wide(step, M).T / RHO


def test_newtons_step_solves_with_the_gradients_jacobian(program):
    _, P, _, _, _, bounds, _, point = program
    force = np.array([project(p, b) for p, b in zip(point, bounds, strict=True)])
    memory = memory_of(program, np.zeros(6 * N))
    memory.places[horizon.POINT], memory.places[horizon.FORCE] = point, force
    F = np.random.default_rng(3).normal(size=6 * N)
    d, slope = horizon._direction(memory, F, RHO)
    V = np.linalg.inv(P) + curvature(program, memory)
    assert np.allclose(V @ d, -F, rtol=0, atol=1e-5)
    assert slope == pytest.approx(F @ d)
    assert np.allclose(P @ memory.vectors[horizon.CHANGE], d, rtol=0, atol=1e-10 * np.abs(d).max())


@pytest.mark.parametrize("steps", [1, 2, 7, 60])
@pytest.mark.parametrize("rank", [0, 1, 3, 5, 6, 9])
def test_the_recursion_solves_its_equations(steps, rank):
    """Blocks of any rank, among them those of one or two feet, which do not span all accelerations."""
    rng = np.random.default_rng([steps, rank])
    weights, roots = 10.0 ** rng.uniform(-1.0, 2.0, (2, 6)), 30.0 * rng.normal(size=(steps, 6, rank))
    blocks, P = roots @ roots.transpose(0, 2, 1), cost_of(weights, steps, 0.03)
    q, r = rng.normal(size=(2, steps, 6))
    cost, z, y = riccati.tracking(weights, TERMINAL, 0.03, steps), r.copy(), np.empty((steps, 6))
    riccati.solve(cost, blocks.copy(), q, z, y)
    rounding = 1e-14 * (np.abs(P) @ np.abs(z.ravel())).max()
    assert np.allclose(P @ z.ravel() + q.ravel(), y.ravel(), rtol=0, atol=rounding)
    assert np.allclose(z + np.einsum("kij,kj->ki", blocks, y), r, rtol=0, atol=1e-9)
    assert riccati.energy(cost, z) == pytest.approx(z.ravel() @ P @ z.ravel(), rel=1e-10)


def dual(y, program):
    """The dual function, in its plain words: minima over accelerations and over forces."""
    _, P, q, step, M, bounds, centre, _ = program
    a = np.linalg.solve(P, y - q)
    value = 0.5 * a @ P @ a + q @ a - y @ a
    pull = (wide(step, M).T @ y).reshape(-1, 3)
    for i in range(CONTACTS):
        f = project(centre[i] - pull[i] / RHO, bounds[i])
        value += 0.5 * RHO * np.sum((f - centre[i]) ** 2) + pull[i] @ f
    return value


def primal(forces, program):
    _, P, q, step, M, _, centre, _ = program
    a = wide(step, M) @ forces.ravel()
    return 0.5 * a @ P @ a + q @ a + 0.5 * RHO * np.sum((forces - centre) ** 2)


def test_gradient_and_gap_are_those_of_the_dual(program):
    y = np.random.default_rng(1).normal(size=6 * N)
    memory = memory_of(program, y)
    F, error = horizon._enter(memory, memory.vectors[horizon.MOTION], RHO)
    slope = approx_fprime(y, lambda v: -dual(v, program), 1e-6)  # the kernel minimises minus the dual
    assert np.allclose(F, slope, rtol=0, atol=1e-3 * np.abs(F).max())
    gap = primal(memory.places[horizon.FORCE], program) - dual(y, program)
    assert RHO * error / 2.0 == pytest.approx(gap, rel=1e-9)


def test_the_search_finds_the_lowest_point_of_a_step(program):
    rng = np.random.default_rng(2)
    searched = 0
    for _ in range(20):
        y, d = rng.normal(size=(2, 6 * N))
        memory = memory_of(program, y)
        d *= -np.sign(horizon._enter(memory, memory.vectors[horizon.MOTION], RHO)[0] @ d) * 3.0
        memory.vectors[horizon.CHANGE] = np.linalg.solve(program[1], d)
        t, at_0, at_1, slope = run_search(memory, d)
        numeric = (dual(y - 1e-6 * d, program) - dual(y + 1e-6 * d, program)) / 2e-6
        assert at_0 == pytest.approx(numeric, rel=1e-5)
        assert abs(slope) <= 0.011 * abs(at_0) or (t == 1.0 and at_1 <= 0.0)
        searched += t < 1.0
    assert searched > 5


def solve(program, tol=1e-8, patience=30, limit=100, guess=None):
    weights, _, q, step, M, bounds, centre, _ = program
    foot, points = np.arange(CONTACTS), np.full((N, CONTACTS, 3), np.nan)
    force = np.empty((CONTACTS, 3))
    if guess is not None:
        points[step, foot] = guess
    count, error = horizon.newton(
        riccati.tracking(weights, TERMINAL, DT, N), q.reshape(N, 6), step, foot, M, bounds, centre, RHO, tol,
        patience, limit, points, force,
    )  # fmt: skip
    return count, error, points[step, foot], force


@pytest.mark.parametrize("patience", [0, 30])
@pytest.mark.parametrize("seed", range(12))
def test_the_answer_is_a_fixed_point_of_projected_gradients(seed, patience):
    """With patience, and by lowering the force weight in stages."""
    program = random_program(seed)
    _, P, q, step, M, bounds, centre, _ = program
    _, error, _, force = solve(program, patience=patience)
    assert error <= 1e-8
    A = wide(step, M)
    H = A.T @ P @ A + RHO * np.eye(3 * CONTACTS)
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
