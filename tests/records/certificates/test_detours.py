"""Detours of a centre of mass against integrated paths, and contacts of motions that stand too high."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import surefoot as sf
from surefoot.records.certificates.certificate_settings import CertificateSettings
from surefoot.records.certificates.detours import find_detours
from surefoot.records.motions.motion import Motion

RATE = 30.0


@pytest.fixture(scope="module")
def g1() -> sf.Robot:
    return sf.load_robot("g1")


def standing(robot: sf.Robot, height: float, count: int = 40) -> Motion:
    """Return a robot that stands with its soles at a height [m]."""
    q = np.tile(robot.nominal, (count, 1))
    q[:, 2] += height - min(robot.sphere_bottoms(robot.nominal))
    return Motion(robot, q, RATE)


def test_a_detour_is_that_of_a_path_with_the_residual() -> None:
    """A path that bends by a g between two rests on a line, integrated in small steps."""
    bound = np.array([np.nan, 0.02, 0.3, 0.3, 0.3, 0.05, 0.2, np.nan])
    found = find_detours(bound, 0.1, 0.1, 1.0 / RATE)
    time = 0.1 + 2.0 / RATE
    t = np.linspace(0.0, time, 20001)
    fall = 0.3 * 9.81 * 0.5 * t * (time - t)
    assert found[2:5] == pytest.approx(fall.max(), rel=1e-6)
    assert found[6] == pytest.approx(0.2 * 9.81 * 0.01 / 8.0)
    assert not found[[0, 1, 5, 7]].any()
    assert not find_detours(np.full(4, np.nan), 0.1, 0.1, 1.0 / RATE).any()


def test_a_short_residual_cannot_be_told_and_a_long_one_can(g1: sf.Robot) -> None:
    motion = standing(g1, 0.0)
    for frames, verdict in ((1, "possible"), (12, "impossible")):
        q = motion.q.copy()
        q[15 : 15 + frames, 2] += 0.025  # above the clearance
        report = sf.certify_motion(g1, replace(motion, q=q))
        assert ("impossible" in report.frames.verdict) == (verdict == "impossible")
        bad = report.frames.verdict == "impossible"
        assert (report.frames.detour[bad] > report.settings.detour).all()
        assert (report.frames.bound[bad] > report.impossible).all()
    assert report.segments[0].detour == pytest.approx(report.frames.detour.max())
    strict = sf.certify_motion(g1, motion, settings=CertificateSettings(detour=0.0))
    assert strict.verdict == "possible"


@pytest.mark.parametrize(("height", "counted"), [(0.0, 0.0), (0.01, 0.01), (-0.02, 0.0), (0.03, 0.0)])
def test_contacts_count_from_where_a_motion_stands(g1: sf.Robot, height: float, counted: float) -> None:
    report = sf.certify_motion(g1, standing(g1, height))
    assert report.data.model.rules.clearance == pytest.approx(0.02 + counted)
    assert any("throughout" in note for note in report.notes) == (counted > 0.0)
    assert report.verdict == ("impossible" if height > 0.02 else "possible")


def test_a_motion_that_hangs_for_a_while_does_not_move_its_ground(g1: sf.Robot) -> None:
    motion = standing(g1, 0.0, 90)
    q = motion.q.copy()
    q[50:80, 2] += 0.03
    report = sf.certify_motion(g1, replace(motion, q=q))
    assert report.data.model.rules.clearance == pytest.approx(0.02)
    assert {s.cause for s in report.segments} == {"hangs"}
