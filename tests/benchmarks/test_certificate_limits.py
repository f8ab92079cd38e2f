"""Settings of certificates are varied over motions of a known truth; a looser verdict scores worse."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import surefoot as sf
from benchmarks.certificate_limits import (
    Case,
    certificate_score,
    motor_cases,
    repair_score,
    retarget,
    vary_setting,
)
from benchmarks.certify.repair_cases import rising_motion
from benchmarks.limit_choice import Choice
from surefoot.base.settings import describe
from surefoot.records.certificates.certificate_settings import CertificateSettings
from surefoot.records.repairs.repair_settings import RepairSettings

SETTINGS = {one.name: one for one in describe(CertificateSettings())}


@pytest.fixture(scope="module")
def cases() -> list[Case]:
    rising = rising_motion(sf.load_robot("g1"))
    high = rising.q.copy()
    high[:, 2] += 0.05
    hanging = Case("hanging", replace(rising, q=high), np.ones(len(high), dtype=np.bool_))
    return [Case("as retargeted", retarget(rising)), hanging, *motor_cases(rising)]


def test_cases_are_judged_rightly_and_a_looser_certificate_scores_worse(cases: list[Case]) -> None:
    lawful, spoilt = ([c for c in cases if (c.spoilt is None) == one] for one in (True, False))
    own = certificate_score(lawful, spoilt, CertificateSettings())
    assert own > 0.9
    assert certificate_score(lawful, spoilt, CertificateSettings(clearance=0.1)) < own - 0.1
    assert certificate_score(lawful, spoilt, CertificateSettings(clearance=0.001)) < own - 0.1
    assert certificate_score(lawful, spoilt, CertificateSettings(at_stop=1e-4)) < own - 0.1


def test_a_setting_is_decided_where_another_value_does_worse() -> None:
    found = vary_setting(SETTINGS["stick"], CertificateSettings(), lambda s: -abs(s.stick - 0.15), 0.08)
    assert found.verdict == "as good from 0.075 to 0.225"
    assert Choice("stick", 1.0, 0.5, 0.1, 1.0, 1.0, ((1.0, 0.5), (2.0, 0.7))).verdict == "better: 2"
    flat = vary_setting(SETTINGS["stick"], CertificateSettings(), lambda s: 1.0, 0.1)
    assert flat.verdict == "not decided: all values tried do as well"


def test_a_repair_scores_what_it_mends_less_what_it_changes(cases: list[Case]) -> None:
    score = repair_score([cases[1].motion], RepairSettings())
    mended = sf.repair_motion(sf.certify_motion(cases[1].motion.robot, cases[1].motion))
    assert score == mended.mended - mended.joint_change
    assert score > 0.9
