"""The compiled pieces of the row handling against plain NumPy."""

import numpy as np
import pytest

from surefoot.solvers.dual_newton import dense as newton
from surefoot.solvers.dual_newton import rows as rows_of
from surefoot.solvers.dual_newton import work as layout


def loaded(seed, n=4, count=5):
    """Return a random program with rows: T (count, 3n), limits, and its work arrays, loaded."""
    rng = np.random.default_rng(seed)
    T = rng.normal(size=(count, 3 * n))
    low, high = -rng.uniform(0.5, 2.0, count), rng.uniform(0.5, 2.0, count)
    work = layout.new_work(n)
    unit_t, unit_n = rng.uniform(0.5, 3.0, (2, n))
    work[:n, layout.TANGENT], work[:n, layout.NORMAL] = unit_t, unit_n
    work[:n, layout.MU] = rng.uniform(0.1, 1.0, n) * unit_n / unit_t
    work[:n, layout.LOW], work[:n, layout.HIGH] = 0.5, 4.0
    work[:n, layout.BLOCK : layout.BLOCK + 18] = rng.normal(size=(n, 18))
    work[:n, layout.CENTRE : layout.CENTRE + 3] = rng.normal(size=(n, 3))
    work[n, layout.ROOT : layout.ROOT + 6] = rng.uniform(0.5, 2.0, 6)
    arrays = rows_of.rows_work(n, count)
    w = rng.normal(size=6)
    rows_of._load_rows(w, np.ascontiguousarray(T.T), low, high, work, arrays[:5], arrays[5], 0.0)
    units = np.column_stack([unit_t, unit_t, unit_n]).ravel()
    return T, low, high, units, w, work, arrays


@pytest.mark.parametrize("seed", range(5))
def test_loaded_program(seed):
    T, low, high, units, w, work, (columns, sets, points, duals, _, rows) = loaded(seed)
    B = work[:4, layout.BLOCK : layout.BLOCK + 18].reshape(12, 6)
    heavy, light = rows[:, rows_of.HEAVY], rows[:, rows_of.LIGHT]
    np.testing.assert_allclose(columns[:, :6], B)
    np.testing.assert_allclose(columns[:, 6:], (heavy[:, None] * T * units).T)
    np.testing.assert_allclose(sets[4:, newton.LOW] / light, low)
    np.testing.assert_allclose(sets[4:, newton.HIGH] / light, high)
    np.testing.assert_allclose(sets[4:, newton.LINK], heavy / light)
    np.testing.assert_allclose(duals[newton.TARGET, :6], w * work[4, layout.ROOT : layout.ROOT + 6])
    np.testing.assert_allclose(
        points[newton.CENTRE, :12], work[:4, layout.CENTRE : layout.CENTRE + 3].ravel()
    )


def test_stiffer_rows_are_the_same_program():
    *_, (columns, sets, points, duals, H, rows) = loaded(1)
    rng = np.random.default_rng(1)
    f, q = rng.normal(size=12), rng.normal(size=5)
    duals[newton.DUAL, 6:] = rng.normal(size=5)
    light, before = rows[:, rows_of.LIGHT].copy(), duals[newton.DUAL, 6:] * rows[:, rows_of.HEAVY]

    def gap():
        return (columns[:, 6:].T @ f - sets[4:, newton.LINK] * light * q) / rows[:, rows_of.HEAVY]

    first = gap()
    rows_of._stiffen((columns, sets, points, duals, H), rows, 7.0)
    np.testing.assert_allclose(gap(), first)
    np.testing.assert_allclose(duals[newton.DUAL, 6:] * rows[:, rows_of.HEAVY], before)


def test_update_moves_multipliers_and_measures():
    T, low, high, units, _, _, (columns, sets, points, duals, H, rows) = loaded(2)
    rng = np.random.default_rng(2)
    f, q, y = rng.normal(size=12) * 3.0, rng.normal(size=5), rng.normal(size=11)
    rows[:, rows_of.MULTIPLIER], rows[:, rows_of.LAST] = rng.normal(size=(2, 5))
    old, last = rows[:, rows_of.MULTIPLIER].copy(), rows[:, rows_of.LAST].copy()
    points[newton.VALUE] = np.concatenate([f, q * rows[:, rows_of.LIGHT]])
    duals[newton.DUAL] = y
    violation, shift = rows_of._update((columns, sets, points, duals, H), rows)
    value = T @ (units * f)
    assert violation == pytest.approx(max(0.0, *(low - value), *(value - high)))
    assert shift == pytest.approx(np.max(np.abs(q - last) * rows[:, rows_of.LIGHT]))
    np.testing.assert_allclose(rows[:, rows_of.MULTIPLIER], y[6:] * rows[:, rows_of.HEAVY])
    np.testing.assert_allclose(rows[:, rows_of.MOVED], rows[:, rows_of.MULTIPLIER] - old)
    np.testing.assert_allclose(rows[:, rows_of.LAST], q)


@pytest.mark.parametrize("seed", range(30))
def test_proof_of_emptiness_is_one(seed):
    """The direction separates exactly if the best of many forces cannot reach the best of the limits."""
    T, low, high, units, _, work, (columns, sets, _, _, _, rows) = loaded(seed, count=2)
    rng = np.random.default_rng(50 + seed)
    direction = rng.normal(size=2)
    offset = rng.uniform(-60.0, 60.0)
    sets[4:, newton.LOW] += offset * rows[:, rows_of.LIGHT]
    sets[4:, newton.HIGH] += offset * rows[:, rows_of.LIGHT]
    rows[:, rows_of.MOVED] = direction
    angle = np.linspace(0.0, 2.0 * np.pi, 2000)
    pull = (T.T @ direction * units).reshape(4, 3)
    most = 0.0
    for k in range(4):
        mu = work[k, layout.MU]
        circle = np.column_stack([mu * np.cos(angle), mu * np.sin(angle), np.ones(2000)])
        top = max((z * circle @ pull[k]).max() for z in (0.5, 4.0))
        most += top
    least = np.sum(np.minimum(direction * (low + offset), direction * (high + offset)))
    if abs(most - least) > 1e-3:
        assert rows_of._proves_empty(columns, sets, rows) == (most < least)


def test_row_violation_and_limits():
    rng = np.random.default_rng(0)
    J, f = rng.normal(size=(12, 3)), rng.normal(size=(4, 3))
    low, high = np.array([-1.0, -np.inf, 2.0]), np.array([1.0, 0.5, np.inf])
    value = J.T @ f.ravel()
    expected = max(np.max(low - value), np.max(value - high))
    assert rows_of.row_violation(J, f, low, high) == pytest.approx(expected)
    work = np.zeros((4, layout.WIDTH))
    work[:2, layout.NORMAL] = 2.0
    on = np.array([True, False])
    assert layout.set_limits(work, np.array([1.0, 3.0]), np.array([4.0, 5.0]), on) == -1
    np.testing.assert_allclose(work[:2, [layout.LOW, layout.HIGH]], [[0.5, 2.0], [0.0, 0.0]])
    np.testing.assert_allclose(work[:2, [layout.FLOOR, layout.CEILING]], [[1.0, 4.0], [0.0, 0.0]])
    for low_1, high_1 in ((6.0, 5.0), (-1.0, 5.0), (np.nan, 5.0), (1.0, np.nan)):
        assert layout.set_limits(work, np.array([1.0, low_1]), np.array([4.0, high_1]), on) == 1
