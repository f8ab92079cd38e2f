"""What an elimination fills is what it says, in any order, and products of blocks are where it says."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp
from hypothesis import given, settings
from hypothesis import strategies as st

from surefoot.contact.solvers.elimination import (
    Elimination,
    find_elimination,
    find_places,
    group_columns,
    least_degree,
)


def pattern_of(count: int, edges: int, seed: int) -> np.ndarray:
    """Return a symmetric pattern of blocks with its diagonal full."""
    one, two = np.random.default_rng(seed).integers(0, count, size=(2, edges))
    meet = np.eye(count, dtype=bool)
    meet[one, two] = meet[two, one] = True
    return meet


def filled_by_hand(pattern: np.ndarray) -> np.ndarray:
    """Return the pattern of Cholesky's factor, by elimination of a matrix that cancels nothing."""
    out = pattern.copy()
    for k in range(len(out)):
        late = np.flatnonzero(out[k + 1 :, k]) + k + 1
        out[np.ix_(late, late)] = True
    return np.tril(out, -1)


def filled_of(found: Elimination) -> np.ndarray:
    """Return the same of an elimination."""
    n = found.starts.size - 1
    out = np.zeros((n, n), dtype=bool)
    out[found.below, np.repeat(np.arange(n), np.diff(found.starts))] = True
    return out


@given(st.integers(1, 14), st.integers(0, 30), st.integers(0, 2**32 - 1))
@settings(max_examples=60, deadline=None)
def test_what_is_filled_is_what_elimination_fills(count: int, edges: int, seed: int) -> None:
    pattern = pattern_of(count, edges, seed)
    found = find_elimination(pattern, np.inf)
    assert found is not None
    np.testing.assert_array_equal(filled_of(found), filled_by_hand(pattern))
    np.testing.assert_array_equal(np.diff(found.first), np.diff(found.starts) ** 2)


@given(st.integers(1, 12), st.integers(0, 30), st.integers(0, 2**32 - 1))
@settings(max_examples=40, deadline=None)
def test_a_pair_of_blocks_changes_the_block_of_its_row_and_column(count: int, edges: int, seed: int) -> None:
    found = find_elimination(pattern_of(count, edges, seed), np.inf)
    assert found is not None
    place = find_places(found.starts, found.below)
    for k in range(count):
        own = found.below[found.starts[k] : found.starts[k + 1]]
        one, two = np.meshgrid(own, own, indexing="ij")
        targets = found.targets[found.first[k] : found.first[k + 1]].reshape(one.shape)
        np.testing.assert_array_equal(place[one, two], targets)
    places = [
        *range(count),
        *(count + 2 * np.arange(found.below.size)),
        *(count + 2 * np.arange(found.below.size) + 1),
    ]
    column = np.repeat(np.arange(count), np.diff(found.starts))
    one = np.concatenate([np.arange(count), found.below, column])
    two = np.concatenate([np.arange(count), column, found.below])
    np.testing.assert_array_equal(place[one, two], places)
    assert np.count_nonzero(place >= 0) == len(places)


def test_too_much_work_is_told() -> None:
    full = np.ones((9, 9), dtype=bool)
    assert find_elimination(full, 203.0) is None  # 64 + 49 + ... + 1 = 204
    assert find_elimination(full, 204.0) is not None


@pytest.mark.parametrize("side", [10, 16])
def test_least_degree_fills_less_of_a_grid_than_its_rows_do(side: int) -> None:
    path = sp.diags([np.ones(side - 1)] * 2, [1, -1])
    grid = (sp.kron(path, sp.identity(side)) + sp.kron(sp.identity(side), path)).tocsr()
    pattern = (grid + sp.identity(side * side)).toarray() > 0.0
    order = least_degree(pattern)
    assert sorted(order.tolist()) == list(range(side * side))
    ordered, plain = find_elimination(pattern[order][:, order], np.inf), find_elimination(pattern, np.inf)
    assert ordered is not None
    assert plain is not None
    assert ordered.targets.size < 0.5 * plain.targets.size


def test_columns_that_move_the_same_contacts_are_one_block() -> None:
    moves = [[0, 1, 4], [0, 1, 4], [0, 4], [2, 3], [], [2, 3], [5]]
    starts = np.append(0, np.cumsum([len(one) for one in moves]))
    contacts = np.array([k for one in moves for k in one])
    assert group_columns(starts, contacts, 6, 0.5).tolist() == [0, 1, 2, 6, -1, 7, 12]
    assert group_columns(starts, contacts, 2, 0.5).tolist() == [0, 1, 2, 4, -1, 5, 6]
