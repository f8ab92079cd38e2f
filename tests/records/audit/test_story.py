"""Why a run went wrong: the first cause of strangers' failures, dated and placed; none without one."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

import surefoot as sf
from surefoot.app.viz.story_plots import draw_story
from surefoot.records import Log
from surefoot.records.audit.story.causes import RULES
from tests.worlds.mujoco.strangers import crate, quadruped, thrown_crate


def cut(model: Any, data: Any, step: int) -> None:
    data.ctrl[:6] *= step < 300


def shove(model: Any, data: Any, step: int) -> None:
    data.xfrc_applied[1, 1] = 400.0 if 250 <= step < 300 else 0.0


def chatter(model: Any, data: Any, step: int) -> None:
    data.ctrl[:] = -900.0 * data.qvel[6:] if step > 200 else data.ctrl


def weaken(model: Any, data: Any, step: int) -> None:
    if step == 300:
        model.actuator_gainprm[[1, 2, 4, 5], 0] = 0.1


def load(model: Any, data: Any, step: int) -> None:
    if step == 300:
        model.body_mass[1] += 60.0


CASES = {
    "slope": (lambda: crate(mu=0.25, tilt=20.0), "slope too steep", "ground", None),
    "dead": (lambda: quadruped(700, cut), "weak actuator", "fl_", 0.6),
    "weak": (lambda: quadruped(700, weaken), "weak actuator", "m_fl", 0.6),
    "push": (lambda: quadruped(700, shove), "push", "torso", 0.5),
    "payload": (lambda: quadruped(700, load), "payload", "torso", 0.6),
    "chatter": (lambda: quadruped(500, chatter), "chattering gains", "", 0.4),
}


@pytest.fixture(scope="module")
def reports() -> dict[str, Any]:
    return {name: sf.audit_log(make()) for name, (make, *_) in CASES.items()}


@pytest.mark.parametrize("name", CASES)
def test_the_first_cause_is_named_placed_and_dated(reports: dict[str, Any], name: str) -> None:
    _, cause, where, time = CASES[name]
    found = reports[name].first_cause
    assert found is not None
    assert found.name == cause, str(reports[name].story)
    assert where in found.where
    assert time is None or found.time == pytest.approx(time, abs=0.15)
    assert found.remedy in str(reports[name])
    assert reports[name].as_dict()["story"]["causes"][0]["name"] == cause


@pytest.mark.parametrize("make", [quadruped, crate], ids=["quadruped", "crate"])
def test_where_nothing_fails_there_is_no_cause(make: Any) -> None:
    report = sf.audit_log(make())
    assert report.causes == ()
    assert report.first_cause is None
    assert "Nothing went wrong" in str(report)
    assert report.task == "unknown"  # a loop of somebody's that says of no task


def test_what_soft_contact_gave_back_is_said() -> None:
    """A crate thrown flat slides by Coulomb's law; soft contact catches its edge and throws it up."""
    report = sf.audit_log(thrown_crate(9.0))
    found = report.first_cause
    assert found is not None
    assert found.name == "soft contact"
    assert "by Coulomb's law it slides on upright" in report.sentence
    assert sf.audit_log(thrown_crate(0.5)).first_cause is None


def test_a_turned_log_is_told_from_a_fall() -> None:
    log = quadruped(500, shove)
    for turn in (np.diag([-1.0, -1.0, 1.0]), -np.eye(3)):
        spoilt = Log({**log.arrays, "forces": log["forces"] @ turn}, dict(log.facts))
        found = sf.audit_log(spoilt).first_cause
        assert found is not None
        assert found.name == "wrong contact frame"


def test_no_words_of_policies_where_there_is_none(reports: dict[str, Any]) -> None:
    for report in reports.values():
        assert "policy" not in str(report.as_dict())
    assert not any("policy" in rule.remedy for rule in RULES)


def test_logs_with_holes_have_a_story() -> None:
    """NaN, one row, no forces, no torques: a story never raises, and says no more than it can."""
    log = quadruped(300)
    rng = np.random.default_rng(0)
    for name in log.arrays:
        arrays = {k: np.array(a, dtype=a.dtype) for k, a in log.arrays.items()}
        if arrays[name].dtype == bool or name == "time":
            continue
        arrays[name] = np.where(rng.random(arrays[name].shape) < 0.3, np.nan, arrays[name])
        sf.audit_log(Log(arrays, dict(log.facts)))
    needed = "forces", "torques", "q", "normals", "contact_positions", "momentum", "contact_velocities"
    for name in needed:
        arrays = {k: a for k, a in log.arrays.items() if k != name}
        assert sf.audit_log(Log(arrays, dict(log.facts))).causes == ()
    assert sf.audit_log(log.rows(slice(0, 1))).causes == ()


def test_a_story_is_drawn(reports: dict[str, Any], tmp_path: Path) -> None:
    for name in ("dead", "slope"):
        path = draw_story(reports[name], tmp_path / f"{name}.png")
        assert path.stat().st_size > 20_000


def test_ice_explains_a_slide_that_small_slips_began() -> None:
    """A robot that steps in place slips by millimetres; all friction goes at 1.2 s: that is why it slides."""
    path = Path(__file__).parents[3] / "examples" / "models" / "quadruped_servos.xml"
    model = mujoco.MjModel.from_xml_path(str(path))
    data, q = mujoco.MjData(model), sf.place(sf.load_robot(path, feet=["FL", "FR", "RL", "RR"]))
    data.qpos[:] = q
    data.qpos[3:7] = 1.0, 0.0, 0.0, 0.0
    data.qpos[2] += 0.003
    with sf.record(model, data) as log:
        for step in range(1500):
            swing = np.sin(4.0 * np.pi * data.time + np.pi * np.array([0.0, 1.0, 1.0, 0.0]))
            lift = np.maximum(swing, 0.0)[:, None] * [0.0, 0.25, -0.5]
            data.ctrl[:] = q[7:] + lift.ravel()
            if step == 600:
                model.geom_friction[:, 0] = 0.004
            mujoco.mj_step(model, data)
    report = sf.audit_log(log)
    found = report.first_cause
    assert found is not None, str(report.story)
    assert found.name == "slippery ground"
    assert found.time == pytest.approx(600 * model.opt.timestep, abs=0.15)
    assert "floor, trunk:1" in found.where  # shapes without names are their links', and told once
    assert sum("falls to" in event.evidence for event in report.story.events) == 1
