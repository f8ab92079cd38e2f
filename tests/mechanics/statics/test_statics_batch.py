"""Many stances at once: the answers are those of the single calls, whatever the stances are."""

from __future__ import annotations

import numpy as np
import pytest

import surefoot as sf
from benchmarks.problems.stances import KINDS, random_case
from surefoot.mechanics.statics.region import Region
from surefoot.mechanics.statics.statics_batch import Verdicts
from surefoot.mechanics.statics.verdict import Verdict

FEET = np.array([[0.2, 0.15, 0.0], [0.2, -0.15, 0.0], [-0.2, 0.15, 0.0], [-0.2, -0.15, 0.0]])


def arrays(rng: np.random.Generator, size: int, most: int = 6) -> tuple[np.ndarray, ...]:
    """Return positions, unit normals, friction (some of it zero) and numbers of contacts."""
    normals = rng.normal(size=(size, most, 3)) * [0.5, 0.5, 0.2] + [0.0, 0.0, 1.0]
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    normals[0, 0] = [1.0, 0.0, 0.0]  # its frame has another heading
    mu = rng.uniform(0.1, 1.2, (size, most)) * (rng.uniform(size=(size, most)) > 0.1)
    counts = rng.integers(0, most + 1, size)
    return rng.normal(size=(size, most, 3)) * [0.3, 0.2, 0.05], normals, mu, counts


def assert_same(verdicts: Verdicts, k: int, other: Verdict) -> None:
    """The arrays say of the k-th what the single call does, and nothing beyond."""
    assert verdicts.status[k] == other.status
    assert verdicts.reach[k] == pytest.approx(other.reach, rel=1e-6)
    assert verdicts.margin[k] == pytest.approx(other.margin, rel=1e-9, abs=1e-9)
    count = len(other.stance.points())
    for a, b in (
        (verdicts.forces[k, :count], other.corner_forces),
        (verdicts.certificate[k], other.certificate),
    ):
        if b is None:
            assert np.isnan(a).all()
        else:
            assert a == pytest.approx(b, rel=1e-7, abs=1e-7)
    assert verdicts[k].verify() == other.verify()


def assert_same_region(region: Region, single: Region, slack: float, least: float) -> None:
    """Both are the same, up to a slack where one polygon is as far as it is from another."""
    assert (region.empty, region.converged) == (single.empty, single.converged)
    assert region.force_limit == single.force_limit
    for a, b in ((region, single), (single, region)):  # each inner polygon is within the other's outer one
        if len(a.inner) and len(b.directions):
            over = (b.directions @ a.inner.T - b.heights[:, None]).max()
            assert over <= slack * max(least, np.abs(b.heights).max())


def test_arrays_give_what_objects_give() -> None:
    rng = np.random.default_rng(0)
    positions, normals, mu, counts = arrays(rng, 300)
    com, mass = rng.normal(size=(300, 3)) * [0.1, 0.1, 0.05] + [0.0, 0.0, 0.3], rng.uniform(5.0, 50.0, 300)
    push = rng.normal(size=(300, 6)) * [20.0, 20.0, 20.0, 3.0, 3.0, 3.0]
    batch = sf.StanceBatch(positions, normals, mu, counts)
    verdicts = sf.can_stand_batch(batch, com, mass, push)
    seen = set()
    for k in range(300):
        feet = zip(positions[k], normals[k], mu[k], strict=True)
        stance = sf.Stance([sf.PointContact(p, n, m) for p, n, m in feet][: counts[k]])
        assert_same(verdicts, k, sf.can_stand(stance, com[k], float(mass[k]), push[k]))
        assert verdicts.feasible[k] == verdicts[k].feasible
        seen.add(verdicts.status[k])
    assert {"possible", "impossible"} <= seen
    assert np.isnan(verdicts.certificate[verdicts.feasible]).all()


