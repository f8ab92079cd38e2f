from __future__ import annotations

import json
import math
import tracemalloc
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest

from surefoot.base.errors import ProblemError
from surefoot.base.spatial import GRAVITY
from surefoot.records.audit import LawFigures, audit_log, contact_use, log_laws
from surefoot.records.audit.laws import LAWS
from surefoot.records.audit.limits import LIMITS
from surefoot.records.log import CHANNELS, Log
from surefoot.records.log.channels import SCHEMA
from surefoot.records.log.reading import read_log
from tests.records.audit.logs import check_laws

WEIGHT = 100.0


def still(
    force: list[float], gap: float = 0.0, velocity: tuple[float, ...] = (0.0, 0.0, 0.0), mu: float = 0.5
):
    return check_laws([[force]], [[gap]], [[velocity]], [mu], WEIGHT)


def slide(force: list[float], speed: float, duration: float, dt: float = 1e-3, mu: float = 0.5) -> LawFigures:
    """One contact that slides along x under a constant force; its first row is a touchdown's."""
    T = round(duration / dt) + 1
    return check_laws(
        np.tile(force, (T, 1, 1)), np.zeros((T, 1)), np.tile([speed, 0.0, 0.0], (T, 1, 1)), mu, WEIGHT, dt
    )


def test_a_lawful_contact_breaks_nothing() -> None:
    laws = still([10.0, 0.0, 50.0], gap=-1e-5)
    assert laws.broken(WEIGHT) == []
    assert laws.cone_use_max == pytest.approx(0.4)
    assert laws.penetration_max == pytest.approx(1e-5)


@pytest.mark.parametrize(
    ("force", "gap", "said"),
    [
        ([0.0, 0.0, 50.0], -5e-3, "penetration of 5.00 mm"),
        ([0.0, 0.0, -1.0], 0.0, "a pull of 1 N"),
        ([30.0, 0.0, 50.0], 0.0, "1.200 times the friction"),
        ([0.0, 0.0, 50.0], 0.01, "a force 10.00 mm off the ground"),
        ([0.0, 0.0, 10.0], 2e-3, "a force 2.00 mm off the ground"),
        ([5.0, 0.0, 0.0], 0.0, "times the friction"),  # friction without a normal force
    ],
)
def test_each_broken_law_is_named(force: list[float], gap: float, said: str) -> None:
    assert any(said in line for line in still(force, gap).broken(WEIGHT))


def test_dissipation_compares_friction_with_the_slip() -> None:
    assert still([-25.0, 0.0, 50.0], velocity=(0.3, 0.0, 0.0)).dissipation_max == pytest.approx(
        0.0, abs=1e-12
    )
    # friction at a right angle to the slip dissipates nothing: all of mu f_n is missing
    assert still([0.0, 25.0, 50.0], velocity=(0.3, 0.0, 0.0)).dissipation_max == pytest.approx(0.25)
    assert still([0.0, 25.0, 50.0], velocity=(1e-3, 0.0, 0.0)).dissipation_max == 0.0  # sticks


def test_a_slide_without_friction_is_as_long_as_its_way() -> None:
    lawful = slide([-25.0, 0.0, 50.0], 0.3, 1.0)
    assert lawful.judged == LAWS
    assert lawful.free_slide_max == 0.0
    assert lawful.broken(WEIGHT) == []
    # no friction, friction across, two fifths of it, and friction that drives; a lag of it is forgiven
    for force, missing in ((0.0, 0.0), 1.0), ((0.0, -25.0), 1.0), ((-10.0, 0.0), 0.6), ((25.0, 0.0), 2.0):
        laws = slide([*force, 50.0], 0.3, 0.1)
        assert laws.free_slide_max == pytest.approx((missing - LIMITS.laws.lag) * 0.03, rel=1e-9)
        assert any("without friction" in line for line in laws.broken(WEIGHT))
    assert slide([-24.0, 0.0, 50.0], 0.3, 10.0).broken(WEIGHT) == []  # within the lag, however long


def test_a_heavy_blow_does_not_excuse_a_slide() -> None:
    """The way is the missing work over the greatest friction, which counts as m g at most."""
    T = 101
    f, v = np.tile([0.0, 0.0, 50.0], (T, 1, 1)), np.tile([0.3, 0.0, 0.0], (T, 1, 1))
    f[1, 0] = [-0.5e5, 0.0, 1e5]
    laws = check_laws(f, np.zeros((T, 1)), v, 0.5, WEIGHT, 1e-3)
    assert laws.free_slide_max == pytest.approx((1.0 - LIMITS.laws.lag) * 25.0 * 0.0297 / WEIGHT, rel=1e-6)


