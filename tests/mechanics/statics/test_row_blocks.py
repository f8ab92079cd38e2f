"""Bounds on many contacts: blocks of rows give what one piece gives, at a cost that follows their number."""

from dataclasses import replace

import numpy as np
import pytest

import surefoot as sf
from surefoot.mechanics.statics import row_blocks
from surefoot.mechanics.statics.limits import Question, all_limits, equations, normal_limits, squeeze_limit
from surefoot.mechanics.statics.margin import most_margin
from surefoot.mechanics.statics.row_blocks import IN_ONE
from surefoot.mechanics.statics.statics import can_stand, needed_wrench

MASS = 20.0


def unit(vector):
    return np.array(vector) / np.linalg.norm(vector)


def bounded_stance(rng, count, share, patches=False):
    """Return contacts on rough ground, each with bounds, that may carry `share` of the weight together."""
    most = share * MASS * 9.81 / count * rng.uniform(0.5, 1.5, count)
    out = []
    for k in range(count):
        place, normal = rng.uniform(-0.5, 0.5, 3), unit([*rng.normal(0.0, 0.3, 2), 1.0])
        mu, bounds = rng.uniform(0.2, 1.0), {"normal_min": 0.01 * most[k], "normal_max": most[k]}
        foot = sf.SoleContact(place, sf.Sole(0.1, 0.05, mu), normal, **bounds) if patches else None
        out.append(foot or sf.PointContact(place, normal, mu, **bounds))
    return sf.Stance(out)


def both_ways(question):
    eq = equations(question)
    assert len(eq.blocks)
    apart = most_margin(eq.A, eq.e, eq.w, eq.lorentz, eq.blocks)
    return eq, apart, most_margin(eq.A, eq.e, eq.w, eq.lorentz, IN_ONE)


@pytest.mark.parametrize("share", [0.9, 1.3, 3.0, 30.0])
@pytest.mark.parametrize("kind", ["points", "patches", "facets", "total"])
def test_blocks_give_the_margin_of_one_piece(kind, share):
    """Possible and impossible stances, exact cones and pyramids, and a bound that touches all."""
    rng = np.random.default_rng(int(10 * share))
    for count in (18, 40):
        stance = bounded_stance(rng, count, share, kind == "patches")
        total = squeeze_limit(stance, 1.2 * MASS * 9.81) if kind == "total" else None
        com = stance.points().positions.mean(axis=0) + rng.uniform(-0.1, 0.1, 3)
        question = Question(stance, com, needed_wrench(MASS), all_limits(normal_limits(stance), total))
        if kind == "facets":
            question.facets = 8
        eq, apart, whole = both_ways(question)
        assert apart[0] == whole[0]
        assert apart[1] == pytest.approx(whole[1], abs=2e-9)
        np.testing.assert_allclose(eq.A @ apart[2], eq.w, atol=1e-9)
        verdict = can_stand(stance, com, MASS, facets=question.facets, limits=total)
        assert verdict.status != "undecided"
        assert verdict.verify()


def test_a_load_out_of_reach_is_told_with_blocks_too():
    """Contacts in a row give no moment about it."""
    feet = [sf.PointContact([0.01 * k, 0.0, 0.0], normal_max=100.0) for k in range(40)]
    verdict = can_stand(sf.Stance(feet), [0.2, 0.05, 0.3], MASS)
    assert verdict.status == "impossible"
    assert verdict.verify()


def test_every_bounded_contact_is_a_block():
    """The factor of 256 contacts is blocks of two rows and a border of six: it took 0.5 s in one piece."""
    stance = bounded_stance(np.random.default_rng(0), 256, 2.0)
    eq = equations(Question(stance, np.zeros(3), needed_wrench(MASS), normal_limits(stance)))
    np.testing.assert_array_equal(eq.blocks[:, 1] - eq.blocks[:, 0], 2)
    np.testing.assert_array_equal(eq.blocks[:, 3] - eq.blocks[:, 2], 3)
    for top, bottom, a, b, c, d in eq.blocks:
        outside = np.delete(eq.A[top:bottom], np.r_[a:b, c:d], axis=1)
        assert not outside.any()