def test_one_stance_among_many_is_that_stance_bit_by_bit() -> None:
    """The same compiled code, whatever lies beside it in the arrays."""
    rng = np.random.default_rng(1)
    stances = [random_case(rng, KINDS[k % len(KINDS)]).stance for k in range(60)]
    verdicts = sf.can_stand_batch(stances, [0.0, 0.0, 0.3], 20.0)
    for k in (0, 7, 31, 59):
        alone = sf.can_stand(stances[k], [0.0, 0.0, 0.3], 20.0)
        assert verdicts.status[k] == alone.status
        assert verdicts.margin[k] == alone.margin
        assert verdicts[k].forces is None or np.array_equal(verdicts[k].forces, alone.forces)


def test_patches_bounds_and_no_contacts_at_all() -> None:
    patch = sf.SoleContact([0.0, 0.0, 0.0], sf.Sole(0.2, 0.1, mu=0.5))
    bounded = sf.Stance([sf.PointContact(p, mu=0.6, normal_max=40.0) for p in FEET])
    stances = [sf.Stance([patch]), bounded, sf.Stance([]), sf.Stance([sf.PointContact(FEET[0], mu=1e6)])]
    for com in ([0.0, 0.0, 0.3], [0.09, 0.0, 0.3], [0.3, 0.0, 0.3]):
        verdicts = sf.can_stand_batch(stances, com, 15.0)
        assert len(verdicts) == 4
        for k, stance in enumerate(stances):
            assert_same(verdicts, k, sf.can_stand(stance, com, 15.0))


def test_no_stances() -> None:
    assert len(sf.can_stand_batch([], [0.0, 0.0, 0.3], 15.0)) == 0
    assert sf.com_region_batch([], 15.0) == []


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"com": [0.0, np.nan, 0.3]}, "com"),
        ({"com": np.zeros((3, 3))}, "com must have shape"),
        ({"mass": -1.0}, "mass must be positive"),
        ({"mass": [15.0, 0.0]}, "mass must be positive"),
        ({"external_wrench": np.zeros(5)}, "external_wrench must have shape"),
    ],
)
def test_wrong_input_is_named(change: dict, message: str) -> None:
    given = {"com": [0.0, 0.0, 0.3], "mass": 15.0} | change
    with pytest.raises(sf.ProblemError, match=message):
        sf.can_stand_batch(sf.StanceBatch(np.array([FEET, FEET])), **given)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"positions": FEET}, "positions must have shape"),
        ({"positions": [FEET], "normals": np.ones((4, 3))}, "normals must have shape"),
        ({"positions": [FEET], "normals": [0.0, 0.0, 2.0]}, "normal must have length 1"),
        ({"positions": [FEET], "mu": -0.1}, "mu must be >= 0"),
        ({"positions": [FEET], "mu": [0.1, 0.2]}, "mu must be a number"),
        ({"positions": [FEET], "counts": [5]}, "counts must be whole numbers"),
        ({"positions": [FEET], "counts": [1.5]}, "counts must be whole numbers"),
    ],
)
def test_wrong_arrays_are_named(arguments: dict, message: str) -> None:
    with pytest.raises(sf.ProblemError, match=message):
        sf.StanceBatch(**arguments)


def test_regions_are_those_of_the_single_calls() -> None:
    rng = np.random.default_rng(2)
    positions, normals, mu, counts = arrays(rng, 80)
    batch = sf.StanceBatch(positions, normals, mu, counts)
    masses = rng.uniform(5.0, 50.0, 80)
    regions, areas = sf.com_region_batch(batch, masses), []
    for k, region in enumerate(regions):
        single = sf.com_region(batch[k], float(masses[k]))
        assert region.height == pytest.approx(single.height)
        assert_same_region(region, single, 1e-8, 1.0)
        areas.append(region.area)
    assert sum(area > 0.0 for area in areas) > 20


def test_regions_of_objects_at_a_height_and_with_patches() -> None:
    stances = [
        sf.Stance([sf.SoleContact([0.1, 0.0, 0.0], sf.Sole(0.2, 0.1)), sf.PointContact([-0.2, 0.1, 0.1])]),
        sf.Stance([sf.PointContact(p, normal_max=60.0) for p in FEET]),
        sf.Stance([]),
    ]
    for region, stance in zip(sf.com_region_batch(stances, 15.0, height=0.5), stances, strict=True):
        single = sf.com_region(stance, 15.0, height=0.5)
        assert region.area == pytest.approx(single.area, abs=1e-6)
        assert region.height == single.height == 0.5
