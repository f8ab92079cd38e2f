"""Friction from a log whose ground changes, and from slides whose friction is known."""

from __future__ import annotations

import numpy as np
import pytest

import surefoot as sf
from surefoot.records.audit import FrictionInterval

DT, WEIGHT = 1e-3, 100.0


def made(parts: list[tuple[float, float, float]], noise: float = 0.0, dt: float = DT) -> sf.Log:
    """Return the log of one foot: (duration, friction used, speed) one after the other."""
    rng = np.random.default_rng(5)
    used = np.concatenate([np.full(round(t / dt), mu) for t, mu, _ in parts])
    speed = np.concatenate([np.full(round(t / dt), v) for t, _, v in parts])
    used = used * (1.0 + noise * rng.normal(size=len(used)))
    rows = len(used)
    forces, velocities = np.zeros((rows, 1, 3)), np.zeros((rows, 1, 3))
    forces[:, 0, 2] = WEIGHT
    forces[:, 0, 0] = -used * WEIGHT
    velocities[:, 0, 0] = speed
    arrays = {
        "time": np.arange(rows) * dt, "forces": forces, "contact_velocities": velocities,
        "gaps": np.zeros((rows, 1)), "mu": np.full(rows, 2.0),
    }  # fmt: skip
    return sf.Log(arrays, {"mass": WEIGHT / 9.81, "dt": dt, "feet": ["foot"], "contact_foot": [0]})


def intervals(log: sf.Log) -> tuple[FrictionInterval, ...]:
    return sf.audit_log(log).friction


def test_one_ground_is_one_interval() -> None:
    (one,) = intervals(made([(1.0, 0.3, 0.0), (0.3, 0.6, 0.2), (0.7, 0.4, 0.0)], noise=0.01))
    assert one.low == pytest.approx(0.6, rel=0.05)
    assert one.high == pytest.approx(0.6, rel=0.02)
    assert (one.start, one.end) == (0.0, pytest.approx(1.999))
    assert one.slid == pytest.approx(0.3)


@pytest.mark.parametrize("noise", [0.0, 0.01])
def test_ice_begins_an_interval_of_its_own(noise: float) -> None:
    log = made([(0.53, 0.55, 0.0), (0.6, 0.15, 0.3), (0.5, 0.1, 0.0)], noise)
    dry, ice = intervals(log)
    assert (dry.low, dry.high) == (pytest.approx(0.55, rel=0.04), np.inf)
    assert (ice.low, ice.high) == (pytest.approx(0.15, rel=0.04), pytest.approx(0.15, rel=0.04))
    assert dry.end == pytest.approx(0.53, abs=0.11)
    assert ice.start == pytest.approx(0.53, abs=0.11)
    assert any("friction under foot falls at" in note for note in sf.audit_log(log).notes)


def test_friction_that_comes_back_is_told() -> None:
    three = intervals(made([(0.5, 0.6, 0.2), (0.5, 0.2, 0.2), (0.5, 0.6, 0.0)]))
    assert [round(i.low, 2) for i in three] == [0.6, 0.2, 0.6]
    assert [round(i.high, 2) for i in three] == [0.6, 0.2, np.inf]
    notes = " ".join(sf.audit_log(made([(0.5, 0.2, 0.2), (0.5, 0.6, 0.0)])).notes)
    assert "friction under foot rises at 0.50 s: 0.20 before, at least 0.60 after" in notes


def test_a_row_or_a_short_slide_changes_nothing() -> None:
    assert len(intervals(made([(0.5, 0.3, 0.2), (0.003, 0.9, 0.0), (0.5, 0.3, 0.2)]))) == 1
    assert len(intervals(made([(0.5, 0.6, 0.0), (0.01, 0.2, 0.3), (0.5, 0.6, 0.0)]))) == 1


def test_noise_alone_changes_nothing() -> None:
    parts = [(0.2, 0.5, 0.2 * (k % 2)) for k in range(40)]
    assert len(intervals(made(parts, noise=0.03))) == 1


def test_the_number_of_changes_is_bounded() -> None:
    parts = [(0.2, 0.2 + 0.4 * (k % 2), 0.2) for k in range(140)]
    assert len(intervals(made(parts))) <= 51


@pytest.mark.parametrize("dt", [0.0005, 0.005, 0.02])
def test_other_rates(dt: float) -> None:
    found = intervals(made([(1.0, 0.6, 0.2), (1.0, 0.2, 0.2)], dt=dt))
    assert [round(i.high, 1) for i in found] == [0.6, 0.2]


def test_contacts_with_frictions_of_their_own_are_judged_by_them() -> None:
    log = made([(0.5, 0.5, 0.0)])
    arrays = {name: np.repeat(a, 2, axis=1) if a.ndim > 1 else a for name, a in log.arrays.items()}
    del arrays["mu"]
    arrays["contact_friction"] = np.tile([0.6, 0.4], (500, 1))
    facts = {"mass": 20.4, "feet": ["dry", "wet"], "contact_foot": [0, 1]}
    report = sf.audit_log(sf.Log(arrays, facts))
    assert {v.contact for v in report.violations if v.law == "friction"} == {"wet"}
    assert report.coverage["friction"] == ""
    lawful = sf.Log({**arrays, "contact_friction": np.full((500, 2), 0.6)}, facts)
    assert sf.audit_log(lawful).lawful
