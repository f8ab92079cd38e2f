"""The dual Newton method on a form of one number, whose optimum a bracketing root search knows."""

import numpy as np
import pytest
from scipy.optimize import brentq

from surefoot.kernels import kernel
from surefoot.solvers.dual_newton.method import Form, Path, Progress, Steps, descend, follow_path

# min ½ (a - b)² + Σ κ/2 (f_i - c_i)² subject to a = Σ B_i f_i, low_i <= f_i <= high_i; points in `work[0]`
STEPS = Steps(0.3, 0.25, 0.1)


@kernel
def _gradient(memory, y):
    B, sets, b, work = memory
    F = y - b
    for i in range(B.size):
        F += B[i] * min(max(work[0, i], sets[i, 0]), sets[i, 1])
    return F


@kernel
def _enter(memory, y, kappa):
    B, sets, _, work = memory
    for i in range(B.size):
        work[0, i] = sets[i, 2] + B[i] * y / kappa
    F = _gradient(memory, y)
    return F, F * F


@kernel
def _direction(memory, F, kappa):
    B, sets, _, work = memory
    H = 1.0
    for i in range(B.size):
        H += B[i] ** 2 / kappa if sets[i, 0] < work[0, i] < sets[i, 1] else 0.0
    d = -F / H
    for i in range(B.size):
        work[1, i], work[2, i] = work[0, i], B[i] * d / kappa
    return d, F * d


@kernel
def _take(memory, y, d, kappa, t, before):
    work = memory[3]
    for i in range(work.shape[1]):
        work[0, i] = work[1, i] + t * work[2, i]
    y += (t - before) * d
    F = _gradient(memory, y)
    return y, F, F * F, F * d


@kernel
def _line(memory, y, d):
    return (y - memory[2]) * d, d * d


@kernel
def _derivative(line, t):
    (B, sets, _, work), kappa, ahead, curve = line
    total = ahead + (t - 1.0) * curve
    for i in range(B.size):
        total += kappa * work[2, i] * min(max(work[1, i] + t * work[2, i], sets[i, 0]), sets[i, 1])
    return total


@kernel
def _rounding(memory, progress: Progress, tol):
    return False


@kernel
def _predict(memory, y, kappa, smaller):
    return y


FORM = Form(_enter, _direction, _take, _line, _derivative, _rounding, _predict)


@kernel
def _newton(memory, y, F, error, kappa, tol, limit, patience):
    return descend(FORM, STEPS, memory, y, F, error, kappa, tol, limit, patience)


@kernel
def run_newton(memory, kappa, tol, limit, patience):
    F, error = _enter(memory, 0.0, kappa)
    return _newton(memory, 0.0, F, error, kappa, tol, limit, patience)


@kernel
def run_path(memory, path, tol):
    return follow_path(FORM, _newton, memory, 0.0, path, tol)


def program(seed, n=6):
    rng = np.random.default_rng(seed)
    low = rng.normal(size=n)
    sets = np.column_stack([low, low + rng.uniform(0.1, 2.0, n), rng.normal(size=n)])
    return 3.0 * rng.normal(size=n), sets, 20.0 * rng.normal(), np.zeros((3, n))


def root(memory, kappa):
    B, sets, b, _ = memory

    def gradient(y):
        return y - b + B @ np.clip(sets[:, 2] + B * y / kappa, sets[:, 0], sets[:, 1])

    return brentq(gradient, -1e4, 1e4, xtol=1e-13), gradient


@pytest.mark.parametrize("kappa", [1.0, 1e-3, 1e-6])
@pytest.mark.parametrize("seed", range(10))
def test_newton_finds_the_root_and_the_points_are_those_of_it(seed, kappa):
    memory = program(seed)
    y, F, error, count = run_newton(memory, kappa, 1e-20, 200.0, -1.0)
    assert y == pytest.approx(root(memory, kappa)[0], abs=1e-9)
    assert error == F * F <= 1e-20
    assert 0 < count < 60
    np.testing.assert_allclose(memory[3][0], memory[1][:, 2] + memory[0] * y / kappa, rtol=1e-6, atol=1e-6)


def test_it_stops_where_told():
    memory = program(0)
    _, gradient = root(memory, 1e-6)
    for limit in range(4):
        y, F, _, count = run_newton(memory, 1e-6, 1e-20, float(limit), -1.0)
        assert count <= limit
        assert pytest.approx(gradient(y), abs=1e-6) == F
    # of the programs that need a search, a method without patience ends where the step began
    for seed in range(20):
        memory = program(seed)
        searched = run_newton(memory, 1e-6, 1e-20, 200.0, -1.0)
        y, F, _, count = run_newton(memory, 1e-6, 1e-20, 200.0, 1.0)
        assert count <= searched[3]
        assert pytest.approx(root(memory, 1e-6)[1](y), abs=1e-6) == F


@pytest.mark.parametrize("seed", range(10))
def test_the_path_ends_at_the_same_root(seed):
    memory = program(seed)
    path = Path(1e3, 1e-6, 0.05, 1e-6, 10.0, 300.0, 300.0)
    y, _, error, _ = run_path(memory, path, 1e-20)
    assert y == pytest.approx(root(memory, 1e-6)[0], abs=1e-9)
    assert error <= 1e-20
    assert run_path(memory, path._replace(limit=2.0), 1e-20)[3] <= 2