def test_few_bounds_stay_in_one_piece():
    stance = bounded_stance(np.random.default_rng(0), 8, 2.0)
    question = Question(stance, np.zeros(3), needed_wrench(MASS), normal_limits(stance))
    assert equations(question).blocks is IN_ONE  # kernels for rows in one piece, which look up no spans


def test_blocks_are_factored_like_any_rows():
    """A = T Q with orthonormal Q, each row in its span; T is triangular on the pivots."""
    stance = bounded_stance(np.random.default_rng(1), 20, 2.0)
    limits = all_limits(normal_limits(stance), squeeze_limit(stance, 400.0))
    eq = equations(Question(stance, np.zeros(3), needed_wrench(MASS), limits))
    p, m = eq.A.shape
    Q, T, pivots = np.empty((p, m)), np.empty((p, p)), np.empty(p, dtype=np.int64)
    spans = np.zeros((p, 5), dtype=np.int64)
    rank = row_blocks.orthonormal_blocks(eq.A, eq.blocks, Q, T, pivots, spans)
    assert rank == p == np.linalg.matrix_rank(eq.A)
    np.testing.assert_allclose(Q @ Q.T, np.eye(p), atol=1e-14)
    np.testing.assert_allclose(T @ Q, eq.A, atol=1e-13)
    np.testing.assert_array_equal(np.triu(T[pivots], 1), 0.0)
    for j in range(p):
        assert row_blocks.dot_span.py_func(Q[j], Q[j], spans, j) == pytest.approx(1.0)
        other = np.zeros(m)
        row_blocks.advance_span.py_func(other, 2.0, Q[j], spans, j)
        np.testing.assert_array_equal(other, 2.0 * Q[j])
    twice = replace(eq, A=np.vstack([eq.A[:-1], eq.A[-2]]))  # a block whose rows depend on each other
    twice.A[-1, eq.blocks[-1, 4] :] = twice.A[-2, eq.blocks[-1, 4] :]
    assert row_blocks.orthonormal_blocks(twice.A, eq.blocks, Q, T, pivots, spans) == p - 1
    assert np.array_equal(spans, [[0, 0, m, m, m]] * p)
    np.testing.assert_allclose(T[:, : p - 1] @ Q[: p - 1], twice.A, atol=1e-13)


def spread_rows(rng, blocks):
    """Return rows of blocks of two beside a border of three, their spans, and how many they are."""
    p, m = 2 * blocks + 3, 5 * blocks
    rows, spans = np.zeros((p, m)), np.tile([0, 0, m, m, m], (p, 1))
    for g in range(blocks):
        rows[2 * g : 2 * g + 2, 3 * g : 3 * g + 3] = rng.normal(size=(2, 3))
        slacks = slice(3 * blocks + 2 * g, 3 * blocks + 2 * g + 2)
        rows[2 * g : 2 * g + 2, slacks] = np.eye(2)
        spans[2 * g : 2 * g + 2] = [2 * g, 3 * g, 3 * g + 3, slacks.start, slacks.stop]
    rows[2 * blocks :] = rng.normal(size=(3, m))
    return rows, spans


def lower_of(A, spans):
    """Return the lower triangle of A, and nonsense where nothing may be read."""
    out = np.full_like(A, np.nan)
    for j in range(len(A)):
        part = slice(row_blocks.first_row.py_func(spans, j), j + 1)
        out[j, part] = A[j, part]
    return out


