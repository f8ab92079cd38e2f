"""Logs of vector environments, of rollouts that C makes, and of contacts as MJX and Warp keep them."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.arrays import FloatArray

mujoco = pytest.importorskip("mujoco")
SCENE = """<mujoco><option timestep='.002' cone='{cone}'/><worldbody>
<geom name='floor' type='plane' size='5 5 1'/>
<body name='crate' pos='0 0 {height}'><freejoint/>
<geom name='shell' type='box' size='.2 .2 .1' mass='5'/></body>
<body pos='2 0 .1'><freejoint/><geom size='.1' mass='.5'/></body>
</worldbody></mujoco>"""
CHANNELS = ("forces", "gaps", "contact_velocities", "contact_friction")
FIELDS = ("dist", "pos", "frame", "geom", "friction", "dim", "efc_address")


def _model(cone: str = "elliptic", height: float = 0.102) -> Any:
    return mujoco.MjModel.from_xml_string(SCENE.format(cone=cone, height=height))


def _thrown(model: Any, speed: float) -> Any:
    data = mujoco.MjData(model)
    data.qvel[:3] = [speed, 0.3 * speed, 0.0]
    return data


def _state(model: Any, data: Any) -> FloatArray:
    kind = mujoco.mjtState.mjSTATE_FULLPHYSICS
    out = np.zeros(mujoco.mj_stateSize(model, kind))
    mujoco.mj_getState(model, data, out, kind)
    return out


def _contacts(model: Any, speeds: tuple[float, ...], steps: int, size: int) -> tuple[dict[str, Any], ...]:
    """Contacts, constraints' forces and states of loops as a device keeps them: padded, (T, N, ...)."""
    shapes = {
        "dist": (),
        "pos": (3,),
        "frame": (9,),
        "geom": (2,),
        "friction": (5,),
        "dim": (),
        "efc_address": (),
    }
    contact = {n: np.full((steps, len(speeds), size, *s), -1.0) for n, s in shapes.items()}
    rest = {
        "efc_force": np.zeros((steps, len(speeds), 8 * size)),
        "qpos": np.zeros((steps, len(speeds), model.nq)), "qvel": np.zeros((steps, len(speeds), model.nv)),
    }  # fmt: skip
    for k, speed in enumerate(speeds):
        data = _thrown(model, speed)
        for t in range(steps):
            rest["qpos"][t, k], rest["qvel"][t, k] = data.qpos, data.qvel
            mujoco.mj_step(model, data)
            rest["efc_force"][t, k, : data.nefc] = data.efc_force
            for name in FIELDS:
                contact[name][t, k, : data.ncon] = getattr(data.contact, name)
    return contact, rest


@pytest.mark.parametrize("cone", ["elliptic", "pyramidal"])
def test_arrays_of_contacts_are_the_recordings(cone: str) -> None:
    """Forces, gaps, velocities of every corner, in contact axes; other bodies' contacts are left out."""
    model, speeds, steps = _model(cone), (0.5, 1.0), 120
    contact, rest = _contacts(model, speeds, steps, 7)
    arrays = sf.rl.contact_arrays(model, contact, **rest)
    same = sf.rl.contact_arrays(model, SimpleNamespace(**contact), **rest)
    for name in CHANNELS:
        np.testing.assert_array_equal(arrays[name], same[name])
    for k, speed in enumerate(speeds):
        data = _thrown(model, speed)
        with sf.record(model, data) as log:
            for _ in range(steps):
                mujoco.mj_step(model, data)
        found, expected = arrays["forces"][:, k], log["forces"]
        # corners may be named in another order: their loads, and their sum
        np.testing.assert_allclose(found.sum(axis=1), expected.sum(axis=1), atol=1e-9)
        loads, told = (np.sort(f[..., 2], axis=1)[:, -4:] for f in (found, expected))
        np.testing.assert_allclose(loads, told, atol=1e-9)
        on, off = found[..., 2] > 0.0, expected[..., 2] > 0.0
        for name in ("gaps", "contact_friction"):
            np.testing.assert_allclose(
                np.where(on, arrays[name][:, k], 0.0).sum(axis=1), np.where(off, log[name], 0.0).sum(axis=1),
                atol=1e-9,
            )  # fmt: skip
        speeds_of = [
            np.where(w[..., None], v, 0.0).sum(axis=1)
            for w, v in ((on, arrays["contact_velocities"][:, k]), (off, log["contact_velocities"]))
        ]
        np.testing.assert_allclose(*speeds_of, atol=1e-9)
    facts = {name: log.facts[name] for name in ("sinking", "creep", "stopping", "settling")}
    report = sf.audit_batch(arrays, 0.002, mass=log.fact("mass"), facts=facts)
    assert "broken" not in report.verdicts
    contact["friction"] *= 0.2  # ground that has not what the forces need
    told = sf.rl.contact_arrays(model, contact, **rest)
    told["forces"] = told["forces"].copy()
    told["forces"][..., :2] = arrays["forces"][..., :2]
    report = sf.audit_batch(told, 0.002, mass=log.fact("mass"), facts=facts)
    assert report.verdicts == ("broken", "broken")
    assert report["friction"].share.min() > 0.1


