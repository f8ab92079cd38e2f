from __future__ import annotations

import numpy as np
import pytest

import surefoot as sf
from benchmarks.problems.contacts import problem_set
from benchmarks.problems.rigid_bodies import Scene
from surefoot.solvers.minimum_norm import minimum_norm


def table(legs: int) -> tuple[sf.ContactProblem, np.ndarray]:
    """A table at rest on evenly spread legs, and its (6, 3 legs) grasp map."""
    scene = Scene()
    body = scene.box(np.array([0, 0, 0.5]), np.array([1.0, 1.0, 0.1]), 10.0)
    for k in range(legs):
        angle = 2 * np.pi * k / legs
        scene.touch(body, -1, np.array([np.cos(angle), np.sin(angle), 0.0]), np.array([0, 0, 1.0]), 0.6)
    return scene.problem(), scene.jacobian().toarray().T


def test_rank_and_what_is_determined() -> None:
    problem, grasp_map = table(5)
    found = sf.redundancy(problem)
    assert (found.rank, found.size) == (6, 15)
    assert np.abs(problem.G @ found.null_space).max() < 1e-10
    assert np.abs(grasp_map @ found.null_space).max() < 1e-10  # the net wrench does not notice
    assert found.redundant
    assert "rank 6 of 15" in found.summary()


def test_full_rank_is_not_redundant() -> None:
    found = sf.redundancy(sf.ContactProblem(np.diag(np.arange(1.0, 7.0)), np.ones(6), 0.5))
    assert not found.redundant
    assert found.determined.all()
    assert "full rank 6" in found.summary()


def test_different_solutions_share_motion_and_net_wrench() -> None:
    problem, grasp_map = table(6)
    a = sf.solve(problem, "auto").raise_if_failed()
    uneven = np.zeros((6, 3))
    uneven[0, 2] = 0.1
    b = sf.solve(problem, "nsgs", warm_start=uneven).raise_if_failed()
    assert np.abs(a.forces - b.forces).max() > 1e-4  # different shares: a thousand times the accuracy ...

    assert np.abs(a.velocities - b.velocities).max() < 1e-8
    assert np.abs(grasp_map @ (a.forces - b.forces).ravel()).max() < 1e-8


def test_minimum_norm_spreads_a_load_evenly() -> None:
    problem, _ = table(6)
    uneven = np.zeros((6, 3))
    uneven[0, 2] = 0.1
    start = sf.solve(problem, "nsgs", warm_start=uneven).raise_if_failed()
    found = minimum_norm(start)
    assert found.solved
    assert found.forces[:, 2] == pytest.approx(np.full(6, 10.0 * 9.81 * 2e-3 / 6), rel=1e-6)
    assert np.linalg.norm(found.forces) < np.linalg.norm(start.forces)
    assert np.abs(found.velocities - start.velocities).max() < 1e-9


def test_minimum_norm_keeps_the_laws_where_contacts_slide_or_part() -> None:
    for named in problem_set("robot", copies=0.25):
        solution = sf.solve(named.problem).raise_if_failed()
        found = minimum_norm(solution)
        assert found.residuals.velocity_error <= 1e-8
        assert np.linalg.norm(found.forces) <= np.linalg.norm(solution.forces) * (1 + 1e-6)


def test_minimum_norm_wants_a_solution() -> None:
    problem, _ = table(4)
    with pytest.raises(sf.ProblemError, match="only a solved problem"):
        minimum_norm(sf.solve(problem, "nsgs", max_iterations=0))
    with pytest.raises(sf.ProblemError, match="exact cones"):
        minimum_norm(sf.solve(problem.polyhedral(8)).raise_if_failed())
