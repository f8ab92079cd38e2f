"""Every distributor on hard input: grasp map, wrench, Jacobian in; forces, status, a bound on error out."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from surefoot.contact.solution import Status
from surefoot.mechanics.statics.allocation import ExactAllocation
from surefoot.mechanics.statics.force_distribution import ForceDistributor
from tests.conformance.hard_inputs import (
    EXTREME,
    HIGH,
    LOW,
    MU,
    NOT_FINITE,
    WRENCH,
    check_forces,
    grasp,
)


class Distribution:
    """One way to distribute forces, with the bounds that every member of the family has here."""

    low, high = np.full(4, LOW), np.full(4, HIGH)

    def __init__(self) -> None:
        self.distributor = ForceDistributor(MU, LOW, HIGH, 1.0, 1e-4)

    def solve(self, A: np.ndarray, w: np.ndarray) -> np.ndarray:
        return self.distributor.solve(A, w)

    @property
    def status(self) -> Status:
        return self.distributor.status

    @property
    def errors(self) -> list[float]:
        return [self.distributor.force_error, self.distributor.wrench_error]


class WithTorques(Distribution):
    def __init__(self) -> None:
        self.distributor = ForceDistributor(MU, LOW, HIGH, 1.0, 1e-4, torque_limit=np.full(12, 15.0))
        self.jacobian = 0.3 * np.random.default_rng(3).normal(size=(12, 12))

    def solve(self, A: np.ndarray, w: np.ndarray) -> np.ndarray:
        return self.distributor.solve(A, w, jacobian=self.jacobian)


class Exact(Distribution):
    def __init__(self) -> None:
        self.distributor: Any = ExactAllocation(np.full(4, MU), np.ones(6), 1e-4)

    def solve(self, A: np.ndarray, w: np.ndarray) -> np.ndarray:
        return np.asarray(self.distributor.share(A, w, self.low, self.high))

    @property
    def errors(self) -> list[float]:
        return []


DISTRIBUTORS: dict[str, Callable[[], Distribution]] = {
    "ForceDistributor": Distribution,
    "ForceDistributor with torque limits": WithTorques,
    "ExactAllocation": Exact,
}
over_distributors = pytest.mark.parametrize("name", DISTRIBUTORS)


@over_distributors
@pytest.mark.parametrize("bad", NOT_FINITE)
@pytest.mark.parametrize("where", ["grasp map", "wrench"])
def test_distributors_hold_what_they_had_when_input_is_not_finite(name: str, where: str, bad: float) -> None:
    member = DISTRIBUTORS[name]()
    A, w = grasp(), WRENCH.copy()
    (A if where == "grasp map" else w).flat[2] = bad
    for before in (False, True):  # as the first input, and after a good one
        for _ in range(4 if before else 0):  # until shares of the step before have settled
            good = member.solve(grasp(), WRENCH)
        forces = member.solve(A, w)
        assert member.status is Status.INVALID
        assert all(error == math.inf for error in member.errors)
        check_forces(forces, member.low, member.high)
        if before:
            np.testing.assert_allclose(forces, good, atol=1e-6)
    again = member.solve(grasp(), WRENCH)
    assert member.status is Status.SOLVED
    np.testing.assert_allclose(again, good, atol=1e-4)


@over_distributors
@pytest.mark.parametrize("size", EXTREME)
def test_distributors_stay_finite_on_extreme_input(name: str, size: float) -> None:
    """Huge and tiny wrenches and grasp maps; SOLVED only with a finite bound on the error."""
    for which in ("wrench", "map", "both"):
        member = DISTRIBUTORS[name]()
        A, w = grasp(), WRENCH.copy()
        if which != "map":
            w[0] = size
        if which != "wrench":
            A[4, 5] = size
        check_forces(member.solve(A, w), member.low, member.high)
        if member.status is Status.SOLVED:
            assert all(math.isfinite(error) for error in member.errors)
        for _ in range(3):  # the warm start may take a call or two to forget, and says so
            check_forces(member.solve(grasp(), WRENCH), member.low, member.high)
        assert member.status is Status.SOLVED


@over_distributors
def test_distributors_say_what_they_miss(name: str) -> None:
    """A wrench beyond every cone: the nearest forces, and the error is told by the wrench that is left."""
    member = DISTRIBUTORS[name]()
    w = np.array([500.0, 0.0, 100.0, 0.0, 0.0, 0.0])
    forces = member.solve(grasp(), w)
    check_forces(forces, member.low, member.high)
    left = float(np.linalg.norm(grasp() @ forces.ravel() - w))
    assert left > 50.0
    if member.errors:
        assert member.errors[1] == pytest.approx(left, rel=1e-9)


def test_impossible_torque_limits_are_infeasible_with_no_bound_on_the_error() -> None:
    distributor = ForceDistributor(MU, 60.0, HIGH, 1.0, 1e-4, torque_limit=np.full(4, 1.0))
    J = np.zeros((12, 4))
    J[2::3] = 0.3 * np.eye(4)  # 60 N take 18 N m
    forces = distributor.solve(grasp(), WRENCH, jacobian=J)
    check_forces(forces, np.full(4, 60.0), np.full(4, HIGH))
    assert distributor.status is Status.INFEASIBLE
    assert distributor.force_error == math.inf
    assert distributor.torque_excess == pytest.approx(17.0, abs=0.01)
    J[0, 0] = math.nan
    distributor.solve(grasp(), WRENCH, jacobian=J)
    assert distributor.status is Status.INVALID
    assert distributor.torque_excess == math.inf


def test_nothing_is_known_before_the_first_solve() -> None:
    distributor = ForceDistributor(MU, LOW, HIGH)
    assert distributor.status is Status.INVALID
    assert distributor.force_error == distributor.wrench_error == distributor.torque_excess == math.inf
