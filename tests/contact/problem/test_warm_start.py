from __future__ import annotations

import numpy as np

import surefoot as sf


def test_what_persists_is_carried_and_the_rest_starts_at_zero() -> None:
    forces = np.arange(9.0).reshape(3, 3)
    assert np.array_equal(sf.carry_over(forces, [2, -1, 0]), [forces[2], np.zeros(3), forces[0]])
    assert sf.carry_over(forces, []).shape == (0, 3)


def test_a_contact_switch_does_not_poison_the_start() -> None:
    """Four feet, then two of them: from the carried forces the sweeps are fewer than from the wrong ones."""
    rng = np.random.default_rng(2)
    J = rng.normal(size=(12, 10))
    G, g = J @ J.T + 0.05 * np.eye(12), np.tile([0.1, 0.0, -1.0], 4)
    before = sf.solve(sf.ContactProblem(G, g, 0.6), "nsgs").raise_if_failed()
    kept = np.array([3, 0])
    rows = (3 * kept[:, None] + np.arange(3)).ravel()
    after = sf.ContactProblem(G[np.ix_(rows, rows)], 1.01 * g[rows], 0.6)
    good = sf.solve(after, "nsgs", warm_start=sf.carry_over(before.forces, kept))
    again = sf.solve(after, "nsgs", warm_start=good.forces)
    assert good.solved
    assert again.iterations <= 1
    cold = sf.solve(after, "nsgs")
    assert np.allclose(cold.forces, good.forces, atol=1e-6)
