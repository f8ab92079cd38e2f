"""The cross-entropy method on functions whose minimum is known."""

from __future__ import annotations

import numpy as np

from surefoot.motion.planning.stand_up.cross_entropy import cross_entropy


def test_a_bowl() -> None:
    centre = np.array([1.0, -2.0, 0.5])
    found = cross_entropy(
        lambda x: float(((x - centre) ** 2).sum()), np.zeros(3), np.full(3, 2.0), rounds=60, seed=1
    )
    np.testing.assert_allclose(found.point, centre, atol=1e-3)
    assert found.evaluations == 60 * 48
    assert not found.reached


def test_it_stops_when_it_is_good_enough_and_repeats_itself() -> None:
    runs = [
        cross_entropy(lambda x: float(np.abs(x).sum()), np.ones(2), np.ones(2), enough=0.1, rounds=50, seed=4)
        for _ in range(2)
    ]
    assert runs[0].reached
    assert runs[0].cost <= 0.1
    assert runs[0].evaluations < 49 * 48
    np.testing.assert_array_equal(runs[0].point, runs[1].point)


def test_a_good_guess_is_not_lost_among_points_without_a_cost() -> None:
    def cost(x: np.ndarray) -> float:
        return 0.0 if not x.any() else float("nan")

    found = cross_entropy(cost, np.zeros(2), np.ones(2), rounds=3)
    assert found.cost == 0.0
    np.testing.assert_array_equal(found.point, np.zeros(2))


def test_interrupted_it_returns_the_best_so_far() -> None:
    seen: list[float] = []

    def cost(x: np.ndarray) -> float:
        if len(seen) == 100:
            raise KeyboardInterrupt
        seen.append(float((x**2).sum()))
        return seen[-1]

    found = cross_entropy(cost, np.ones(2), np.ones(2))
    assert found.cost == min(seen)
