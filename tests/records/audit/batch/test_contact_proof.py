"""A proof that rows break no law never holds where the audit's own functions find one that is broken."""

from __future__ import annotations

import math

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.arrays import FloatArray
from surefoot.records import ContactProof, ContactRows, ContactWorld, judge_contacts

from .environments import soft_facts, spoil_one, windows

DT = 0.002
DAMPING = 200.0
"""Rate at which soft friction brakes [1/s]."""
COLUMNS = np.array([0, 3, 6, 7, -1, 8])


def _proof(
    arrays: dict[str, FloatArray], k: int, mass: float, mu: float, settling: float, damped: bool = False,
    margin: float = 0.0,
) -> ContactProof:  # fmt: skip
    f, v, gaps = (np.asarray(arrays[n][:, k]) for n in ("forces", "contact_velocities", "gaps"))
    friction, creep = np.full((*gaps.shape, 1), mu), np.zeros((*gaps.shape, 1))
    table = np.ascontiguousarray(np.concatenate([f, v, gaps[..., None], friction, creep], axis=2))
    times = np.stack([DT * np.arange(len(f)), np.full(len(f), DT)], axis=1)
    points = f.shape[1]
    damping, margins = np.full(points, DAMPING), np.full(points, margin)
    rows = ContactRows(table, np.arange(f.shape[1]), COLUMNS, times)
    damps = np.full(points, float(damped))
    return ContactProof(rows, ContactWorld(damping, damps, margins, mass, 9.81, settling, math.inf, True))


@pytest.mark.parametrize(("damped", "margin"), [(False, 0.0), (True, 0.0), (True, 0.002)])
@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.sampled(2)
def test_no_spoilt_window_is_proven(seed: int, damped: bool, margin: float) -> None:
    """Of 60 windows of walks, two thirds of them spoilt in twelve ways; most of the lawful are proven."""
    rng, facts = np.random.default_rng(seed), soft_facts()
    arrays, masses, mu = windows(60, seed)
    proven = lawful = partly = 0
    for k in range(60):
        if k % 3:
            spoil_one(arrays, k, rng)
        mine = {name: array[:, k] for name, array in arrays.items()}
        told = {**facts, "mass": masses[k], "mu": mu[k], "velocities": "mean"}
        mine["contact_creep"] = np.zeros_like(mine["gaps"])
        points = mine["gaps"].shape[1]
        told["contact_damping"] = np.full(points, DAMPING)
        told["critically_damped"] = np.full(points, float(damped))
        told |= {"contact_margin": np.full(points, margin)} if margin else {}
        with np.errstate(over="ignore"):
            judged = judge_contacts(sf.log_from_arrays(mine, dt=DT, facts=told))
            proof = _proof(arrays, k, masses[k], mu[k], facts["settling"], damped, margin)
            report = proof.report(facts["sinking"], facts["creep"], facts["stopping"])
        broken = {law.name for law in judged.laws.values() if law.law and law.share[0] > 0.0}
        lawful += judged.verdicts[0] == "lawful"
        if report is not None:
            proven += 1
            assert not broken, (k, broken)
            assert judged.verdicts[0] == "lawful"
        else:
            partly += bool(proof.held)
            assert not broken & proof.held, (k, broken)
    assert proven > 0.5 * lawful > 5
    assert partly > 5


def test_numbers_that_are_not_finite_prove_nothing() -> None:
    """One NaN in any column is enough."""
    arrays, masses, mu = windows(1, 7)
    facts = soft_facts()
    for name in arrays:
        changed = {n: array.copy() for n, array in arrays.items()}
        changed[name][100, 0, 2] = np.nan
        proof = _proof(changed, 0, masses[0], mu[0], facts["settling"])
        assert proof.report(facts["sinking"], facts["creep"], facts["stopping"]) is None
        assert not proof.held
