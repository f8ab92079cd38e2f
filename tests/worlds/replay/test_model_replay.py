"""Replays of recordings in the whole model that they were made with: anything that moves, on anything."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.errors import ProblemError
from tests.records.audit.logs import changed

mujoco = pytest.importorskip("mujoco")
SERVOS = Path(__file__).parents[3] / "examples" / "models" / "quadruped_servos.xml"
CRATE = (
    "<mujoco><option cone='{cone}'/><worldbody><geom type='plane' size='9 9 1' friction='{mu}'/>{more}"
    "<body name='crate' pos='0 0 .1001'><freejoint/><geom type='box' size='.1 .1 .1' friction='{mu}'/></body>"
    "</worldbody></mujoco>"
)


def crate(mu: float = 0.5, cone: str = "pyramidal", more: str = "") -> Any:
    return mujoco.MjModel.from_xml_string(CRATE.format(mu=mu, cone=cone, more=more))


def run(model: Any, steps: int, speed: float = 0.0, hook: Any = lambda *_: None) -> Any:
    """Return the log of a loop, which begins with a speed."""
    data = mujoco.MjData(model)
    if model.nkey:
        data.qpos[:] = model.key_qpos[0]
    data.qvel[0] = speed
    with sf.record(model, data, "crate" if model.nu == 0 else None) as log:
        for step in range(steps):
            hook(model, data, step)
            mujoco.mj_step(model, data)
    return log


def test_a_thrown_crate_tumbles_in_mujoco_alone() -> None:
    """By Coulomb's law it slides on upright, v t - mu g t²/2: no figure of ours."""
    model = crate(0.7)
    log = run(model, 900, 8.0)
    own = sf.replay_log(log, "mujoco", model=model)
    assert own.survives, own.sentence
    assert max(w.drift for w in own.windows) < 1e-6  # the same steps again
    report = sf.replay_log(log, "mujoco-exact", model=model)
    assert report.verdict == "lost"
    assert "the motion is lost in the world mujoco-exact: it leans" in report.sentence
    q, end = report.logs[0]["q"], float(report.logs[0]["time"][-1])
    assert q[-1, 0] - q[0, 0] == pytest.approx(8.0 * end - 0.5 * 0.7 * 9.81 * end**2, rel=1e-2)
    assert np.abs(q[:, 2] - 0.1).max() < 1e-3


def test_a_crate_that_slides_survives() -> None:
    model = crate(0.5, "elliptic")
    report = sf.replay_log(run(model, 400, 0.5), "mujoco-exact", model=model)
    assert report.survives, report.sentence


@pytest.fixture(scope="module")
def quadruped() -> tuple[Any, Any]:
    """Return a model on servos that stands on a step and is pushed, and the log of its loop."""
    model = mujoco.MjModel.from_xml_string(
        SERVOS.read_text(encoding="utf-8").replace(
            "</worldbody>",
            "<geom type='box' size='2 2 .05' pos='0 0 .05'/><body name='ball' pos='.6 0 .15'><freejoint/>"
            "<geom size='.05'/></body></worldbody>",
        )
    )
    data, q = mujoco.MjData(model), sf.place(sf.load_robot(SERVOS, feet=["FL", "FR", "RL", "RR"]))
    data.qpos[: len(q)] = q
    data.qpos[2] += 0.1
    data.qpos[3:7] = [1.0, 0.0, 0.0, 0.0]
    data.qvel[18] = -0.3  # the ball rolls towards it
    with sf.record(model, data) as log:
        for k in range(500):
            data.ctrl[:] = q[7:] + 0.03 * np.sin(0.02 * k) * np.tile([0.0, 1.0, -2.0], 4)
            data.xfrc_applied[1, 1] = 20.0 * (150 <= k < 200)
            mujoco.mj_step(model, data)
    return model, log


@pytest.mark.long
def test_a_robot_on_a_step_beside_a_ball_is_replayed_whole(
    quadruped: tuple[Any, Any], tmp_path: Path
) -> None:
    model, log = quadruped
    assert log["others_q"].shape == (500, 7)
    log.save(tmp_path / "run.npz")
    read = sf.read_log(tmp_path / "run.npz")
    for world in ("mujoco", "mujoco-exact"):
        report = sf.replay_log(read, world, model=tmp_path / "run.mjb")
        assert report.survives, report.sentence
        assert max(w.drift for w in report.windows) < 0.01
        again = report.logs[0]
        assert (again["pushed_body"] >= 0.0).sum() == 50
        assert not model.opt.disableflags  # the model of the caller is as it was
    with pytest.raises(ProblemError, match=r"no fact terrain|more bodies|give terrain"):
        sf.replay_log(read, "mujoco-exact")


def _drop(name: str) -> Any:
    def spoil(log: Any) -> Any:
        return sf.Log({k: a for k, a in log.arrays.items() if not k.startswith(name)}, dict(log.facts))

    return spoil


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (_drop("others"), "more than its robot moves in its model"),
        (_drop("com"), "no channel com"),
        (lambda log: changed(log, {"kind": "walk"}), "this is another log"),
        (lambda log: changed(log, {"model_masses": 2.0 * log.facts["model_masses"]}), "other masses"),
        (lambda log: changed(log, {"joints": [f"j{k}" for k in range(12)]}), "no robot trunk of the same"),
        (lambda log: changed(log, {"change_kind": ["friction"]}), "changed the friction of its model"),
        (lambda log: changed(log, time=np.asarray(log["time"]) * 1.01), "no steps of"),
    ],
    ids=["others", "com", "kind", "masses", "joints", "changed", "time"],
)
def test_what_cannot_be_replayed_in_a_model_is_said(
    quadruped: tuple[Any, Any], spoil: Any, said: str
) -> None:
    model, log = quadruped
    with pytest.raises(ProblemError, match=f"the log cannot be replayed in its model: .*{said}"):
        sf.replay_log(spoil(log), "mujoco-exact", model=model)


def test_options_of_another_ground_are_not_for_a_model(quadruped: tuple[Any, Any]) -> None:
    model, log = quadruped
    with pytest.raises(ProblemError, match="the model's own"):
        sf.replay_log(log, "mujoco", mu=0.3, model=model)
    with pytest.raises(ProblemError, match="mujoco-exact"):
        sf.replay_log(log, "rigid", model=model)


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ("<body mocap='true'><geom size='.01' contype='0' conaffinity='0'/></body>", "moved by hand"),
        ("<body name='fan' pos='1 0 1'><joint name='turn'/><geom size='.1'/></body>", "moves more than"),
    ],
    ids=["mocap", "fan"],
)
def test_what_the_log_does_not_drive_is_refused(more: str, said: str) -> None:
    """The torques of a body that is not the robot's are not in its log."""
    text = CRATE.format(mu=0.5, cone="elliptic", more=more)
    if "turn" in more:
        text = text.replace("</worldbody>", "</worldbody><actuator><motor joint='turn'/></actuator>")
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    with sf.record(model, data, "crate") as log:
        for _ in range(20):
            mujoco.mj_step(model, data)
    with pytest.raises(ProblemError, match=said):
        sf.replay_log(log, "mujoco", model=model)
