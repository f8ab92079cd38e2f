"""Channels of one motion, whole flights, and logs whose rows are too long for what happens in them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import surefoot as sf
from benchmarks.limit_cases.law_cases import ball
from benchmarks.problems.exact_drops import Drop
from benchmarks.problems.plain_logs import plain_logs
from benchmarks.spoils import SPOILS, SpoilScore, lawful_log, measure, spoil_log
from surefoot.base.spatial import GRAVITY
from surefoot.records.log import Log
from tests.records.audit.logs import TROT, changed, log_of
from tests.worlds.mujoco.recordings import recorded

mujoco = pytest.importorskip("mujoco")
CRATE = """<mujoco><option timestep='.002'/><worldbody><geom name='floor' type='plane' size='9 9 1'/>
<body pos='0 0 .1'><freejoint/><geom type='box' size='.2 .2 .1' mass='5'/></body></worldbody></mujoco>"""
TUMBLER = """<mujoco><option timestep='.005' cone='{cone}'/><worldbody>
<geom name='floor' type='plane' size='9 9 1' friction='.7'/>
<body pos='0 0 {height}' quat='{turn}'><freejoint/>
{geom}</body></worldbody></mujoco>"""
GEOMS = (
    "<geom type='box' size='.1 .15 .08' mass='3' friction='.7'/>",
    "<geom size='.1' mass='2' friction='.7'/>",
    "<geom type='capsule' size='.05 .15' mass='2' friction='.7'/>",
    "<geom type='cylinder' size='.1 .1' mass='3' friction='.7'/>",
)


def after_the_step(log: Log) -> Log:
    """Return a log as one is that is written after each step: its forces are of the row before."""
    arrays = {name: np.array(array)[1:] for name, array in log.arrays.items()}
    arrays |= {name: np.array(log[name])[:-1] for name in ("forces", "momentum_rate")}
    return Log(arrays, log.facts, channels=log.channels)


@pytest.mark.parametrize("logged", [lambda log: log, after_the_step], ids=["before", "after"])
@pytest.mark.parametrize("dt", [5e-4, 1e-3, 2e-3, 5e-3])
@pytest.mark.sampled(2)
def test_an_exact_drop_is_lawful_at_any_rate(dt: float, logged: Callable[[Log], Log]) -> None:
    reports = [sf.audit_log(logged(Drop.seeded(seed).log(dt))) for seed in range(40)]
    assert not [report.sentence for report in reports if report.verdict == "broken"]


@pytest.mark.parametrize("geom", range(len(GEOMS)))
@pytest.mark.sampled(2)
def test_mujocos_own_drops_are_lawful_at_five_milliseconds(geom: int) -> None:
    for seed in range(6):
        rng = np.random.default_rng([seed, geom])
        turn = " ".join(f"{x:.6f}" for x in rng.normal(size=4))
        text = TUMBLER.format(
            cone=("pyramidal", "elliptic")[seed % 2],
            height=rng.uniform(0.2, 0.6),
            turn=turn,
            geom=GEOMS[geom],
        )
        model = mujoco.MjModel.from_xml_string(text)
        data = mujoco.MjData(model)
        data.qvel[:] = rng.uniform(-1.0, 1.0, 6) * [1.0, 1.0, 1.0, 4.0, 4.0, 4.0]
        report = sf.audit_log(recorded(model, 200, data))
        assert report.verdict != "broken", report.sentence


@pytest.mark.parametrize(
    "facts",
    [
        {},
        {"velocities": "mean"},
        {"critically_damped": np.ones(1)},
        {"sinking": 0.05, "creep": 0.1, "stopping": 0.1, "settling": 0.1, "contact_margin": np.full(1, 0.05)},
    ],
    ids=["nothing", "velocities", "damping", "softness"],
)
@pytest.mark.parametrize("dt", [2.5e-4, 1e-3, 5e-3, 1e-2])
def test_a_ball_that_comes_back_higher_is_broken_whatever_is_declared(
    dt: float, facts: dict[str, Any]
) -> None:
    for restitution, lawful in ((1.0, True), (1.63, False)):
        log = ball(restitution, dt, 0.053).log()
        report = sf.audit_log(Log(log.arrays, {**log.facts, **facts}, channels=log.channels))
        assert report.lawful is lawful, report.sentence
        assert lawful or "flight" in report.laws_broken


def test_what_is_declared_of_velocities_is_said() -> None:
    log = ball(1.0, 1e-3).log()
    notes = sf.audit_log(Log(log.arrays, {**log.facts, "velocities": "mean"})).notes
    assert any("half of a row's change of velocity" in note for note in notes)


def slid(kick: float) -> Log:
    """Return the recording of a crate that slides, and is kicked in its middle."""
    model = mujoco.MjModel.from_xml_string(CRATE)
    data = mujoco.MjData(model)
    data.qvel[0] = 2.0
    steps = iter(range(400))

    def before(data: Any) -> None:
        data.qvel[1] += kick if next(steps) == 200 else 0.0

    return recorded(model, 400, data, before)


def test_a_kick_that_no_force_gave_breaks_laws() -> None:
    assert sf.audit_log(slid(0.0)).lawful
    report = sf.audit_log(slid(1.0))
    first = next(v for v in report.violations if v.law == "momentum")
    assert abs(first.start - 0.4) < 0.012
    assert first.value == pytest.approx(1.0, abs=0.05)
    assert {"momentum", "centre of mass", "acceleration"} <= set(report.laws_broken)


def test_half_of_the_weight_makes_the_centre_of_mass_fall() -> None:
    log = slid(0.0)
    alone = ("forces", "com", "normals", "gaps", "contact_velocities", "mu", "contact_positions")
    assert sf.audit_log(changed(log, keep=alone)).verdict == "lawful"
    report = sf.audit_log(changed(log, keep=alone, forces=0.5 * log["forces"]))
    worst = max(v.value for v in report.violations if v.law == "acceleration")
    assert worst > 0.4 * 5.0 * GRAVITY


def test_a_gap_wider_than_a_recording_measures_is_not_judged() -> None:
    model = mujoco.MjModel.from_xml_string(CRATE.replace("0 0 .1'", "0 0 2'"))
    log = recorded(model, 340)
    assert log["gaps"].max() == 1.0
    report = sf.audit_log(log)
    assert not {"gap place", "gap rate"} & set(report.laws_broken), report.sentence


def test_what_touches_is_another_plane_on_a_step() -> None:
    """Half of a slide is 6 cm higher, as a step is: nobody says so, and nothing is broken."""
    log = Drop(0.0, (0.1, 0.0), 0.0, 0.0, 0.0).log(1e-3)
    places = np.array(log["contact_positions"])
    places[900:, :, 2] += 0.06
    arrays = {name: np.array(a) for name, a in log.arrays.items()} | {"contact_positions": places}
    arrays = {name: a for name, a in arrays.items() if name not in ("com", "momentum", "momentum_rate")}
    report = sf.audit_log(Log(arrays, log.facts, channels=log.channels))
    assert report.coverage["gap place"] == "the ground is not known to be one plane"


def test_a_rate_that_cannot_tell_names_one_that_could() -> None:
    log = ball(0.6, 0.06, 3.0).log()
    arrays = {name: np.array(a) for name, a in log.arrays.items()} | {
        "com": np.zeros((len(log), 3)), "normals": np.tile([0.0, 0.0, 1.0], (len(log), 1, 1)),
    }  # fmt: skip
    coverage = sf.audit_log(Log(arrays, log.facts)).coverage
    assert coverage["acceleration"] == "cannot tell at this rate: rows are 60 ms apart, 50 ms could"
    assert coverage["restitution"].startswith("cannot tell at this rate: rows are 60 ms apart")


@pytest.mark.parametrize("name", ["crate-2ms", "drop-1ms", "quadruped-2ms"])
def test_spoilt_logs_are_found(name: str) -> None:
    one = next(log for log in plain_logs() if log.name == name)
    lawful = lawful_log(one.make(False))
    assert sf.audit_log(lawful.log).verdict == "lawful"
    for spoil in SPOILS:
        made = spoil_log(one, lawful, spoil, 3)
        assert made is not None
        log, exceeds = made
        assert not exceeds or sf.audit_log(log).verdict == "broken", spoil.name


@pytest.mark.long
def test_thirty_logs_spoilt_in_thirteen_ways() -> None:
    out = list(measure())
    scores = [one for one in out if isinstance(one, SpoilScore)]
    assert len(scores) == len(out) == len(SPOILS)
    exceed, found = sum(s.exceed for s in scores), sum(s.found for s in scores)
    assert exceed > 300
    assert found >= 0.97 * exceed


def test_a_trot_whose_contact_velocities_are_degrees_is_broken_without_its_robot() -> None:
    log = log_of(TROT)
    facts = {name: fact for name, fact in log.facts.items() if name != "robot"}
    for scale, broken in ((1.0, False), (57.3, True), (0.5, True)):
        arrays = {name: np.array(a) for name, a in log.arrays.items()}
        arrays["contact_velocities"] *= scale
        report = sf.audit_log(Log(arrays, facts, channels=log.channels))
        assert (report.verdict == "broken") is broken, report.sentence


@pytest.mark.parametrize(("row", "broken"), [(50, False), (70, True), (30, True)])
def test_half_a_row_goes_lost_where_all_loads_begin_and_nowhere_else(row: int, broken: bool) -> None:
    """A foot flies on at 12 m/s; where another one lands a world tells the middle of its step."""
    count = 100
    time, (forces, velocities, places) = 1e-3 * np.arange(count), np.zeros((3, count, 2, 3))
    forces[50:, 0, 2], velocities[:, 1, 0] = 9.81, 12.0
    places[:, 1, 0], places[:, 1, 2] = 12.0 * time + np.where(np.arange(count) >= row, 6e-3, 0.0), 0.3
    log = sf.Log(
        {
            "time": time, "forces": forces, "gaps": places[..., 2], "contact_velocities": velocities,
            "contact_positions": places, "normals": np.tile([0.0, 0.0, 1.0], (count, 2, 1)),
            "mu": np.full(count, 0.6),
        },
        {"mass": 1.0, "dt": 1e-3, "feet": ["standing", "flying"], "contact_foot": [0, 1]},
    )  # fmt: skip
    assert sf.audit_log(log).laws_broken == (("contact jump",) if broken else ())