@pytest.mark.parametrize("blocks", [None, 0, 1, 6])
def test_the_guarded_factor_is_cholesky_s(blocks):
    """Products and rows give the same factor, without spans too; the share that a pivot kept is the least."""
    rng = np.random.default_rng(blocks or 0)
    one_piece = rng.normal(size=(6, 9)), None if blocks is None else np.tile([0, 0, 9, 9, 9], (6, 1))
    rows, spans = spread_rows(rng, blocks) if blocks else one_piece
    assert row_blocks.local_rows.py_func(spans) == 2 * (blocks or 0)
    A, free = rows @ rows.T, np.empty(0)
    L, count = np.linalg.cholesky(A), len(A)
    M, other = lower_of(A, spans), lower_of(A, spans)
    kept = row_blocks.guarded_cholesky.py_func(M, spans, 0, count)
    assert kept == pytest.approx((np.diag(L) ** 2 / np.diag(A)).min())
    row_blocks.factor_rows.py_func(rows, other, spans, free, free)
    np.testing.assert_allclose(np.tril(np.nan_to_num(M)), L, atol=1e-12)
    np.testing.assert_allclose(np.tril(np.nan_to_num(other)), L, atol=1e-12)
    b = rng.normal(size=count)
    x = b.copy()
    row_blocks.solve_factored.py_func(M, x, spans, free)
    np.testing.assert_allclose(A @ x, b, atol=1e-10)
    assert np.isnan(row_blocks.guarded_cholesky.py_func(np.full((2, 2), np.nan), IN_ONE, 0, 2))


@pytest.mark.parametrize("lost", [1.0, 1e-6, 1e-12])
def test_an_unknown_along_an_axis_is_factored_with_the_rows(lost):
    """The solution is that of the bordered system, also where the matrix alone is nearly singular."""
    rng = np.random.default_rng(3)
    rows, spans = spread_rows(rng, 5)
    axis = rng.normal(size=len(rows))
    axis /= np.linalg.norm(axis)
    rows[-1] -= (1.0 - lost) * (axis @ rows) / axis[-1]  # of what it has along the axis, a share is left
    A = rows @ rows.T
    count, b = len(A), rng.normal(size=len(A))
    whole = np.block([[A, axis[:, None]], [axis, np.zeros(1)]])
    exact = np.linalg.solve(whole, np.append(b, 0.0))[:count]
    for by_rows in (False, True):
        M, free, x = lower_of(A, spans), np.empty(count + 1), b.copy()
        if by_rows:
            row_blocks.factor_rows.py_func(rows, M, spans, axis, free)
        else:
            assert row_blocks.factor.py_func(M, spans, axis, free) > 0.0
        row_blocks.solve_factored.py_func(M, x, spans, free)
        np.testing.assert_allclose(x, exact, rtol=1e-9, atol=1e-11 * np.abs(exact).max())
        assert abs(axis @ x) < 1e-12 * np.abs(exact).max()


@pytest.mark.parametrize("rank", [1, 3, 5])
def test_vanishing_pivots_give_zero_unknowns(rank):
    """The guarded factor solves a consistent system of deficient rank on the rows that count."""
    rng = np.random.default_rng(rank)
    root = rng.normal(size=(5, rank))
    A = root @ root.T
    M, x, spans, free = A.copy(), A @ rng.normal(size=5), IN_ONE, np.empty(0)
    b = x.copy()
    assert (row_blocks.factor(M, spans, free, free) < 1e-10) == (rank < 5)
    row_blocks.solve_factored(M, x, spans, free)
    np.testing.assert_allclose(A @ x, b, atol=1e-6)
    assert np.count_nonzero(np.abs(x) > 1e-50) == rank


def test_rows_are_grouped_by_the_columns_that_they_touch():
    """Intervals that overlap go together; a row that touches most columns comes first."""
    rows = np.zeros((40, 120))
    for k in range(38):
        rows[k, 3 * (37 - k) + 1] = 1.0
    rows[38, 4:9] = 1.0  # with the two contacts that it touches
    rows[39, ::7] = 1.0
    order, blocks = row_blocks.find_blocks(rows, 3)
    assert order[0] == 39
    assert sorted(order) == list(range(40))
    assert len(blocks) == 37
    for top, bottom, a, b, c, d in blocks:
        assert (c, d) == (top, bottom)
        assert not np.delete(rows[order[top:bottom]], np.r_[a:b], axis=1).any()
