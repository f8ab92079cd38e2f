"""Masks of force distribution: what is remembered, and broken input of contacts that are off."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.base.errors import ProblemError
from surefoot.contact import Status
from surefoot.mechanics.statics.force_distribution import ForceDistributor


@pytest.mark.parametrize("bad", [np.nan, np.inf])
@pytest.mark.parametrize("on", [(0, 0, 0, 0), (0, 1, 1, 1)])
def test_a_broken_grasp_map_is_invalid_though_its_contacts_are_off(bad: float, on: tuple[int, ...]) -> None:
    rng = np.random.default_rng(8)
    distributor = ForceDistributor(0.6, 5.0, 250.0, torque_limit=[50.0, 50.0])
    A, w = rng.normal(size=(6, 12)), np.array([0.0, 0.0, 150.0, 0.0, 0.0, 0.0])
    held = distributor.solve(A, w)
    broken = A.copy()
    broken[2, 1] = bad
    jacobian = np.zeros((12, 2))
    for rows in ({}, {"jacobian": jacobian}):
        forces = distributor.solve(broken, w, active=on, **rows)
        assert distributor.status is Status.INVALID
        assert distributor.wrench_error == distributor.force_error == np.inf
        assert np.isfinite(forces).all()
        assert (forces[np.array(on) == 0] == 0.0).all()
    distributor.solve(A, w, active=on)
    assert distributor.status is Status.SOLVED
    assert held.shape == (4, 3)


def test_the_mask_that_is_remembered_can_be_read() -> None:
    distributor = ForceDistributor([0.6] * 4, 0.0, 250.0)
    rng = np.random.default_rng(9)
    A, w = rng.normal(size=(6, 12)), rng.normal(size=6)
    assert distributor.active.tolist() == [True] * 4
    distributor.solve(A, w, active=[1, 0, 1, 0])
    assert distributor.active.tolist() == [True, False, True, False]
    distributor.solve(A, w)
    assert distributor.active.tolist() == [True, False, True, False]
    distributor.active[:] = True  # a copy
    assert distributor.active.tolist() == [True, False, True, False]
    distributor.solve(A, w, active=np.ones(4, dtype=bool))
    assert distributor.active.all()


def test_a_mask_of_nan_is_refused() -> None:
    distributor = ForceDistributor([0.6] * 4)
    with pytest.raises(ProblemError, match="active"):
        distributor.set_active([np.nan, 1, 1, 1])
