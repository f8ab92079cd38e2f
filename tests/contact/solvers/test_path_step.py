"""Steps by the path's length come back to the central path, go on along it, and get past its turns."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import surefoot as sf
from surefoot.contact.problem.problem import ContactProblem
from surefoot.contact.solvers import interior_point
from surefoot.contact.solvers.central_path import CentralPath
from surefoot.contact.solvers.central_step import Iterate, Scaling, fill_residual
from surefoot.contact.solvers.cone_pairs import centrality, scale_pairs
from surefoot.contact.solvers.delassus_factor import find_factor
from surefoot.contact.solvers.path_step import IRRATIONAL, Motion, path_step, unequal_shares
from surefoot.contact.solvers.reduced_structure import find_structure
from surefoot.contact.solvers.reduced_system import ReducedSystem
from surefoot.contact.solvers.step_memory import StepMemory, Turning

NOTHING = np.empty(0)
N, R = 10, 6


class Path:
    """A random problem y = Y Yᵀ x + g + ||ȳ|| e_3 in scaled variables, and a point inside the cones."""

    def __init__(self, seed: int, unequal: bool = False) -> None:
        self.unequal = unequal
        rng = np.random.default_rng(seed)
        self.rows = rng.normal(size=(3 * N, R))
        self.g = (self.rows @ rng.normal(size=R)).reshape(N, 3)
        x = np.tile([0.0, 0.0, 1.0], (N, 1))
        self.point = Iterate(x, np.ones(N), x.copy(), np.ones(N))
        self.motion = Motion(np.zeros((N, 3)), np.zeros((N, 3)), np.zeros(1))
        self.residual = np.empty((N, 3))

    def step(self, reach: float = 1.0) -> tuple[float, float, float]:
        """Take a step, or a share of it; return the gap before it, the residual, the log gap's change."""
        scaling = Scaling(np.empty((N, 4)), np.empty((N, 3)), np.empty((N, 3, 3)))
        gap = float(scale_pairs(*self.point, 1.0, *scaling))
        u = (self.rows @ (self.rows.T @ self.point.x.ravel())).reshape(N, 3) + self.g
        far = float(fill_residual(self.point.y, np.ones((N, 3)), u, NOTHING, np.ones(N), self.residual))
        system = ReducedSystem(self.rows, np.ones((N, 3)), find_structure(self.rows))
        factors = system.factorise(scaling.weights)
        assert factors is not None
        after = Iterate(np.empty((N, 3)), np.empty(N), np.empty((N, 3)), np.empty(N))
        shares, sign = np.ones(N), 0.0
        if self.unequal:
            shares, sign = unequal_shares(N), -factors.sign
        length, log, _ = path_step(
            factors, system.rows, self.point, self.residual, scaling, gap, self.motion, shares, sign, reach,
            after,
        )  # fmt: skip
        assert 0.0 < length <= 1.0
        self.point = after
        return gap, far, log


@pytest.mark.parametrize("unequal", [False, True])
@pytest.mark.parametrize("seed", range(4))
def test_steps_come_back_to_the_path_and_go_down_along_it(seed: int, unequal: bool) -> None:
    path = Path(seed, unequal)
    gap, far, _ = path.step()
    for _ in range(60):
        if gap < 1e-5:
            break
        gap, far, _ = path.step()
    assert gap < 1e-5
    assert far < 0.1 * np.sqrt(gap)
    assert centrality(*path.point) >= 0.05


def test_a_step_changes_the_gap_by_what_it_says() -> None:
    path = Path(3)
    for _ in range(4):
        path.step()
    (before, _, log), (after, _, _) = path.step(), path.step()
    assert after / before == pytest.approx(1.0 + log, abs=0.1)  # the log's first order
    assert log < 0.0


def test_what_a_step_leaves_of_the_products_is_of_third_order() -> None:
    """Half a step along the path leaves an eighth of it, where a straight one leaves a quarter."""
    left = []
    for reach in (0.1, 0.05, 0.025):
        path = Path(3, unequal=True)
        for _ in range(4):
            path.step()
        for _ in range(3):  # back to the path, and hardly on
            path.step(1e-9)
        path.step(reach)
        products = np.einsum("ij,ij->i", path.point.x, path.point.y) / unequal_shares(N)
        left.append(np.abs(products / products.mean() - 1.0).max())
    assert np.divide(left[1:], left[:-1]) == pytest.approx(1.0 / 8.0, rel=0.1)


def test_a_turn_of_a_wall_of_23_bricks_is_passed() -> None:
    """Steps that aim at a smaller gap end at an error of 6e-3 there."""
    pytest.importorskip("mujoco")
    from benchmarks.problems.stacked_scenes import SCENES, steps

    given = next(steps(SCENES["wall of 23"], 1)).problem
    problem = ContactProblem(given.G, given.g, given.mu)
    active = np.ones(problem.contacts, dtype=bool)
    found = find_factor(problem, np.repeat(active, 3))
    assert found is not None
    errors = []
    for turns in (0, 60):
        path = CentralPath(problem, active, 1e-8, 1000, np.inf, *found)
        path.follow(path.start(1.0), turns, interior_point.POLISH_FROM)
        errors.append(path.error)
    assert errors[0] > 1e-3
    assert errors[1] <= 1e-5


