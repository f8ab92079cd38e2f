"""Weights and penalties of blocks of rows, against the inverse of MuJoCo's own inertia."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from surefoot.base.numerics.tree_factor import factor_tree
from surefoot.contact import ROW_PENALTY, find_columns
from surefoot.worlds.mujoco.stepper.row_weights import LIGHTEST, fill_weights

GEOM = '<geom size="0.1" mass="{m}" pos="0.1 0.02 0.03"/>'
MODEL = f"""<mujoco><worldbody>
<body><freejoint/>{GEOM.format(m=2)}
  <body pos="0.3 0 0"><joint axis="0 1 0"/>{GEOM.format(m=1)}
    <body pos="0.3 0 0"><joint axis="0 1 0"/>{GEOM.format(m=0.3)}</body></body>
  <body pos="0 0.3 0"><joint axis="1 0 0"/>{GEOM.format(m=0.5)}</body></body>
<body pos="2 0 0"><freejoint/>{GEOM.format(m=4)}</body>
<body pos="4 0 0"><joint type="slide"/>{GEOM.format(m=1)}</body>
</worldbody></mujoco>"""
DIMS = (1, 3, 4, 6, 3)


@pytest.mark.parametrize("seed", range(6))
def test_weights_are_the_diagonal_of_what_rows_move(seed: int) -> None:
    rng = np.random.default_rng(seed)
    model = mujoco.MjModel.from_xml_string(MODEL)
    data = mujoco.MjData(model)
    mujoco.mj_integratePos(model, data.qpos, rng.normal(size=model.nv), 1.0)
    mujoco.mj_forward(model, data)
    M = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, M)
    J, table = np.zeros((sum(DIMS), model.nv)), np.zeros((len(DIMS), 4), dtype=np.int64)
    reached = np.zeros((len(DIMS), model.nv + 1), dtype=np.int64)
    for k, dim in enumerate(DIMS):
        first = sum(DIMS[:k])
        table[k, 1:3] = dim, first
        moved = rng.permutation(model.nv)[: int(rng.integers(1, 8))]
        J[first : first + dim, moved] = rng.normal(size=(dim, len(moved)))
        find_columns(J, first, dim, reached[k])
        assert sorted(moved) == reached[k, 1 : reached[k, 0] + 1].tolist()
    tree = [np.array(a, dtype=np.int64) for a in (model.M_rownnz, model.M_rowadr, model.M_colind)]
    factors, numbers = np.array(data.M), np.zeros((len(DIMS), 6))
    assert factor_tree(factors, *tree)
    fill_weights(J, reached, table, numbers, factors, *tree)
    diagonal = np.einsum("ij,ji->i", J, np.linalg.solve(M, J.T))
    for k, dim in enumerate(DIMS):
        own = diagonal[table[k, 2] : table[k, 2] + dim]
        assert numbers[k, 2] == pytest.approx(own.sum(), rel=1e-9)
        assert numbers[k, 3] == pytest.approx(ROW_PENALTY / own[0], rel=1e-9)
        if dim > 1:
            assert numbers[k, 4] == pytest.approx(ROW_PENALTY / own[1:].max(), rel=1e-9)
    lightest = LIGHTEST * numbers[:, 2].max()
    assert numbers[0, 4] == pytest.approx(ROW_PENALTY / lightest)  # a single row has no others
