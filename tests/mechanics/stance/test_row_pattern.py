"""Rows of contacts and their places in a matrix, against rows written out by hand."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy import sparse
from scipy.spatial.transform import Rotation

import surefoot as sf
from surefoot.base.errors import ProblemError
from surefoot.mechanics.stance.row_pattern import RowPattern

SOLE = sf.Sole(0.2, 0.1, 0.25)
POINT_ROWS = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]])
SOLE_ROWS = np.array([[1.0, -1.0, 2.0, 3.0, 4.0, 5.0]])
TURN = Rotation.from_euler("xyz", [0.2, -0.1, 0.0]).as_matrix()


def contacts(mu: float = 0.5, normal: Any = (0.0, 0.0, 1.0), high: float = math.inf) -> list[Any]:
    """Return a point and a sole of the friction 0.25."""
    point = sf.PointContact([0.2, 0.1, 0.0], normal, mu, normal_max=high)
    return [point, sf.SoleContact([0.0, 0.0, 0.0], SOLE)]


def pattern(turned: bool, own: list[Any] | None = None) -> RowPattern:
    """Return two rows of the point, of which friction scales the first, and one of the sole."""
    blocks = [
        (0, 0, POINT_ROWS, np.array([True, False])),
        (1, 3, SOLE_ROWS, np.array([True])),
    ]
    return RowPattern.of(blocks, own or contacts(), turned, [0, -1], [1, 2])


def by_hand(mu: float, R: np.ndarray) -> np.ndarray:
    """Return the rows: friction on entries 2, 3 and 4, and the point's frame turned by R."""
    first = R @ np.array([1.0, 2.0, 3.0 * mu])
    second = R @ np.array([4.0, 5.0, 6.0])
    sole = [1.0, -1.0, 2.0 * 0.25, 3.0 * 0.25, 4.0 * 0.25, 5.0]
    return np.array([[*first, *6 * [0.0]], [*second, *6 * [0.0]], [0.0, 0.0, 0.0, *sole]])


def test_a_pattern_tells_its_blocks_apart() -> None:
    rows = pattern(False)
    assert rows.shape == (3, 9)
    assert rows.foot.tolist() == [0, 0, 1]
    assert rows.column.tolist() == [0, 0, 3]
    assert rows.wide.tolist() == [3, 3, 6]
    assert rows.scaled.tolist() == [True, False, True]
    assert rows.rows.tolist() == [[1, 2, 3, 0, 0, 0], [4, 5, 6, 0, 0, 0], [1, -1, 2, 3, 4, 5]]
    assert (rows.low, rows.high) == ((0, -1), (1, 2))
    assert [bounded for _, bounded in rows.contacts] == [False, False]
    assert rows.contacts[0][0] is None
    assert len({rows, pattern(False)}) == 2  # each is one of its own, for its places
    np.testing.assert_array_equal(rows.contacts[1][0], SOLE.corners)


@pytest.mark.parametrize("turned", [False, True])
def test_the_rows_are_those_by_hand(turned: bool) -> None:
    own = contacts(0.5, TURN[:, 2])
    R = own[0].rotation_world_contact if turned else np.eye(3)
    expected = by_hand(0.5, R)
    rows = pattern(turned, own)
    np.testing.assert_allclose(rows.matrix(own), expected, atol=1e-15)
    force = np.array([3.0, -1.0, 7.0])  # of a force in world axes the contact's rows of the turned-back force
    if turned:
        back = R.T @ force
        np.testing.assert_allclose(expected[0, :3] @ force, [1.0, 2.0, 1.5] @ back)


def test_no_rows_are_a_matrix_of_none() -> None:
    empty = RowPattern.of([], contacts(), True, [-1, -1], [-1, -1])
    assert empty.matrix(contacts()).shape == (0, 9)


def test_the_sparse_rows_have_a_place_for_every_entry() -> None:
    rows = pattern(False)
    dense = rows.matrix(contacts())
    dense[0, 0] = 0.0
    columns = rows.sparse(dense)
    assert columns.nnz == 12
    np.testing.assert_array_equal(columns.toarray(), dense)


