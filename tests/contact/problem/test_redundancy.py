from __future__ import annotations

import numpy as np

import surefoot as sf
from benchmarks.problems.rigid_bodies import Scene


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