def test_the_path_that_equal_shares_lose_is_followed_with_unequal_ones() -> None:
    """Step 97 of that wall: with equal shares steps end at an error of 1.5e-3."""
    pytest.importorskip("mujoco")
    from benchmarks.problems.stacked_scenes import SCENES, steps

    *_, given = steps(SCENES["wall of 23"], 98)
    problem = ContactProblem(given.problem.G, given.problem.g, given.problem.mu)
    active = np.ones(problem.contacts, dtype=bool)
    found = find_factor(problem, np.repeat(active, 3))
    assert found is not None
    path = CentralPath(problem, active, 1e-6, 9000, np.inf, *found)
    start = path.start(1.0)
    path.follow_unequally(start, interior_point.MOST_UNEQUAL, interior_point.POLISH_FROM)
    assert interior_point.InteriorRun(problem, active, path, 9000).end(start)
    assert path.error <= 1e-6


@pytest.mark.long
def test_another_path_is_followed_where_one_is_lost(monkeypatch: pytest.MonkeyPatch) -> None:
    """The same step: four paths, each of its own shares, and then a long one."""
    pytest.importorskip("mujoco")
    from benchmarks.problems.stacked_scenes import SCENES, steps

    *_, given = steps(SCENES["wall of 23"], 98)
    problem = ContactProblem(given.problem.G, given.problem.g, given.problem.mu)
    shares: list[float] = []
    follow = CentralPath.follow_unequally

    def lose_first(path: CentralPath, *rest: Any) -> bool:
        shares.append(float(path.memory.unequal[0]))
        return len(shares) == 1 or follow(path, *rest)

    monkeypatch.setattr(CentralPath, "follow_unequally", lose_first)
    assert sf.solve(problem, "interior_point", 1e-6).solved
    assert 2 <= len(shares) <= interior_point.PATHS + 1
    assert len(set(shares[: interior_point.PATHS])) == min(len(shares), interior_point.PATHS)


@pytest.mark.parametrize(("error", "most"), [(1e-6, len(IRRATIONAL)), (3e-8, 1)])
def test_one_long_path_is_enough_where_it_ends_near_an_answer(
    error: float, most: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of what is left at 3e-8, seven more paths and their ends leave as much."""
    Y = np.random.default_rng(0).normal(size=(12, 9))
    problem = ContactProblem(Y @ Y.T, -np.ones(12), 0.5)
    active = np.ones(4, dtype=bool)
    found = find_factor(problem, np.repeat(active, 3))
    assert found is not None
    path = CentralPath(problem, active, 1e-8, 9000, np.inf, *found)
    ends: list[float] = []

    def end(run: interior_point.InteriorRun, *_: Any) -> bool:
        ends.append(run.path.error)
        run.path.error = error
        return False

    monkeypatch.setattr(CentralPath, "follow_unequally", lambda *_: None)
    monkeypatch.setattr(interior_point.InteriorRun, "_finish", end)
    interior_point.InteriorRun(problem, active, path, 10).go_long()
    assert len(ends) == most


def test_steps_that_bring_no_smaller_gap_are_lost_after_a_while() -> None:
    path = Path(0, unequal=True)
    memory = StepMemory(ReducedSystem(path.rows, np.ones((N, 3)), find_structure(path.rows)), N)
    patient, other = Turning(True, 3.0), Turning(True)
    gaps = [0.5, 0.4, 0.4, 0.45, 0.4, 0.4]
    for number, gap in enumerate(gaps):
        memory.residual[:] = 0.0
        memory.scale(path.point, 1.0)
        for turning in (patient, other):
            turning.step(memory, path.point, gap)
        assert patient.lost == (number == 5)
    assert not other.lost


def test_shares_of_the_gap_are_unequal_and_one_in_the_mean() -> None:
    shares = unequal_shares(144)
    assert len(np.unique(shares)) == 144
    assert shares.min() >= 0.5
    assert shares.max() <= 1.5
    assert shares.mean() == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("count", [1, 7, 144, 1000])
def test_shares_of_any_number_differ_and_have_mean_one(count: int) -> None:
    numbers = [unequal_shares(count, number) for number in range(len(IRRATIONAL))]
    for at, shares in enumerate(numbers):
        assert len(np.unique(shares)) == count
        assert 0.5 <= shares.min() <= shares.max() <= 1.5
        assert abs(shares.mean() - 1.0) < 1.0 / count + 1e-3
        assert not any(np.allclose(shares, other) for other in numbers[:at])
