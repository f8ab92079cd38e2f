"""Samples: a function of seed and index alone, and Sobol's."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import qmc

from surefoot.worlds.sweep import NumberRange, Space, TextRange, sweep_from_dict

RANGES = {
    "delay": NumberRange(0.0, 0.01),
    "mu": NumberRange(0.1, 1.0),
    "terrain": TextRange(("flat", "slope:5", "slope:10")),
    "stiffness": NumberRange(1e3, 1e6, "log"),
    "mass": NumberRange(1.2, 1.2),
}


def test_a_sample_depends_on_seed_and_index_alone() -> None:
    space = Space(RANGES, seed=7)
    whole = space.sample(range(200))
    for indices in ([199], [0], [5, 3, 120], range(60, 90), [7, 7]):
        assert Space(RANGES, seed=7).sample(indices) == [whole[k] for k in indices]
    other = Space(RANGES, seed=8).sample(range(200))
    assert all(a.values != b.values and a.seed != b.seed for a, b in zip(whole, other, strict=True))
    assert len({s.seed for s in whole}) == 200


def test_the_order_in_the_file_does_not_matter() -> None:
    ranges = {"mu": [0.1, 1.0], "mass": 1.2, "slope": [0, 10], "body": ["box", "ball"]}
    there, back = (
        sweep_from_dict({"experiment": "drop", "ranges": dict(order)}).space
        for order in (ranges.items(), reversed(ranges.items()))
    )
    assert there.sample(range(9)) == back.sample(range(9))


def test_the_points_are_scipys_scrambled_sobol_points() -> None:
    space = Space({"mu": NumberRange(0.0, 1.0), "restitution": NumberRange(0.0, 1.0)}, seed=3)
    points = qmc.Sobol(2, seed=np.random.default_rng(3)).random_base2(7)
    drawn = [[s.values["mu"], s.values["restitution"]] for s in space.sample(range(128))]
    np.testing.assert_array_equal(drawn, points)
    assert qmc.discrepancy(np.array(drawn)) < 0.1 * qmc.discrepancy(np.random.default_rng(0).random((128, 2)))


def test_ranges_are_met_and_evenly_filled() -> None:
    samples = Space(RANGES, seed=2).sample(range(1024))
    stiffness = np.log([float(s.values["stiffness"]) for s in samples])
    counts, _ = np.histogram(stiffness, bins=8, range=(np.log(1e3), np.log(1e6)))
    assert (counts == 128).all()  # a Sobol point set in base 2
    terrains = [s.values["terrain"] for s in samples]
    assert [terrains.count(t) for t in ("flat", "slope:5", "slope:10")] == pytest.approx([341.3] * 3, abs=2)
    assert {s.values["mass"] for s in samples} == {1.2}
    assert all(0.1 <= s.values["mu"] <= 1.0 for s in samples)


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0 - 1e-16, 1.0])
def test_the_ends_of_a_range_are_not_passed(share: float) -> None:
    for one in (NumberRange(0.1, 0.3), NumberRange(0.1, 0.3, "log"), NumberRange(1e-3, 1e12, "log")):
        assert one.low <= one.at(share) <= one.high
    assert TextRange(("a", "b")).at(share) in ("a", "b")
