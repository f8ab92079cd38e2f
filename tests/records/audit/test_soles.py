"""The law of soles: a foot's wrench, from its sensor, is the sum of its corners' forces."""

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.errors import ProblemError

SOLE = sf.Sole(0.22, 0.09, 0.6)
WEIGHT = 30.6 * 9.81


def wrenches(rows=60):
    """Return wrenches of two feet that press at their middles and push each other forward: (rows, 2, 6)."""
    out = np.zeros((rows, 2, 6))
    out[:, :, 2] = 0.5 * WEIGHT
    out[:, 0, 0], out[:, 1, 0] = 60.0, -60.0
    return out


def audit(given, soles=(SOLE, SOLE), **more):
    log = sf.log_from_arrays(
        {"foot_wrenches": given}, dt=0.01, feet=["left", "right"], soles=soles, facts={"mass": 30.6}, **more
    )
    return sf.audit_log(log)


def broken(report):
    return {(v.law, v.contact) for v in report.violations}


def test_what_corners_can_give_is_lawful():
    """Friction, pressure at a corner's inside and yaw all at once."""
    given = wrenches()
    forces = np.random.default_rng(3).uniform(size=(60, 2, 4, 3)) * [40.0, 20.0, 100.0]
    forces[..., 2] = np.maximum(forces[..., 2], np.hypot(forces[..., 0], forces[..., 1]) / 0.6)
    arms = np.column_stack([SOLE.corners, np.zeros(4)])
    given[..., :3] = forces.sum(axis=2)
    given[..., 3:] = np.cross(arms, forces).sum(axis=2)
    report = audit(given)
    assert broken(report) == set()
    assert report.coverage["sole"] == ""


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({4: -0.13 * 0.5 * WEIGHT}, "presses 20 mm beyond its toe edge"),
        ({4: 0.12 * 0.5 * WEIGHT}, "presses 10 mm beyond its heel edge"),
        ({3: -0.05 * 0.5 * WEIGHT}, "presses 5 mm beyond its right edge"),
        ({5: 20.0, 0: 0.0}, "turns: it needs"),
        ({1: 0.7 * 0.5 * WEIGHT}, "needs mu of 0.806"),
        ({4: -0.10 * 0.5 * WEIGHT, 0: 0.55 * 0.5 * WEIGHT, 3: 0.042 * 0.5 * WEIGHT, 5: 6.0}, "it needs"),
    ],
)
def test_what_they_cannot_give_is_told(change, says):
    """The report names the foot, the rows and the limit."""
    given = wrenches()
    for column, value in change.items():
        given[20:30, 1, column] = value
    report = audit(given)
    assert ("sole", "right") in broken(report)
    assert {contact for _, contact in broken(report)} == {"right"}
    first = next(v for v in report.violations if v.law == "sole")
    assert (first.start, first.end) == pytest.approx((0.2, 0.3), abs=0.011)
    assert any(says in str(s) for s in report.symptoms), report.symptoms


def test_wrenches_about_the_ankle_are_found():
    """The sensor's own point, 60 mm above the sole and 100 mm behind its middle, is no sole's."""
    given = wrenches()
    given[..., 3:] -= np.cross([-0.1, 0.0, 0.06], given[..., :3])
    report = audit(given)
    assert {"beyond the sole"} <= {s.name for s in report.symptoms}


def test_friction_of_the_ground_counts_and_soles_differ():
    """A friction array is the ground's; without one the soles say it."""
    given = wrenches()
    assert broken(audit(given, soles=(SOLE, SOLE.with_friction(0.1)))) == {
        ("friction", "right"), ("sole", "right"),
    }  # fmt: skip
    log = sf.log_from_arrays(
        {"foot_wrenches": given, "mu": np.linspace(0.9, 0.2, 60)}, dt=0.01, soles=[SOLE] * 2,
        facts={"mass": 30.6},
    )  # fmt: skip
    late = [v for v in sf.audit_log(log).violations if v.law == "sole"]
    assert len(late) == 2
    needed = 60.0 / (0.5 * WEIGHT)
    assert late[0].start == pytest.approx(0.6 * (0.9 - needed) / 0.7, abs=0.02)


def test_logs_keep_their_soles(tmp_path):
    given = wrenches()
    given[20:30, 0, 4] = -0.2 * WEIGHT
    log = sf.log_from_arrays({"foot_wrenches": given}, dt=0.01, soles=[SOLE] * 2, facts={"mass": 30.6})
    again = sf.audit_log(log.save(tmp_path / "feet.npz"))
    assert [str(v) for v in again.violations] == [str(v) for v in sf.audit_log(log).violations]


def test_logs_without_soles_are_not_asked():
    """Points carry no moments: nothing is missing from their coverage."""
    log = sf.log_from_arrays({"forces": wrenches()[..., :3]}, dt=0.01, facts={"mass": 30.6})
    assert "sole" not in sf.audit_log(log).coverage


@pytest.mark.parametrize(
    ("more", "says"),
    [
        ({"soles": [SOLE]}, "one sf.Sole for each of 2 feet"),
        ({"soles": [SOLE, "flat"]}, "one sf.Sole for each of 2 feet"),
        ({"soles": [sf.Sole(0.2, 0.1, 0.6, torsional_radius=0.01)] * 2}, "without a torsional radius"),
        ({"facts": {"sole_corners": [[0.1, 0.1], [0.1, -0.1], [-0.1, 0.0]]}}, "needs sole_contact"),
        (
            {"facts": {"sole_corners": [[0.1, 0.1], [0.1, -0.1], [-0.1, 0.0]], "sole_contact": [0, 0, 7]}},
            "one of 2 contact points",
        ),
    ],
)
def test_wrong_soles_are_refused(more, says):
    facts = {"mass": 30.6, **more.pop("facts", {})}
    with pytest.raises(ProblemError, match=says):
        sf.audit_log(
            sf.log_from_arrays(
                {"foot_wrenches": wrenches(), "mu": np.full(60, 0.6)}, dt=0.01, facts=facts, **more
            )
        )


def test_wrenches_are_six_numbers_said_once():
    with pytest.raises(ProblemError, match=r"must have shape \(T, feet, 6\)"):
        sf.log_from_arrays({"foot_wrenches": np.zeros((5, 6))}, dt=0.01)
    with pytest.raises(ProblemError, match="say the same"):
        sf.log_from_arrays({"foot_wrenches": wrenches(5), "forces": np.zeros((5, 2, 3))}, dt=0.01)
    with pytest.raises(ProblemError, match="give the array foot_wrenches"):
        sf.log_from_arrays({"forces": np.zeros((5, 1, 3))}, dt=0.01, soles=[SOLE])
