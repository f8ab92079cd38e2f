"""Many environments at once say what each says alone; wrong shapes are one line."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.arrays import FloatArray
from surefoot.records.audit.batch.batch_report import BatchReport
from surefoot.records.audit.batch.side_by_side import SIDE_BY_SIDE
from surefoot.records.audit.report import AuditReport

from .environments import ROWS, soft_facts, spoil_one, windows

LAWS = {check.name for check in SIDE_BY_SIDE if check.law}
DT = 0.002


def _alone(
    arrays: dict[str, FloatArray], k: int, mass: float, mu: float, facts: dict[str, Any]
) -> AuditReport:
    mine = {name: array[:, k] for name, array in arrays.items()}
    with np.errstate(over="ignore"):
        return sf.audit_log(sf.log_from_arrays(mine, dt=DT, facts={**facts, "mass": mass, "mu": mu}))


def _assert_same(report: BatchReport, k: int, one: AuditReport, what: str) -> None:
    """Verdict, reason, the laws that are broken, and where the worst of each lies."""
    assert report.verdicts[k] == one.verdict, what
    assert {law for law in LAWS if report[law].share[k] > 0.0} == {*one.laws_broken} - {"finite"}, what
    for law in {*one.laws_broken} - {"finite"}:
        found, mine = report[law], [v for v in one.violations if v.law == law]
        rows = sum(round((v.end - v.start) / DT) for v in mine)
        assert found.share[k] * ROWS <= rows + 1e-6, (what, law)
        contact = f"contact {found.contact[k]}"
        at = [v for v in mine if v.start - 1e-9 <= found.instant[k] <= v.end + 1e-9 and v.contact == contact]
        assert at, (what, law)
        # an interval tells its highest measure, the batch what exceeds its own limit by most
        most = max(v.value - v.limit for v in at)
        assert found.worst[k] - found.limit[k] >= most * (1.0 - 1e-9) - 1e-12, (what, law)


@pytest.mark.parametrize("placed", [False, True], ids=["forces", "places"])
@pytest.mark.parametrize("facts", [soft_facts, dict, lambda: {**soft_facts(), "terrain": "flat"}])
def test_each_environment_is_judged_as_alone(placed: bool, facts: Any) -> None:
    """Forty windows of runs, spoilt in twelve ways, masses from 0.2 to 5 of a Go2's."""
    arrays, masses, mu = windows(40, 1, placed)
    rng = np.random.default_rng(2)
    kinds = [spoil_one(arrays, k, rng) for k in range(40)]
    assert len({*kinds}) == 12
    report = sf.audit_batch(arrays, DT, mu, mass=masses, facts=facts())
    assert len({*report.verdicts}) == 3
    for k, kind in enumerate(kinds):
        _assert_same(report, k, _alone(arrays, k, masses[k], mu[k], facts()), f"{k}: {kind}")
        if kind == "lost":
            assert report.verdicts[k] != "lawful"


def test_an_environment_does_not_depend_on_its_neighbours() -> None:
    """Alone, in another order, in blocks of another size, on one thread: the same figures."""
    arrays, masses, mu = windows(30, 3)
    rng = np.random.default_rng(4)
    for k in range(30):
        spoil_one(arrays, k, rng)
    whole = sf.audit_batch(arrays, DT, mu, mass=masses)
    order = rng.permutation(30)
    mixed = sf.audit_batch(
        {name: array[:, order] for name, array in arrays.items()},
        DT,
        mu[order],
        mass=masses[order],
        threads=1,
    )
    for law, found in whole.laws.items():
        for name in ("share", "worst", "limit", "instant"):
            np.testing.assert_allclose(
                getattr(mixed[law], name), getattr(found, name)[order], rtol=1e-9, err_msg=f"{law} {name}"
            )
    assert mixed.verdicts == tuple(whole.verdicts[k] for k in order)


def test_units_scale_with_the_weight() -> None:
    """Masses and forces times a thousand: the same shares, forces and energies times a thousand."""
    arrays, masses, mu = windows(12, 5)
    rng = np.random.default_rng(6)
    for k in range(12):
        if spoil_one(arrays, k, rng) in ("lost", "huge"):
            arrays["forces"][:, k] = np.nan_to_num(np.minimum(arrays["forces"][:, k], 1e3))
    one = sf.audit_batch(arrays, DT, mu, mass=masses)
    big = sf.audit_batch({**arrays, "forces": 1e3 * arrays["forces"]}, DT, mu, mass=1e3 * masses)
    assert one.verdicts == big.verdicts
    for law, found in one.laws.items():
        scale = 1e3 if found.unit in ("N", "J") else 1.0
        np.testing.assert_array_equal(big[law].share, found.share)
        np.testing.assert_allclose(big[law].worst, scale * found.worst, rtol=1e-6, atol=1e-12)


