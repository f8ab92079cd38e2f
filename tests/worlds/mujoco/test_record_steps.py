"""Every step of a MuJoCo loop is a row, however the loop makes it; a reset ends an episode."""

from __future__ import annotations

import copy
import pickle
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.errors import ModelError, SurefootError
from surefoot.worlds.mujoco import record_capture, record_places

mujoco = pytest.importorskip("mujoco")

SCENE = (
    "<mujoco><option timestep='0.005' {option}/><worldbody><geom name='floor' type='plane' size='9 9 1'/>"
    "<body name='box' pos='0 0 0.12'><freejoint/><geom name='shell' type='box' size='.2 .15 .1' mass='4'/>"
    "<body pos='0 0 .1'><joint name='arm' axis='0 1 0' damping='.1' range='-40 40' limited='true'/>"
    "<geom name='rod' type='capsule' fromto='0 0 0 0 0 .2' size='.02' mass='.5'/></body></body></worldbody>"
    "<actuator><motor name='arm' joint='arm' gear='2'/></actuator></mujoco>"
)
STEP = mujoco.mj_step  # as this module holds it, before any recording


def made(option: str = "") -> tuple[Any, Any]:
    model = mujoco.MjModel.from_xml_string(SCENE.format(option=option))
    return model, mujoco.MjData(model)


def whole(model: Any, data: Any, n: int) -> None:
    mujoco.mj_step(model, data, nstep=n)


def halves(model: Any, data: Any, n: int) -> None:
    for _ in range(n):
        mujoco.mj_step1(model, data)
        mujoco.mj_step2(model, data)


def dm_control(model: Any, data: Any, n: int) -> None:
    mujoco.mj_step2(model, data)
    if n > 1:
        mujoco.mj_step(model, data, n - 1)
    mujoco.mj_step1(model, data)


def forward_and_euler(model: Any, data: Any, n: int) -> None:
    for _ in range(n):
        mujoco.mj_forward(model, data)
        mujoco.mj_Euler(model, data)


def recorded(make: Callable[[Any, Any, int], None], option: str = "", n: int = 4) -> sf.Log:
    model, data = made(option)
    mujoco.mj_forward(model, data)
    with sf.record(model, data) as log:
        for k in range(50):
            data.ctrl[0] = np.sin(0.3 * k)
            make(model, data, n)
    return log


@pytest.mark.parametrize("make", [halves, dm_control, forward_and_euler])
@pytest.mark.parametrize("option", ["", "cone='elliptic' noslip_iterations='3'"])
@pytest.mark.sampled(2)
def test_all_ways_to_step_give_the_same_rows(make: Callable[[Any, Any, int], None], option: str) -> None:
    expected, found = recorded(whole, option), recorded(make, option)
    assert len(found) == 200
    assert set(found) == set(expected)
    for name in expected:
        np.testing.assert_allclose(found[name], expected[name], atol=1e-9, err_msg=name)
    assert found.doubts == expected.doubts
    assert sf.audit_log(found).verdict == sf.audit_log(expected).verdict == "lawful"


@pytest.mark.long
def test_runge_and_kutta_and_its_halves() -> None:
    """MuJoCo's second half takes Euler's step whatever the integrator."""
    option = "integrator='RK4'"
    np.testing.assert_allclose(recorded(halves, option)["forces"], recorded(whole)["forces"], atol=1e-9)
    four = recorded(whole, option)
    assert four.facts["velocities"] == "mean"
    assert not any("came out otherwise" in doubt for doubt in four.doubts)


def test_a_module_s_own_name_for_a_step_is_seen() -> None:
    module = ModuleType("stranger")
    module.mj_step = mujoco.mj_step  # type: ignore[attr-defined]
    sys.modules["stranger"] = module
    model, data = made()
    try:
        with sf.record(model, data) as log:
            for _ in range(10):
                module.mj_step(model, data)
        assert len(log) == 10
        assert module.mj_step is mujoco.mj_step
        assert mujoco.mj_step is STEP
    finally:
        del sys.modules["stranger"]


