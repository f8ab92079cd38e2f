"""The audit of whole logs: clean ones are lawful, spoilt ones are told, and nothing makes it lie."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import surefoot as sf
from benchmarks.problems.logged_runs import CleanRun
from surefoot.base.errors import ProblemError
from surefoot.base.numerics.windows import sliding_mean
from surefoot.base.spatial import GRAVITY
from surefoot.records.audit.intervals import MOST
from surefoot.records.audit.log_context import setting_of
from surefoot.records.audit.report import LawBroken
from surefoot.records.audit.rows import PIECE, Rows
from surefoot.records.log import Log
from tests.records.audit.logs import PUSHED, RUNS, STAND, TROT, changed, log_of

CONTACT = ("forces", "gaps", "contact_velocities", "contact_positions", "mu")
WITHOUT_MOMENTUM = ["balance", "flight", "momentum", "centre of mass", "acceleration", "pressing"]
"""Laws that cannot be judged in a run of our own: it has no momentum, and joints drive it."""


@pytest.mark.parametrize("run", RUNS, ids=lambda run: run.name)
def test_a_clean_run_is_lawful_and_every_law_is_judged(run: CleanRun) -> None:
    report = sf.assert_lawful(log_of(run), symptoms=True)
    assert report.verdict == "lawful"
    assert [name for name, why in report.coverage.items() if why] == WITHOUT_MOMENTUM
    assert report.violations == ()
    assert report.symptoms == ()


def test_a_biped_on_soles_is_lawful_and_no_corner_pulls() -> None:
    log = log_of(CleanRun("g1", duration=0.3))
    report = sf.audit_log(log)
    assert report.verdict == "lawful"
    forces = np.array(log["forces"])
    forces[100:150, 0, 2] = -0.3 * report.weight
    assert "pull" in sf.audit_log(changed(log, forces=forces)).laws_broken


def test_the_motion_is_explained_to_a_thousandth_of_the_weight() -> None:
    log = log_of(TROT)
    rows = Rows(log, setting_of(log, None), 0, len(log))
    rest = rows.unexplained
    assert rest is not None
    w = rows.setting.weight
    assert np.nanmax(np.linalg.norm(sliding_mean(rest.force, 10), axis=1)) < 1e-3 * w
    assert np.nanmax(np.linalg.norm(rest.feet, axis=2)) < 2e-2 * w


def test_a_broken_law_is_told_with_foot_time_value_and_limit() -> None:
    log = log_of(TROT)
    forces, rows = np.array(log["forces"]), slice(200, 260)
    foot = int(np.argmax(forces[rows, :, 2].min(axis=0)))
    forces[rows, foot, 2] = -30.0
    report = sf.audit_log(changed(log, forces=forces))
    assert report.verdict == "broken"
    (pull,) = [v for v in report.violations if v.law == "pull"]
    assert pull.contact == log.facts["feet"][foot]
    assert (pull.start, pull.end) == pytest.approx((0.2, 0.26), abs=1.1e-3)
    assert pull.value == pytest.approx(30.0)
    assert pull.limit == pytest.approx(1e-3 * log.fact("mass") * GRAVITY)
    first = report.symptoms[0]
    assert (first.name, first.contact) == ("pull", pull.contact)
    assert all((first.evidence, first.cause, first.confirm, first.cure))
    with pytest.raises(LawBroken, match="pull") as caught:
        sf.assert_lawful(changed(log, forces=forces))
    assert isinstance(caught.value, AssertionError)
    assert caught.value.report.violations == report.violations


def test_a_declared_softness_is_no_violation_and_is_stated() -> None:
    log = log_of(STAND)
    deep = changed(log, gaps=np.array(log["gaps"]) - 3e-3)
    assert sf.audit_log(deep).laws_broken == ("penetration",)
    soft = sf.audit_log(changed(deep, {"sinking": 4e-3, "creep": 1e-3}))
    assert soft.verdict == "lawful"
    assert any("declares itself soft: sinking to 4 mm" in note for note in soft.notes)


def test_doubts_of_a_reader_are_told() -> None:
    report = sf.audit_log(changed(log_of(STAND), {"doubts": ["gaps look like millimetres"]}))
    assert report.notes == ("doubt of the reader: gaps look like millimetres",)


def test_forces_alone_or_without_friction_are_not_enough() -> None:
    log = log_of(TROT)
    for keep, lacking in ((("forces",), "gaps"), (("forces", "gaps"), "mu"), (("gaps",), "forces"), ((), "")):
        report = sf.audit_log(changed(log, keep=keep))
        assert report.verdict == ("cannot tell" if lacking else "lawful")
        assert lacking in report.reason


def test_a_log_of_contacts_needs_no_robot() -> None:
    log = Log({name: log_of(TROT)[name] for name in (*CONTACT, "time")}, {"mass": log_of(TROT).fact("mass")})
    report = sf.audit_log(log)
    assert report.verdict == "lawful"
    assert report.contacts == tuple(f"contact {k}" for k in range(4))
    assert report.coverage["motion"] == "the log has no q, v"
    assert report.weight == pytest.approx(log.fact("mass") * GRAVITY)


def test_without_a_mass_the_robot_s_is_taken_and_without_a_robot_one_cannot_tell() -> None:
    log = log_of(TROT)
    report = sf.audit_log(Log(log.arrays, {k: v for k, v in log.facts.items() if k != "mass"}))
    assert (report.verdict, report.weight) == ("lawful", pytest.approx(log.fact("mass") * GRAVITY))
    assert any("from its model" in note for note in report.notes)
    report = sf.audit_log(Log({name: log[name] for name in (*CONTACT, "time")}))
    assert report.verdict == "cannot tell"
    assert report.weight == pytest.approx(log.fact("mass") * GRAVITY, rel=0.1)
    assert "does not tell the robot's mass" in report.reason
    assert sf.audit_log(log, sf.load_robot("panda")).verdict == "cannot tell"


@pytest.mark.parametrize("rows", [1, 2, 3])
def test_a_few_rows_tell_nothing_but_may_be_broken(rows: int) -> None:
    log = log_of(TROT).rows(slice(500, 500 + rows))
    assert sf.audit_log(log).verdict == "cannot tell"
    assert f"{rows} rows are too few" in sf.audit_log(log).reason
    assert sf.audit_log(changed(log, forces=-np.array(log["forces"]))).verdict == "broken"


def test_forces_that_carry_nothing_of_the_mass_tell_nothing() -> None:
    log = log_of(TROT)
    arrays = {name: log[name] for name in (*CONTACT, "time")}
    report = sf.audit_log(Log(arrays, {"mass": 1e6}))
    assert report.verdict == "cannot tell"
    assert "no contact ever carries anything" in report.reason


def _nan(name: str) -> Callable[[Log], Log]:
    def spoil(log: Log) -> Log:
        array = np.array(log[name])
        array.reshape(-1)[array.size // 2] = np.nan
        return changed(log, **{name: array})

    return spoil


def _times(name: str, factor: float) -> Callable[[Log], Log]:
    return lambda log: changed(log, **{name: np.array(log[name]) * factor})


def _order(name: str, *order: int) -> Callable[[Log], Log]:
    return lambda log: changed(log, **{name: np.array(log[name])[:, list(order)]})


def _time(change: Callable[[np.ndarray], None]) -> Callable[[Log], Log]:
    def spoil(log: Log) -> Log:
        time = np.array(log["time"])
        change(time)
        return changed(log, time=time)

    return spoil


def _quaternion(log: Log) -> Log:
    q = np.array(log["q"])
    q[:, 3:7] = q[:, [6, 3, 4, 5]]
    return changed(log, q=q)


SPOILT = {
    **{f"nan in {n}": _nan(n) for n in (*CONTACT, "q", "v", "torques", "normals", "push")},
    "nan in wrench_applied": lambda log: changed(log, wrench_applied=np.full((len(log), 6), np.nan)),
    "nan in contact_creep": lambda log: changed(log, contact_creep=np.full((len(log), 4), np.nan)),
    "no time passes": lambda log: changed(log, time=np.zeros(len(log))),
    "time runs back": _time(lambda t: t.__setitem__(slice(None), t[::-1].copy())),
    "a stamp twice": _time(lambda t: t.__setitem__(100, t[99])),
    "a stamp earlier": _time(lambda t: t.__setitem__(100, t[90])),
    "no stamps": _time(lambda t: t.__setitem__(slice(None), np.nan)),
    "milliseconds": _times("time", 1e3),
    "gaps in mm": _times("gaps", 1e3),
    "gaps upside down": _times("gaps", -1.0),
    "degrees": lambda log: changed(log, q=np.hstack([log["q"][:, :7], np.degrees(log["q"][:, 7:])])),
    "half speed": _times("v", 0.5),
    "kgf": _times("forces", 1.0 / 9.81),
    "huge": _times("forces", 1e300),
    "no force at all": _times("forces", 0.0),
    "torques of the motors' side": _times("torques", -1.0),
    "no normals": _times("normals", 0.0),
    "feet exchanged": _order("forces", 1, 0, 2, 3),
    "torques exchanged": _order("torques", 3, 4, 5, 0, 1, 2, 6, 7, 8, 9, 10, 11),
    "quaternion first": _quaternion,
    "another robot": lambda log: changed(log, {"robot": "anymal"}),
    "a robot that does not fit": lambda log: changed(log, {"robot": "g1"}),
    "another step": lambda log: changed(log, {"dt": 0.01}),
    "another mass": lambda log: changed(log, {"mass": 8.0}),
}


@pytest.mark.parametrize("name", SPOILT)
@pytest.mark.filterwarnings("error")
@pytest.mark.sampled(17)
def test_a_wrong_log_is_never_lawful(name: str) -> None:
    report = sf.audit_log(SPOILT[name](log_of(TROT)))
    assert report.verdict != "lawful"
    assert len(report.sentence.splitlines()) == 1


@pytest.mark.parametrize(
    ("facts", "said"),
    [
        ({"mass": -1.0}, "mass"),
        ({"mass": 10**309}, "the fact mass must be numbers"),
        ({"dt": 0.0}, "dt"),
        ({"contact_foot": [0, 1, 2, 9]}, "contact_foot"),
        ({"feet": ["a"]}, "contact_foot"),
        ({"feet": []}, "feet"),
        ({"sinking": -1.0}, "sinking"),
        ({"robot": 3}, "robot"),
        *(({name: [np.nan] * 12}, name) for name in ("armature", "viscous_friction", "dry_friction")),
        ({"gravity": [0.0, 0.0, np.nan]}, r"the fact gravity\[2\] is NaN"),
        ({"gravity": 1.62}, "gravity must have shape"),
        ({"contact_margin": [0.0, np.inf, 0.0, 0.0]}, r"contact_margin\[1\] is infinite"),
    ],
    ids=str,
)
def test_wrong_facts_are_one_clear_line(facts: dict[str, object], said: str) -> None:
    with pytest.raises(ProblemError, match=said):
        sf.audit_log(changed(log_of(STAND), facts))


def test_a_stand_is_lawful_in_the_gravity_that_its_log_tells() -> None:
    log, moon = log_of(STAND), 1.62 / GRAVITY
    scaled = {n: moon * np.array(log[n]) for n in ("forces", "torques", "forces_commanded")}
    assert sf.audit_log(changed(log, {"gravity": [0.0, 0.0, -1.62]}, **scaled)).laws_broken == ()
    for facts in ({"gravity": [0.0, 0.0, -1.62]}, {"gravity": [0.0, 0.0, 0.0]}):
        assert sf.audit_log(changed(log, facts)).laws_broken == ("motion",)


def test_no_rows_no_feet_and_no_file(tmp_path: Path) -> None:
    with pytest.raises(ProblemError, match="no rows"):
        sf.audit_log(Log({"time": np.zeros(0)}))
    nobody = Log({"time": np.arange(3.0), "forces": np.zeros((3, 0, 3)), "gaps": np.zeros((3, 0))})
    assert sf.audit_log(nobody).verdict == "cannot tell"
    with pytest.raises(ProblemError, match="not a Surefoot log"):
        sf.audit_log(tmp_path / "none.npz")


def _long(rows: int) -> Log:
    """Return contacts of one standing foot of 1 kg for many rows at 1 kHz."""
    forces = np.zeros((rows, 1, 3))
    forces[..., 2] = GRAVITY
    zero = np.zeros((rows, 1))
    arrays = {
        "forces": forces,
        "gaps": zero,
        "contact_velocities": np.zeros((rows, 1, 3)),
        "mu": np.ones(rows),
    }
    return Log({"time": 1e-3 * np.arange(rows), **arrays}, {"mass": 1.0})


def test_pieces_leave_no_seam() -> None:
    log = _long(2 * PIECE + 10)
    for name, value in (("gaps", -2e-3), ("gaps", 2e-3)):
        array = np.array(log[name])
        array[PIECE - 30 : PIECE + 40] = value
        (one,) = sf.audit_log(changed(log, **{name: array})).violations
        assert (one.start, one.end) == pytest.approx(((PIECE - 30) * 1e-3, (PIECE + 40) * 1e-3))
    assert sf.audit_log(log).lawful


def test_violations_are_capped_and_counted() -> None:
    log = _long(30 * (MOST + 25))
    gaps = np.array(log["gaps"])
    gaps[10::30] = -2e-3
    report = sf.audit_log(changed(log, gaps=gaps))
    assert len(report.violations) == MOST
    assert report.more == {"penetration": 25}


def test_a_slow_slide_without_friction_is_found_however_slow() -> None:
    log = _long(4000)
    v = np.array(log["contact_velocities"])
    v[..., 0] = 2e-3  # 8 mm in 4 s: a tenth of a millimetre in a window
    report = sf.audit_log(changed(log, contact_velocities=v))
    assert report.laws_broken == ("dissipation",)


def test_a_foot_that_comes_to_rest_tells_nothing_from_above() -> None:
    """MuJoCo stops a landing foot in a few milliseconds, with less than all of its friction (mu 0.6 here)."""
    log = _long(2000)
    forces, v = np.array(log["forces"]), np.array(log["contact_velocities"])
    for start in range(100, 1900, 100):
        v[start : start + 5, 0, 0] = -0.1 * 0.5 ** np.arange(5)
        forces[start : start + 5, 0, 0] = GRAVITY * np.linspace(0.5, 0.2, 5)
    (interval,) = sf.audit_log(changed(log, forces=forces, contact_velocities=v)).friction
    assert interval.high == np.inf
    assert interval.low <= 0.5 + 2e-3
    assert interval.slid > 0.03


def test_an_unlogged_push_is_told_with_its_size() -> None:
    log = log_of(PUSHED)
    report = sf.audit_log(changed(log, push=np.zeros((len(log), 3))))
    first = report.symptoms[0]
    assert (first.name, first.contact) == ("outside force", "body")
    assert f"({1.5 * log.fact('mass'):.3g}, {0.8 * log.fact('mass'):.3g}," in first.evidence