def test_no_law_reaches_across_the_end_of_an_episode() -> None:
    """Two windows joined as episodes, at another row in each environment: as each episode alone."""
    arrays, masses, mu = windows(8, 7)
    other, _, _ = windows(8, 8)
    other["forces"] *= (
        masses[None, :, None, None]
        * 9.81
        / np.maximum(other["forces"][..., 2].sum(axis=2).mean(axis=0), 1.0)[None, :, None, None]
    )
    joined = {name: np.concatenate([array, other[name]]) for name, array in arrays.items()}
    done = np.zeros((2 * ROWS, 8), dtype=bool)
    done[ROWS - 1] = True
    report = sf.audit_batch(joined, DT, mu, mass=masses, done=done)
    assert report.episodes == 16
    for k in range(8):
        log = report.log(k)
        assert len(log.episodes) == 2
        one = sf.audit_log(log)
        assert report.verdicts[k] == one.verdict
        assert {law for law in LAWS if report[law].share[k] > 0.0} == {*one.laws_broken}
    ends = np.zeros((2 * ROWS, 8), dtype=bool)
    for k in range(8):
        ends[40 + 17 * k, k] = True
    assert sf.audit_batch(joined, DT, mu, mass=masses, done=ends).episodes == 16


def test_exploits_and_the_reward_that_came_from_them() -> None:
    """Half of the rows of one of four environments glide, and half of the reward is that environment's."""
    arrays, masses, mu = windows(4, 9)
    arrays["forces"][100:220, 2, :, :2] *= 20.0
    reward = np.ones((ROWS, 4))
    reward[:, :2] = 0.0
    report = sf.audit_batch(arrays, DT, mu, mass=masses, facts=soft_facts(), reward=reward)
    named = {one.name: one for one in report.exploits}
    cone = named["friction beyond the cone"]
    assert cone.worst == 2
    assert 0.2 <= cone.instant < 0.44
    assert cone.environments == 0.25
    assert cone.reward == pytest.approx(report["friction"].share[2] / 2.0)
    assert report.worst("friction").tolist() == [2]
    assert report.audit(2).laws_broken[0] in LAWS
    assert len(str(report)) < 400
    assert "broken" in repr(report)


def test_the_environment_that_breaks_a_law_most_comes_first() -> None:
    arrays, masses, mu = windows(4, 9)
    for environment, rows in ((1, 30), (3, 120)):
        forces = arrays["forces"][100 : 100 + rows, environment]
        forces[..., 0] = 2.0 * forces[..., 2]
    report = sf.audit_batch(arrays, DT, mu, mass=masses, facts=soft_facts())
    assert report.worst("friction").tolist() == [3, 1]
    assert report.worst("friction", 1).tolist() == [3]