def test_steps_that_nobody_saw_reach_the_verdict() -> None:
    model, data = made()
    hidden = [STEP]  # no module holds it here
    with sf.record(model, data) as log:
        for k in range(60):
            (hidden[0] if k % 4 == 3 else mujoco.mj_step)(model, data)
    assert len(log) == 45
    assert log.facts["unseen_steps"] == 15
    report = sf.audit_log(log)
    assert report.verdict == "cannot tell"
    assert "rows are missing" in report.reason


def test_uneven_rows_of_any_log_reach_the_verdict() -> None:
    log = recorded(whole, n=6)
    assert sf.audit_log(log).lawful
    some = np.arange(len(log)) % 3 != 2
    report = sf.audit_log(sf.Log(log.rows(some).arrays, log.facts, channels=log.channels))
    assert report.verdict == "cannot tell"
    assert "uneven" in report.reason
    jitter = np.random.default_rng(0).uniform(-0.3, 0.3, len(log)) * log.fact("dt")
    shaken = sf.Log({**log.arrays, "time": log["time"] + jitter}, log.facts, channels=log.channels)
    assert "uneven" not in sf.audit_log(shaken).reason


@pytest.mark.parametrize("reset", ["mujoco", "by hand", "the state alone"])
def test_a_reset_ends_an_episode(reset: str, tmp_path: Path) -> None:
    model, data = made()
    with sf.record(model, data) as log:
        for k in range(300):
            if k in (100, 200) and reset == "mujoco":
                mujoco.mj_resetData(model, data)
            elif k in (100, 200):
                data.qpos[:], data.qvel[:] = model.qpos0, 0.0
                data.qpos[2] += 0.1
                data.time *= reset == "the state alone"
            mujoco.mj_step(model, data)
    assert [len(part) for part in log.episodes] == [100, 100, 100]
    assert not any("backward" in doubt for doubt in log.doubts)
    report = sf.audit_log(log)
    assert report.lawful, report.sentence
    assert len(report.episodes) == 3
    assert report.sentence.startswith("3 episodes, 3 lawful; ")
    again = sf.read_log(log.save(tmp_path / "log.npz"))
    assert [len(part) for part in again.episodes] == [100, 100, 100]
    assert sf.audit_log(again).as_dict() == report.as_dict()
    assert [len(part) for part in log.rows(slice(50, 150)).episodes] == [50, 50]


def test_a_platform_that_a_loop_moves_is_no_robot() -> None:
    model = mujoco.MjModel.from_xml_string(
        "<mujoco><worldbody><body name='lift' mocap='true'><geom type='box' size='1 1 .1'/></body>"
        "<body name='box' pos='0 0 .2'><freejoint/><geom type='box' size='.1 .1 .1' mass='2'/></body>"
        "</worldbody></mujoco>"
    )
    data = mujoco.MjData(model)
    with sf.record(model, data) as log:
        for k in range(100):
            data.mocap_pos[0, 2] = 0.001 * np.sin(0.1 * k)
            mujoco.mj_step(model, data)
    assert log.facts["robot"] == "box"
    assert log["contact_positions"].shape[1] == 4
    with pytest.raises(SurefootError, match="lift is moved by hand"):
        sf.record(model, data, robot="lift")


def test_a_trunk_that_is_held_in_place_is_no_reset() -> None:
    model, data = made()
    with sf.record(model, data) as log:
        for _ in range(100):
            data.qpos[2] = 0.5 if data.qpos[2] < 0.49 else data.qpos[2]
            data.qpos[0] += 0.1
            mujoco.mj_step(model, data)
    assert len(log.episodes) == 1


def test_a_broken_episode_is_the_verdict() -> None:
    model, data = made()
    with sf.record(model, data) as log:
        for k in range(300):
            if k == 150:
                mujoco.mj_resetData(model, data)
            mujoco.mj_step(model, data)
    forces = log["forces"].copy()
    forces[250:, :, 2] *= -1.0
    report = sf.audit_log(sf.Log({**log.arrays, "forces": forces}, log.facts, channels=log.channels))
    assert [one.verdict for one in report.episodes] == ["lawful", "broken"]
    assert report.verdict == "broken"
    assert any(note.startswith("episode 2 (rows 150 to 299): broken") for note in report.notes)


