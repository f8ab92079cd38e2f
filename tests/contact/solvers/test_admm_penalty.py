"""ADMM's penalty grows where the error no longer falls, and begins again from the top."""

from __future__ import annotations

import numpy as np

import surefoot as sf
from benchmarks.problems.heaps import capsules
from surefoot.contact.solvers.admm_penalty import FLOOR_GROWTH, WANDERING, PenaltyFloor


def test_a_floor_grows_while_nothing_is_gained_and_starts_anew_above_the_spectrum() -> None:
    floor, least = PenaltyFloor(largest=3.0), []
    for _ in range(5):
        for _ in range(WANDERING // 50 + 1):
            floor.look(1e-3, max(0.2, floor.least), 50)
        least.append(floor.least)
    np.testing.assert_allclose(least[:3], 0.2 * FLOOR_GROWTH ** np.arange(1, 4))
    assert least[3] == 0.0  # above the largest eigenvalue of G
    assert least[4] > 0.0


def test_a_floor_stays_while_the_error_falls() -> None:
    floor, error = PenaltyFloor(largest=3.0), 1.0
    for _ in range(200):
        floor.look(error, 0.2, 50)
        error *= 0.95
    assert floor.least == 0.0


def test_contacts_under_which_a_small_penalty_wanders_are_solved() -> None:
    """A dense heap of capsules once stayed at 2e-5 for all 20,000 iterations."""
    stream = np.random.default_rng([0, 1, *b"capsules-dense-276"])
    heap = capsules(stream, 60, 276, stream.uniform(0.3, 0.7), push=0.01)
    found = sf.solve(heap, "admm", 1e-6, max_iterations=6000)
    assert found.solved