def test_a_creep_counts_however_slow_and_a_shake_however_long_does_not() -> None:
    """5 mm of way at 1 mm/s without friction; and 60 s of shaking by 20 micrometres at 50 Hz."""
    creep = slide([0.0, 0.0, 50.0], 1e-3, 5.0, dt=5e-3)
    assert creep.free_slide_max == pytest.approx((1.0 - LIMITS.laws.lag) * 5e-3)
    dt = 1e-3
    t = dt * np.arange(60_000)
    speed = 2e-5 * 2.0 * np.pi * 50.0 * np.cos(2.0 * np.pi * 50.0 * t)
    v = np.zeros((len(t), 1, 3))
    v[:, 0, 0] = speed
    f = np.tile([0.0, 0.0, 50.0], (len(t), 1, 1))
    laws = check_laws(f, np.zeros((len(t), 1)), v, 0.5, WEIGHT, dt)
    assert np.abs(speed).sum() * dt > 0.2  # the way back and forth is long
    assert laws.free_slide_max < 1e-4
    assert laws.broken(WEIGHT) == []


def test_a_foot_stopped_within_a_regularised_touchdown_is_lawful() -> None:
    """Friction that takes 0.3 m/s away with a time constant of 2 ms: the way is v tau at most."""
    dt, tau, v0, normal = 1e-4, 2e-3, 0.3, 50.0
    t = dt * np.arange(1000)
    v = np.zeros((1000, 1, 3))
    v[:, 0, 0] = v0 * np.exp(-t / tau)
    f = np.zeros((1000, 1, 3))
    f[:, 0, 2] = normal
    f[:, 0, 0] = -0.1 * v[:, 0, 0] / tau  # a tenth of a kilogram is stopped, with 15 N at first
    laws = check_laws(f, np.zeros((1000, 1)), v, 0.5, WEIGHT, dt)
    assert 0.2 * v0 * tau < laws.free_slide_max <= 1.05 * v0 * tau
    assert laws.broken(WEIGHT) == []


def test_a_stance_survives_a_bounce_and_ends_with_a_lift() -> None:
    """Way is added up over gaps shorter than 20 ms; a foot in the air for longer starts anew."""
    T = 400
    v, f = np.tile([0.02, 0.0, 0.0], (T, 1, 1)), np.tile([0.0, 0.0, 50.0], (T, 1, 1))
    whole = check_laws(f, np.zeros((T, 1)), v, 0.5, WEIGHT, 1e-3).free_slide_max
    bouncing, lifted = f.copy(), f.copy()
    bouncing[5::10] = 0.0
    lifted[190:215] = 0.0
    assert check_laws(bouncing, np.zeros((T, 1)), v, 0.5, WEIGHT, 1e-3).free_slide_max == pytest.approx(
        0.9 * whole, rel=2e-2
    )
    assert check_laws(lifted, np.zeros((T, 1)), v, 0.5, WEIGHT, 1e-3).free_slide_max == pytest.approx(
        190 / 400 * whole, rel=2e-2
    )


def test_cone_use_allows_unloaded_contacts_noise_and_knows_ice() -> None:
    forces = np.array([[[0.01, 0.0, 0.05], [3.0, 4.0, 20.0], [0.0, 0.0, 0.0]]])
    np.testing.assert_allclose(contact_use(forces, np.array([0.5]), 0.1), [[0.2, 0.5, 0.0]])
    np.testing.assert_allclose(
        contact_use(forces, np.array([0.0]), 0.1)[0, 1], 5.0 / (20.0 * LIMITS.laws.least_friction)
    )


def test_friction_may_differ_from_contact_to_contact() -> None:
    f, gap, v = np.tile([10.0, 0.0, 50.0], (3, 2, 1)), np.zeros((3, 2)), np.zeros((3, 2, 3))
    mu = np.full((3, 2), 0.5)
    mu[1, 1] = 0.1
    assert check_laws(f, gap, v, mu, WEIGHT).cone_use_max == pytest.approx(2.0)


def test_what_is_no_friction_or_weight_is_refused() -> None:
    for mu in (-0.1, [0.5, 0.5, -2.0]):
        with pytest.raises(ProblemError, match="mu must be >= 0, got -"):
            check_laws(np.zeros((3, 2, 3)), np.zeros((3, 2)), np.zeros((3, 2, 3)), mu, WEIGHT)
    for weight in (math.nan, math.inf, 0.0, -5.0):
        with pytest.raises(ProblemError, match="weight"):
            still([10.0, 0.0, 50.0]).broken(weight)