@pytest.mark.parametrize("seed", range(8))
def test_random_rows_of_any_size_are_judged_as_alone(seed: int) -> None:
    """Few rows, forces from 1e-6 to 1e206 N, gaps and speeds without end, no friction or any: no warning."""
    rng = np.random.default_rng(9000 + seed)
    T, N, points, scale = int(rng.integers(2, 400)), 4, int(rng.integers(1, 5)), 10.0 ** rng.uniform(-6, 6)
    forces, velocities = rng.normal(size=(2, T, N, points, 3))
    forces[..., 2] = np.abs(forces[..., 2])
    gaps = rng.normal(size=(T, N, points)) * 10.0 ** rng.uniform(-9, 0)
    gaps[:, 0], forces[:, 1] = np.where(rng.random((T, points)) < 0.5, np.inf, 0.0), 0.0
    forces *= np.where(np.arange(N) == 2, 1e200, 1.0)[:, None, None] * scale
    velocities[T // 2, 3] = np.inf if seed % 2 else np.nan
    arrays = {"forces": forces, "gaps": gaps, "contact_velocities": velocities}
    masses, mu = scale * rng.uniform(0.01, 0.5, size=N), rng.choice([0.0, 0.3, 1e9], size=N)
    report = sf.audit_batch(arrays, DT, mu, mass=masses)
    for k in range(N):
        one = _alone(arrays, k, masses[k], mu[k], {})
        assert report.verdicts[k] == one.verdict
        assert {law for law in LAWS if report[law].share[k] > 0.0} == {*one.laws_broken} - {"finite"}


def test_without_masses_nothing_is_lawful() -> None:
    """What is broken is broken at any mass; the rest cannot be told."""
    arrays, _, mu = windows(6, 10)
    arrays["gaps"][50:90, 3] -= 0.05
    report = sf.audit_batch(arrays, DT, mu)
    assert report.verdicts[3] == "broken"
    assert "lawful" not in report.verdicts
    assert "masses" in next(reason for reason in report.reasons if reason)


def test_forces_alone_are_judged_as_far_as_they_go() -> None:
    """The missing laws are named, and no environment is lawful."""
    arrays, masses, mu = windows(3, 11)
    report = sf.audit_batch({"forces": arrays["forces"]}, DT, mu, mass=masses)
    assert {*report.verdicts} <= {"cannot tell", "broken"}
    assert "gaps" in report.coverage["distance"]
    assert np.isnan(report["distance"].worst).all()


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda a: a.update(forces=a["forces"][:, 0]), "audit_log takes one environment's log"),
        (lambda a: a.update(gaps=a["gaps"][:, :, :3]), r"gaps must have shape \(240, 5, 4\)"),
        (lambda a: a.update(speeds=a["gaps"]), "speeds"),
        (lambda a: a.update(velocities=a["contact_velocities"]), "two arrays are the channel"),
        (lambda a: a.pop("forces"), "must have forces"),
        (lambda a: a.update(gaps=a["gaps"].astype(str)), "gaps must hold real numbers"),
        (lambda a: a.update(mu=np.ones(240)), "mu"),
    ],
)
def test_what_does_not_fit_is_one_line(change: Any, told: str) -> None:
    """Each names the array, and what was expected."""
    arrays, masses, mu = windows(5, 12)
    change(arrays)
    with pytest.raises(sf.SurefootError, match=told):
        sf.audit_batch(arrays, DT, None if "mu" in arrays else mu, mass=masses)


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"mass": [1.0, 2.0]}, "5 environments"),
        ({"mass": -1.0}, "positive"),
        ({"mu": np.ones((3, 3))}, r"\(240, 5\)"),
        ({"done": np.zeros((5, 240))}, "last row of an episode"),
        ({"reward": np.zeros(240)}, "reward must have shape"),
        ({"dt": 0.0}, "dt"),
        ({"threads": 0}, "threads"),
        ({"facts": 3}, "facts"),
    ],
)
def test_wrong_options_are_one_line(options: dict[str, Any], told: str) -> None:
    """Each names the value, and what was expected."""
    arrays, masses, mu = windows(5, 12)
    with pytest.raises(sf.SurefootError, match=told):
        sf.audit_batch(arrays, **{"dt": DT, "mu": mu, "mass": masses, **options})


def test_a_report_knows_its_laws_and_environments() -> None:
    """Names and numbers that are none are one line."""
    arrays, masses, mu = windows(2, 13)
    report = sf.audit_batch(arrays, DT, mu, mass=masses)
    with pytest.raises(sf.SurefootError, match="frction"):
        report["frction"]
    with pytest.raises(sf.SurefootError, match="below 2"):
        report.log(2)
    light = report.without_rows()
    with pytest.raises(sf.SurefootError, match="rows are kept of"):
        light.log(1)


@pytest.mark.parametrize("framework", ["jax", "torch"])
def test_arrays_of_frameworks_are_judged_as_numpys(framework: str) -> None:
    """Sixteen spoilt windows in float64: the same verdicts and figures."""
    module = pytest.importorskip(framework)
    arrays, masses, mu = windows(16, 31)
    rng = np.random.default_rng(32)
    for k in range(16):
        spoil_one(arrays, k, rng)
    expected = sf.audit_batch(arrays, DT, mu, mass=masses, facts=soft_facts(), reward=np.ones((ROWS, 16)))

    def judged() -> BatchReport:
        make = module.numpy.asarray if framework == "jax" else module.as_tensor
        given = {name: make(array) for name, array in arrays.items()}
        assert all(str(array.dtype).endswith("float64") for array in given.values())
        return sf.audit_batch(
            given, DT, make(mu), mass=make(masses), facts=soft_facts(), reward=make(np.ones((ROWS, 16)))
        )

    if framework == "jax":
        with module.enable_x64(True):
            found = judged()
    else:
        found = judged()
    assert found.verdicts == expected.verdicts
    assert "broken" in found.verdicts
    assert found.exploits == expected.exploits
    for name, law in expected.laws.items():
        for part in ("share", "worst", "limit", "instant", "contact"):
            np.testing.assert_array_equal(getattr(found[name], part), getattr(law, part), err_msg=name)
