"""Rows of the cheap recorder are those of `sf.record`, and what is proven of them the audit finds, too."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import surefoot as sf
from surefoot.records import judge_contacts
from surefoot.worlds.mujoco.episode.contact_recorder import ContactRecorder

mujoco = pytest.importorskip("mujoco")
LEG = (
    "<body pos='{x} {y} -.05'><joint name='h{n}' axis='0 1 0' range='-60 60' limited='true' damping='.3'/>"
    "<geom type='capsule' fromto='0 0 0 0 0 -.2' size='.03' density='300'/>"
    "<body pos='0 0 -.2'><joint name='k{n}' axis='0 1 0' range='-60 60' limited='true' damping='.3'/>"
    "<geom name='f{n}' type='capsule' fromto='0 0 0 0 0 -.2' size='.03' density='300' condim='{dim}'/>"
    "</body></body>"
)


def walker(integrator: str = "Euler", cone: str = "pyramidal", dim: int = 3, more: str = "") -> Any:
    """Return a box on four legs of two joints above a plane."""
    spots = [(x, y) for x in (0.2, -0.2) for y in (0.15, -0.15)]
    legs = "".join(LEG.format(x=x, y=y, n=n, dim=dim) for n, (x, y) in enumerate(spots))
    motors = "".join(f"<motor joint='{j}{n}' gear='8' ctrlrange='-1 1'/>" for n in range(4) for j in "hk")
    return mujoco.MjModel.from_xml_string(
        f"<mujoco><option timestep='.002' integrator='{integrator}' cone='{cone}'/><worldbody>"
        f"<geom type='plane' size='9 9 1' condim='{dim}' friction='.7 .02 .01'/>{more}<body pos='0 0 .5'>"
        f"<freejoint/><geom type='box' size='.25 .15 .05' density='300'/>{legs}</body></worldbody>"
        f"<actuator>{motors}</actuator></mujoco>"
    )


def recorded(model: Any, steps: int = 300, seed: int = 0) -> tuple[Any, Any]:
    """Return the log of the cheap recorder, and of `sf.record`, of the same random loop."""
    logs = []
    for cheap in (True, False):
        data, rng = mujoco.MjData(model), np.random.default_rng(seed)
        data.qvel[:] = 0.3 * rng.normal(size=model.nv)
        mujoco.mj_forward(model, data)
        recorder = ContactRecorder(mujoco, model, data)
        with sf.record(model, data) as log:
            for k in range(steps):
                if k % 10 == 0:
                    data.ctrl[:] = rng.uniform(-1.0, 1.0, model.nu)
                mujoco.mj_step(model, data)
                recorder.take()
        logs.append(recorder.log() if cheap else log)
    return logs[0], logs[1]


@pytest.mark.parametrize("kind", [("Euler", "pyramidal", 3), ("implicitfast", "elliptic", 4)])
def test_rows_are_those_of_the_recording(kind: tuple[str, str, int]) -> None:
    """Forces, velocities, gaps, friction, creep where contacts are closed, and what is declared."""
    cheap, log = recorded(walker(*kind))
    assert cheap.facts["feet"] == log.facts["feet"]
    assert cheap["forces"].shape == log["forces"].shape
    closed = np.abs(log["forces"]).max(axis=2) > 0.0
    assert closed.any()
    np.testing.assert_allclose(cheap["forces"], log["forces"], rtol=1e-9, atol=1e-9)
    names = [
        "contact_velocities", "gaps", "contact_friction", "contact_creep", "pyramid_turn", "contact_moments"
    ]  # fmt: skip
    for name in (n for n in names if n in log):
        np.testing.assert_allclose(cheap[name][closed], log[name][closed], rtol=1e-9, atol=1e-9, err_msg=name)
    for name in ("creep", "settling", "mass", "dt"):
        assert cheap.fact(name) == pytest.approx(log.fact(name), rel=1e-9), name
    for name in ("sinking", "stopping"):  # of touchdowns, which open rows have a part in
        assert cheap.fact(name) <= 1.001 * log.fact(name), name
    for name in ("critically_damped", "contact_damping"):
        np.testing.assert_allclose(cheap.facts[name], log.facts[name])


@pytest.mark.long
def test_laws_of_contacts_are_judged_as_by_the_whole_audit() -> None:
    """Of twelve random loops, softer and harder ones: the same laws are broken, of those that both judge."""
    verdicts = set()
    for seed in range(12):
        model = walker(("Euler", "implicitfast")[seed % 2], ("pyramidal", "elliptic")[seed // 2 % 2])
        if seed % 3 == 0:
            model.geom_solref[:] = [-4000.0, -1.0]
        cheap, log = recorded(model, 250, seed)
        one, whole = judge_contacts(cheap), sf.audit_log(log)
        found = {law.name for law in one.laws.values() if law.law and law.share[0] > 0.0}
        assert found == {*whole.laws_broken} & {*one.laws}, seed
        verdicts.add(one.verdicts[0])
    assert len(verdicts) > 1


def test_what_is_proven_the_audit_finds_too() -> None:
    """Of sixty loops none that is proven is judged otherwise, and most of the lawful ones are proven."""
    proven, lawful, told = 0, 0, set()
    for seed in range(60):
        model = walker(("Euler", "RK4")[seed % 2], ("pyramidal", "elliptic")[seed // 2 % 2])
        if seed % 3 == 0:
            model.geom_solref[:] = [(-4000.0, -1.0), (0.004, 1.0)][seed // 3 % 2]
        data, rng = mujoco.MjData(model), np.random.default_rng(seed)
        data.qvel[:] = 0.5 * rng.normal(size=model.nv)
        mujoco.mj_forward(model, data)
        recorder = ContactRecorder(mujoco, model, data)
        for k in range(150):
            if k % 10 == 0:
                data.ctrl[:] = rng.uniform(-1.0, 1.0, model.nu)
            mujoco.mj_step(model, data)
            recorder.take()
        one, report = recorder.prove(), judge_contacts(recorder.log())
        lawful += report.verdicts[0] != "broken"
        if one is not None:
            proven += 1
            assert one.verdicts == report.verdicts, seed
            assert one.reasons == report.reasons
            assert [e.name for e in one.exploits] == [e.name for e in report.exploits], seed
            for sign in ("throw", "spike"):
                mine, theirs = one[sign], report[sign]
                assert mine.share == pytest.approx(theirs.share)
                if mine.share[0] > 0.0:
                    told.add(sign)
                    for figure in ("worst", "limit", "instant"):
                        assert getattr(mine, figure) == pytest.approx(getattr(theirs, figure)), (seed, sign)
    assert told == {"throw", "spike"}
    assert proven > 0.5 * lawful


def test_time_that_was_not_seen_and_states_that_were_reset_are_noted() -> None:
    """A step that nobody took leaves a hole, a clock that runs back ends a part."""
    model = walker()
    data = mujoco.MjData(model)
    recorder = ContactRecorder(mujoco, model, data)
    for k in range(300):
        mujoco.mj_step(model, data)
        if k != 200:
            recorder.take()
    assert recorder.missed == 1
    assert "unseen_steps" in recorder.log().facts
    assert judge_contacts(recorder.log()).verdicts == ("cannot tell",)
    mujoco.mj_resetData(model, data)
    for _ in range(10):
        mujoco.mj_step(model, data)
        recorder.take()
    assert recorder.turned == 1
    assert [len(part) for part in recorder.parts] == [299]
    assert recorder.count == 10


def test_more_contacts_than_there_is_room_for() -> None:
    """Rows and contact points are enlarged, and what was taken stays."""
    model = walker()
    data = mujoco.MjData(model)
    small, large = ContactRecorder(mujoco, model, data), ContactRecorder(mujoco, model, data)
    large._make_room(2000, 40)
    small._make_room(2, 1)
    for _ in range(700):
        mujoco.mj_step(model, data)
        small.take()
        large.take()
    one, two = small.log(), large.log()
    assert set(one) == set(two)
    for name in one:
        np.testing.assert_array_equal(one[name], two[name])