def test_no_contacts_at_all_is_no_verdict() -> None:
    laws = check_laws(np.zeros((0, 4, 3)), np.zeros((0, 4)), np.zeros((0, 4, 3)), np.zeros(0), WEIGHT, 1e-3)
    assert laws.broken(WEIGHT) == []
    assert laws.judged == ()


@pytest.mark.parametrize("spoilt", [None, "forces", "gaps", "contact_velocities", "large"])
@pytest.mark.parametrize("rows", [1, 7, 100, 999, 5000])
def test_a_log_in_pieces_is_judged_as_a_whole(
    rows: int, spoilt: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Every figure to the last bit, wherever the log is cut, and where something in it is not finite."""
    rng = np.random.default_rng(11)
    T, p, dt = 1000, 4, 1e-3
    arrays = {
        "time": dt * np.arange(T),
        "forces": rng.normal(size=(T, p, 3)) * 20.0,
        "gaps": 1e-4 * rng.normal(size=(T, p)),
        "contact_velocities": 0.2 * rng.normal(size=(T, p, 3)),
        "mu": rng.uniform(0.1, 1.0, T),
    }
    arrays["forces"][..., 2] = np.where(rng.uniform(size=(T, p)) < 0.9, 40.0, -0.01)
    if spoilt == "large":
        arrays["contact_velocities"][400:700, 1] = 1e306
        arrays["forces"][400:700, 1] = 1e5
    elif spoilt is not None:
        arrays[spoilt][[3, 500, 900], 2] = np.nan
    log = Log(arrays, {"mass": WEIGHT / GRAVITY, "dt": dt})
    whole = log_laws(log)
    chunks = Log.chunks
    monkeypatch.setattr(Log, "chunks", lambda self: chunks(self, rows))
    np.testing.assert_equal(asdict(log_laws(log)), asdict(whole))
    assert bool(whole.not_finite) == (spoilt is not None)
    if spoilt == "forces":
        assert whole.not_finite[0] == "forces not finite in 9 places, first in row 3 at contact 2"


def test_a_log_longer_than_memory_is_judged_in_bounded_memory(tmp_path: Path) -> None:
    T, p = 400_000, 4
    rng = np.random.default_rng(0)
    shapes = {"forces": (T, p, 3), "gaps": (T, p), "contact_velocities": (T, p, 3), "mu": (T,), "time": (T,)}
    for name, shape in shapes.items():
        mapped = np.lib.format.open_memmap(tmp_path / f"{name}.npy", "w+", np.float64, shape)
        mapped[:] = 0.5
        mapped[:1000] = rng.uniform(0.0, 1e-4, (1000, *shape[1:]))
    channels = [asdict(CHANNELS[name]) for name in shapes]
    told = {"schema": SCHEMA, "channels": channels, "facts": {"mass": 16.0, "dt": 0.001}}
    (tmp_path / "facts.json").write_text(json.dumps(told))
    log = read_log(tmp_path)
    size = sum(array.nbytes for array in log.arrays.values())
    tracemalloc.start()
    try:
        laws = log_laws(log)
        assert tracemalloc.get_traced_memory()[1] < 0.5 * size
    finally:
        tracemalloc.stop()
    assert laws.separation_max == 0.5


def test_a_hard_landing_is_judged_as_the_audit_judges_it() -> None:
    """Lawful at 8 m g within the declared depth, and beyond it while it swings, and by the way of its row."""
    for depth, lawful in ((0.9e-3, True), (1.5e-3, True), (2.8e-3, False)):
        T = 200
        f, gaps, v = np.zeros((T, 1, 3)), np.full((T, 1), -1e-5), np.zeros((T, 1, 3))
        f[:, 0, 2], v[50, 0, 2], gaps[51, 0] = WEIGHT, -1.0, -depth
        f[51, 0, 2] = 8.0 * WEIGHT
        facts = {"mass": WEIGHT / GRAVITY, "dt": 1e-3, "sinking": 1e-3, "settling": 0.02, "feet": ["F"]}
        facts |= {"contact_foot": np.array([0])}
        arrays = {"forces": f, "gaps": gaps, "contact_velocities": v, "mu": np.full(T, 0.6)}
        log = Log(arrays | {"time": 1e-3 * np.arange(T)}, facts)
        assert (log_laws(log).broken(WEIGHT) == []) is lawful
        depths = [v for v in audit_log(log).violations if v.law == "penetration"]
        assert (not depths) is lawful