@pytest.mark.parametrize("turned", [False, True])
def test_an_update_writes_other_friction_and_frames(turned: bool) -> None:
    then = contacts(0.7, TURN[:, 2])
    expected = by_hand(0.7, then[0].rotation_world_contact if turned else np.eye(3))
    rows = pattern(turned)
    for _ in range(2):  # places are found the first time, and kept
        large = np.full((6, 12), 9.0)
        rows.update(large, then, 2, 3)
        here = np.zeros((6, 12), dtype=bool)
        here[2:4, 3:6] = here[4, 6:12] = True
        np.testing.assert_allclose(large[here], [*expected[0, :3], *expected[1, :3], *expected[2, 3:]])
        assert (large[~here] == 9.0).all()
        columns = rows.sparse(np.ones((3, 9)))
        rows.update(columns, then, 0, 0)
        np.testing.assert_allclose(columns.toarray(), expected, atol=1e-15)
        wider = np.zeros((6, 13))
        rows.update(wider, then, 0, 0)
        np.testing.assert_allclose(wider[:3, :9], expected, atol=1e-15)


@pytest.mark.parametrize(
    ("row", "column", "fits"),
    [(0, 0, True), (1, 2, True), (2, 0, False), (0, 3, False), (-1, 0, False), (0, -1, False)],
)
def test_rows_must_fit_into_the_matrix(row: int, column: int, fits: bool) -> None:
    rows, large = pattern(False), np.zeros((4, 11))
    if fits:
        rows.update(large, contacts(), row, column)
        np.testing.assert_allclose(large[row : row + 3, column : column + 9], by_hand(0.5, np.eye(3)))
        return
    said = rf"3 rows of 9 forces do not fit into A of shape \(4, 11\) at row {row}, column {column}"
    with pytest.raises(ProblemError, match=said):
        rows.update(large, contacts(), row, column)
    assert not large.any()


def test_matrices_of_another_kind_are_refused() -> None:
    rows = pattern(False)
    for wrong in (np.zeros((3, 9), dtype=np.float32), np.zeros((9, 3)).T):
        with pytest.raises(ProblemError, match="must be of floats in C order"):
            rows.update(wrong, contacts(), 0, 0)
    with pytest.raises(ProblemError, match="do not fit"):
        rows.update(np.zeros(27), contacts(), 0, 0)
    columns = rows.sparse(np.ones((3, 9)))
    taller = sparse.csc_matrix((columns.data, columns.indices, columns.indptr), shape=(4, 9))
    fewer = columns.copy()
    fewer[0, 0] = 0.0
    fewer.eliminate_zeros()
    for other in (columns.tocsr(), taller, fewer, None):
        with pytest.raises(ProblemError, match=r"or the matrix of \(3, 9\) that `sparse\(\)` returned"):
            rows.update(other, contacts(), 0, 0)


def test_contacts_of_other_shapes_or_bounds_are_refused() -> None:
    rows, A = pattern(False), np.zeros((3, 9))
    point, sole = contacts()
    wide = sf.SoleContact([0.0, 0.0, 0.0], sf.Sole(0.3, 0.1, 0.25))
    same = sf.SoleContact([0.0, 0.0, 0.0], sf.Sole(0.2, 0.1, 0.9))
    for others, said in (
        ([point], "the rows are of 2 contacts, the stance has 1"),
        ([point, wide], r"contacts\[1\] has another shape"),
        ([point, point], r"contacts\[1\] has another shape"),
        ([sole, sole], r"contacts\[0\] has another shape"),
        ([contacts(high=9.0)[0], sole], r"contacts\[0\] now has an upper bound"),
    ):
        with pytest.raises(ProblemError, match=said):
            rows.update(A, others, 0, 0)
        assert not A.any()
    bounded = pattern(False, contacts(high=9.0))
    assert [bound for _, bound in bounded.contacts] == [True, False]
    with pytest.raises(ProblemError, match=r"contacts\[0\] now has no upper bound"):
        bounded.update(A, contacts(), 0, 0)
    rows.update(A, [point, same], 0, 0)
    assert A[2, 5] == pytest.approx(2.0 * 0.9)
