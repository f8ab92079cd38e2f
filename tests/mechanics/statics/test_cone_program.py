"""The compiled solver against Clarabel, and against itself without compilation."""

import numpy as np
import pytest

from surefoot.contact.solvers.backends import ConeProgram, End, solve_program
from surefoot.mechanics.statics.cone_program import OPTIMAL, UNBOUNDED, minimise
from surefoot.mechanics.statics.row_blocks import IN_ONE


def random_program(rng, lorentz, lines, rows):
    """Return orthonormal rows, right-hand side, a bounded objective and a strictly feasible start."""
    m = 3 * lorentz + lines
    B = np.linalg.qr(rng.normal(size=(m, rows)))[0].T
    x = interior(rng, lorentz, lines)
    dual = interior(rng, lorentz, lines)
    c = dual + B.T @ rng.normal(size=rows)
    return np.ascontiguousarray(B), B @ x, c, x


def interior(rng, lorentz, lines):
    x = rng.normal(size=3 * lorentz + lines)
    for k in range(lorentz):
        x[3 * k] = np.hypot(x[3 * k + 1], x[3 * k + 2]) + rng.uniform(0.1, 1.0)
    x[3 * lorentz :] = np.abs(x[3 * lorentz :]) + 0.1
    return x


def clarabel_value(B, b, c, lorentz):
    pytest.importorskip("clarabel")
    m, split = len(c), 3 * lorentz
    minus, zeros = -np.eye(m), np.zeros(m)
    lines, cones = (minus[split:], zeros[split:]), (minus[:split], zeros[:split])
    program = ConeProgram.of(None, c, zero=(B, b), nonneg=lines, second_order=cones)
    found = solve_program(program, tol=None)
    assert found.end is End.SOLVED
    return float(c @ found.x)


def solve(B, b, c, lorentz, start, kernel=minimise):
    x, y, z = start.copy(), np.empty(len(b)), np.empty(len(c))
    status, iterations = kernel(B, b, c, lorentz, x, y, z, 1e-10, -1e9, 0.0, IN_ONE, np.empty(0))
    return status, iterations, x, y, z


@pytest.mark.parametrize(
    ("lorentz", "lines", "rows"), [(4, 0, 5), (4, 0, 4), (0, 32, 5), (8, 10, 12), (1, 2, 1)]
)
def test_value_equals_clarabels_and_the_gap_closes(lorentz, lines, rows):
    rng = np.random.default_rng(0)
    for _ in range(40):
        B, b, c, start = random_program(rng, lorentz, lines, rows)
        status, iterations, x, y, z = solve(B, b, c, lorentz, start)
        assert status == OPTIMAL
        assert iterations <= 25
        np.testing.assert_allclose(B @ x, b, atol=1e-9)
        np.testing.assert_allclose(c - B.T @ y, z, atol=1e-9)
        for v in (x, z):
            heads = v[: 3 * lorentz].reshape(-1, 3)
            assert np.all(heads[:, 0] >= np.hypot(heads[:, 1], heads[:, 2]))
            assert np.all(v[3 * lorentz :] >= 0.0)
        assert abs(c @ x - b @ y) < 1e-8
        assert c @ x == pytest.approx(clarabel_value(B, b, c, lorentz), abs=1e-6)


def test_unbounded_programs_are_recognised():
    B, b = np.array([[0.0, 1.0, 0.0, 0.0]]), np.zeros(1)
    c = np.array([0.0, 0.0, 0.0, -1.0])
    assert solve(B, b, c, 1, np.array([1.0, 0.0, 0.0, 1.0]))[0] == UNBOUNDED