def test_a_reset_at_the_end_takes_nothing_away() -> None:
    model, data = made()
    with sf.record(model, data) as log:
        mujoco.mj_resetData(model, data)
        mujoco.mj_step(model, data, 200)
        mujoco.mj_resetData(model, data)
        mujoco.mj_step(model, data, 2)
    assert [len(part) for part in log.episodes] == [200, 2]
    assert sf.audit_log(log).lawful


def test_an_interrupted_loop_keeps_its_rows_and_masses_of_their_time() -> None:
    """Rows are worked out after the loop: by the model as it was, whatever has become of it since."""
    model, data = made()
    log = sf.record(model, data)
    with suppress(KeyboardInterrupt), log:
        mujoco.mj_step(model, data, 50)
        model.body_mass[1] *= 2.0
        mujoco.mj_step(model, data, 49)
        raise KeyboardInterrupt
    model.body_mass[1] *= 100.0
    model.geom_pos[:] += 1.0
    assert len(log) == 99
    assert log.facts["error"] == "KeyboardInterrupt: "
    assert log.facts["change_row"].tolist() == [50]
    assert log.fact("mass") == pytest.approx(4.5)
    expected, again = made()
    with sf.record(expected, again) as plain:
        mujoco.mj_step(expected, again, 50)
    for name in ("momentum", "forces", "contact_positions", "energy", "other_forces"):
        np.testing.assert_allclose(log[name][:50], plain[name], atol=1e-9, err_msg=name)


@pytest.mark.parametrize("through", [copy.deepcopy, lambda log: pickle.loads(pickle.dumps(log))])
def test_a_recording_is_copied_and_pickled_as_a_log(through: Callable[[sf.Log], sf.Log]) -> None:
    log = recorded(whole, n=1)
    again = through(log)
    assert list(again) == list(log)
    np.testing.assert_array_equal(again["forces"], log["forces"])
    assert again.facts["feet"] == log.facts["feet"]


def alike(one: sf.Log, two: sf.Log) -> None:
    """Check that two logs are the same to the last bit."""
    assert set(one) == set(two)
    for name in one:
        np.testing.assert_array_equal(one[name], two[name], err_msg=name)


def swung(option: str) -> sf.Log:
    """Return the log of a box whose arm is pressed to the end of its range."""
    model, data = made(option)
    with sf.record(model, data) as log:
        for _ in range(120):
            data.ctrl[0] = 1.0
            mujoco.mj_step(model, data)
    assert data.nl > 0
    assert data.ncon > 0
    return log


@pytest.mark.parametrize("option", ["", "integrator='RK4'", "solver='PGS'", "jacobian='sparse'"])
@pytest.mark.sampled(2)
def test_a_mujoco_of_an_unknown_layout_is_asked_by_its_bindings(
    option: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    expected = swung(option)

    def unknown(_: object) -> None:
        raise ModelError("other structs")

    monkeypatch.setattr(record_places, "struct_offsets", unknown)
    alike(swung(option), expected)


def test_sparse_rows_are_read_as_dense_ones() -> None:
    dense, sparse = swung("jacobian='dense'"), swung("jacobian='sparse'")
    assert np.abs(dense["other_forces"]).max() > 0.1
    for name in dense:
        np.testing.assert_allclose(dense[name], sparse[name], atol=1e-7, err_msg=name)


@pytest.mark.parametrize("bytes_", [20_000, 200_000])
def test_a_loop_longer_than_the_room_is_worked_out_on_its_way(
    bytes_: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    expected = swung("integrator='RK4'"), swung("")
    monkeypatch.setattr(record_capture, "RAW_BYTES", bytes_)
    alike(swung("integrator='RK4'"), expected[0])
    alike(swung(""), expected[1])
