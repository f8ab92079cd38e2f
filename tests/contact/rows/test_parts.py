"""The connected parts of blocks of rows, against those of a graph by SciPy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from surefoot.contact.rows.blocks import DIM, FIRST, PART, count_parts
from tests.contact.rows.reached import columns_of


@pytest.mark.parametrize("seed", range(12))
def test_blocks_that_move_one_tree_are_one_part(seed: int) -> None:
    rng = np.random.default_rng(seed)
    trees, blocks, wide = int(rng.integers(1, 12)), int(rng.integers(0, 14)), 3
    tree_of = np.repeat(np.arange(trees), 2)
    moved = [rng.choice(trees, size=int(rng.integers(0, 3)), replace=trees < 3) for _ in range(blocks)]
    J = np.zeros((wide * blocks, 2 * trees))
    table = np.zeros((blocks, max(DIM, FIRST, PART) + 1), dtype=np.int64)
    for k, of_block in enumerate(moved):
        table[k, [DIM, FIRST]] = wide, wide * k
        for tree in of_block:
            J[wide * k + rng.integers(wide), 2 * tree + rng.integers(2)] = 1.0
    found = np.empty(trees, dtype=np.int64)
    count = count_parts(table, found, columns_of(J, table), tree_of)
    pairs = [(k, blocks + tree) for k, of_block in enumerate(moved) for tree in of_block]
    rows, columns = np.array(pairs, dtype=int).reshape(-1, 2).T
    graph = coo_array((np.ones(len(pairs)), (rows, columns)), shape=(blocks + trees, blocks + trees))
    labels = connected_components(graph, directed=False)[1]
    used = {int(labels[k]) for k, of_block in enumerate(moved) if len(of_block)}
    assert count == len(used)
    parts = np.r_[table[:, PART], found]
    assert (parts[~np.isin(labels, list(used))] == -1).all()
    inside = np.isin(labels, list(used))
    assert {*parts[inside].tolist()} == {*range(count)}
    assert len({*zip(parts[inside].tolist(), labels[inside].tolist(), strict=True)}) == count