def test_arrays_of_contacts_that_do_not_fit() -> None:
    """One line each: what is missing, which shape, another model."""
    model = _model()
    contact, rest = _contacts(model, (0.5,), 3, 6)
    short = {name: array for name, array in contact.items() if name != "geom"}
    for given, more, match in (
        (short, rest, "contact has no geom"),
        (contact, {**rest, "qpos": rest["qpos"][..., :3]}, r"qpos must have shape \(T, N, 14\)"),
        (contact, {**rest, "qvel": rest["qvel"][:2]}, r"qvel is of \(2, 1\)"),
        ({**contact, "dist": contact["dist"][:2]}, rest, r"dist must have shape \(3, 1, c\)"),
        ({**contact, "geom": contact["geom"] + 50}, rest, "geom must be below 3"),
        ({**contact, "dim": contact["dim"][:, :, :2]}, rest, "the same number of contacts"),
    ):
        with pytest.raises(sf.SurefootError, match=match):
            sf.rl.contact_arrays(model, given, **more)
    with pytest.raises(sf.SurefootError, match="takes an MjModel, got int"):
        sf.rl.contact_arrays(3, contact, **rest)
    nothing = sf.rl.contact_arrays(model, {**contact, "geom": np.full_like(contact["geom"], -1)}, **rest)
    assert nothing["forces"].shape == (3, 1, 0, 3)


def test_rollouts_of_c_are_logs() -> None:
    """The log of a rollout is that of the same loop in Python; states of another one are refused."""
    from mujoco import rollout

    model = _model()
    starts = np.stack([_state(model, _thrown(model, speed)) for speed in (0.4, 0.9)])
    states, _ = rollout.rollout(model, mujoco.MjData(model), starts, nstep=80)
    logs = sf.rl.log_rollouts(model, starts, nstep=80, state=states)
    data = _thrown(model, 0.9)
    with sf.record(model, data) as log:
        for _ in range(80):
            mujoco.mj_step(model, data)
    assert [len(one) for one in logs] == [80, 80]
    for name in ("forces", "q", "v", "gaps"):
        np.testing.assert_array_equal(logs[1][name], log[name])
    assert sf.audit_log(logs[0]).verdict == sf.audit_log(log).verdict != "broken"
    assert not logs[1].facts.get("unseen_steps")
    with pytest.raises(sf.SurefootError, match="leave the rollout's states at step 0"):
        sf.rl.log_rollouts(model, starts[::-1], nstep=80, state=states)
    for given, match in (
        ({"initial_state": starts[:, :5], "nstep": 3}, r"initial_state must have shape \(n, 27\)"),
        ({"initial_state": starts}, "say nstep"),
        ({"initial_state": starts, "control": np.zeros((2, 9, 3))}, r"control must have shape \(2, T, 0\)"),
        (
            {"initial_state": starts, "nstep": 80, "state": states[:, :3]},
            r"state must have shape \(2, 80, 27\)",
        ),
    ):
        with pytest.raises(sf.SurefootError, match=match):
            sf.rl.log_rollouts(model, **given)


@pytest.mark.long
def test_vector_environments_are_recorded() -> None:
    """A log of each of a vector environment's; its workers hand theirs over by info."""
    gymnasium = pytest.importorskip("gymnasium")
    from .test_audit_wrapper import Ball

    envs = gymnasium.vector.SyncVectorEnv([lambda: Ball(length=20) for _ in range(3)])
    envs.reset(seed=0)
    with sf.record(envs) as logs:
        for _ in range(10):
            envs.step(envs.action_space.sample())
    assert [len(log) for log in logs] == [50, 50, 50]
    assert all(log.facts["feet"] == ["skin"] for log in logs)
    one = Ball()
    one.reset(seed=0)
    with sf.record(one) as log:
        one.step(one.action_space.sample())
    np.testing.assert_array_equal(log["forces"], logs[0][:5]["forces"])
    with pytest.raises(sf.SurefootError, match="or an environment, got int alone"):
        sf.record(3)
    far = gymnasium.vector.AsyncVectorEnv([lambda: sf.rl.RecordWrapper(Ball(length=4)) for _ in range(2)])
    try:
        far.reset(seed=0)
        for _ in range(4):
            *_, infos = far.step(far.action_space.sample())
        assert [len(log) for log in infos["log"]] == [20, 20]
        assert infos["_log"].all()
        with pytest.raises(sf.SurefootError, match="cannot reach the environments of AsyncVectorEnv"):
            sf.record(far)
    finally:
        far.close()


def test_episodes_of_a_recorded_environment() -> None:
    """Each episode is a log; one that is given up is in the info of the reset."""
    gymnasium = pytest.importorskip("gymnasium")
    from .test_audit_wrapper import Ball

    env = sf.rl.RecordWrapper(Ball(length=3))
    _, info = env.reset(seed=0)
    assert "log" not in info
    ends = [env.step(env.action_space.sample())[4].get("log") for _ in range(3)]
    assert ends[:2] == [None, None]
    assert len(ends[2]) == 15
    env.reset()
    env.step(env.action_space.sample())
    _, info = env.reset()
    assert len(info["log"]) == 5
    assert sf.audit_log(info["log"]).verdict != "broken"
    env.step(env.action_space.sample())
    env.close()
    with pytest.raises(sf.SurefootError, match=r"RecordWrapper takes an environment with MuJoCo's .model"):
        sf.rl.RecordWrapper(gymnasium.Env())
