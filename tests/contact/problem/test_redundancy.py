from __future__ import annotations

import numpy as np
import scipy.sparse as sp

import surefoot as sf
from benchmarks.problems.contacts import pile, stack
from benchmarks.problems.rigid_bodies import Scene
from surefoot.contact.problem.redundancy import few_bodies, in_a_row


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


def test_a_stack_is_in_a_row_whatever_the_order_of_its_contacts_and_a_pile_is_not() -> None:
    rng = np.random.default_rng(0)
    made = stack(rng, 50, 0.6, 1.0, 0.2)
    order = np.repeat(3 * rng.permutation(made.contacts), 3) + np.tile(np.arange(3), made.contacts)
    mixed = sf.ContactProblem(made.G[np.ix_(order, order)], made.g[order], 0.6)
    assert in_a_row(mixed)
    assert not few_bodies(mixed)
    assert not in_a_row(pile(rng, 60, 300, 0.6, 1.0))
    assert not in_a_row(sf.ContactProblem(sp.identity(3 * 2001), np.zeros(3 * 2001), 0.6))
